"""A run that is graded: the world half here, with truth and trace, the robot half in a worker."""

from __future__ import annotations

import dataclasses
import glob
import importlib.util
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robsim import _core
from robsim._base.seeds import stream_number
from robsim._core import RobotModel
from robsim.grading._errors import AssignmentError, SubmissionError
from robsim.grading._frame_memory import FrameMemory, has_frame_memory
from robsim.grading._isolation import Isolation, Limits
from robsim.grading._robot_half import STAGES, Setup
from robsim.grading._seeds import RunSeeds
from robsim.grading._submissions import Rules, SubmissionFiles, loaded_slots
from robsim.grading._texts import clean_text, error_text
from robsim.grading._wire import Ready
from robsim.grading._worker import Worker
from robsim.simulation import Scenario, Simulation
from robsim.simulation._callbacks.errors import callback_of
from robsim.simulation._slots import SLOTS
from robsim.simulation._slotted import is_code
from robsim.simulation._world.world_of_scenario import frame_size
from robsim.trace import RunInfo, Trace

LARGEST_INPUT = 12.0  # V


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is the same in all graded runs of a submission.

    Attributes
    ----------
    submission : SubmissionFiles
        What was read of it.
    rules : Rules
        What it may fill and import.
    frames : bool or None
        Whether it sees the frames; None = if it fills `measure`.
    limits : Limits
        What a run may take.
    isolation : str
        How its process is shut in.
    callbacks : mapping of str to callback
        What the teacher fills other slots with.
    """

    submission: SubmissionFiles
    rules: Rules
    frames: bool | None = None
    limits: Limits = field(default_factory=Limits)
    isolation: Isolation = "auto"
    callbacks: Mapping[str, Any] = field(default_factory=dict)


class GradedSimulation(Simulation):
    """A simulation in which some slots are filled by a worker."""

    def __init__(
        self, task: Task, scenario: Scenario, seeds: RunSeeds, worker: Worker, ready: Ready
    ) -> None:
        super().__init__(scenario, seed=seeds.world, **task.callbacks)
        filled = tuple(stage for stage in STAGES if stage in ready.filled)
        self._code_there = frozenset(ready.filled)
        for slot in ready.switched_on:
            if slot not in filled:
                self._set_slot(slot, True)
        self._set_slot("define_model", ready.model)
        set_noise_keys(self, seeds)
        self._gives_samples = scenario.identify_from != "truth" or (
            # Of the truth they are for a parameter estimator alone: they tell where the robot goes.
            "estimate_parameters" in filled or self._callbacks["estimate_parameters"] is True
        )
        self._ask(worker, filled, ready, frames=task.frames)

    def _ask(
        self, worker: Worker, filled: tuple[str, ...], ready: Ready, *, frames: bool | None
    ) -> None:
        """Fill the slots that the worker fills."""
        sends_frames = "measure" in filled if frames is None else frames
        if worker.memory is not None and sends_frames:
            self._world.set_frame_memory(worker.memory.images)
        robot = _core.RemoteRobot(
            worker.exchange,
            worker.refuse,
            world=self._world,
            slots=filled,
            sends_frames=sends_frames,
            sends_samples=self._gives_samples,
            measures_first=self._callbacks["measure"] is True and "measure" not in filled,
            has_standard_errors=ready.has_standard_errors,
            largest_input=LARGEST_INPUT,
        )
        for slot in filled:
            self._core.set_slot(slot, robot)
            self._callbacks[slot] = robot
        if "estimate_parameters" in filled:
            self._core.set_slot("init_parameter_estimator", robot)

    def _info(self) -> RunInfo:
        code = (slot for slot in self.SLOTS if self._is_code(slot))
        return dataclasses.replace(super()._info(), callbacks=tuple(code))

    def _is_code(self, slot: str) -> bool:
        return slot in self._code_there or is_code(self._callbacks[slot])


@dataclass(frozen=True)
class GradedRun:
    """What came of a run.

    Attributes
    ----------
    trace : Trace
        The run, with the truth.
    output : str
        What the submission has printed, cut; what cannot be seen stands as escapes.
    layers : str
        What has shut it in, in a line.
    """

    trace: Trace
    output: str
    layers: str


def graded_run(task: Task, scenario: Scenario, steps: int, seeds: RunSeeds) -> GradedRun:
    """Run a submission.

    Raises
    ------
    SubmissionError
        If the submission fails, with slot, step and line; the attribute ``output`` has what it
        had printed.
    AssignmentError
        If a callback of the teacher's fails.
    """
    with started(task, scenario, seeds) as worker:
        try:
            trace = _driven(asking(worker, task, scenario, seeds), steps)
        except SubmissionError as error:
            worker.close()
            error.output = printed_by(worker)
            raise
        worker.end()
    return GradedRun(trace, printed_by(worker), worker.process.layers.line)


def printed_by(worker: Worker) -> str:
    """Return what a submission has printed, as text that is harmless."""
    text = worker.process.output
    return clean_text(text, 2 * len(text) + 100)


@contextmanager
def started(task: Task, scenario: Scenario, seeds: RunSeeds) -> Iterator[Worker]:
    """Give a worker that has been told of a task, and end it."""
    scenario = _with_model(scenario)
    with ExitStack() as stack:
        memory = None
        may_see = "measure" in task.rules.slots if task.frames is None else task.frames
        if may_see and has_frame_memory():
            memory = stack.enter_context(FrameMemory(frame_size(scenario)))
        worker = Worker(
            _setup(task, scenario, seeds),
            memory=memory,
            limits=task.limits,
            isolation=task.isolation,
            hidden=hidden_files(task.rules),
        )
        yield stack.enter_context(worker)


def asking(worker: Worker, task: Task, scenario: Scenario, seeds: RunSeeds) -> GradedSimulation:
    """Return the simulation whose robot half a worker has."""
    scenario = _with_model(scenario)
    ready = worker.ready()
    _check_dt(ready.model, scenario)
    return GradedSimulation(task, scenario, seeds, worker, ready)


def _driven(simulation: GradedSimulation, steps: int) -> Trace:
    """Run; say whose fault it is if a callback here fails."""
    try:
        return simulation.run(steps)
    except Exception as error:
        failed = callback_of(error)
        if failed is None:
            raise
        text = error_text(error, slot=failed.slot, step=failed.k)
        raise AssignmentError(
            f"a callback of the assignment has failed: {text}", slot=failed.slot, step=failed.k
        ) from error


def hidden_files(rules: Rules) -> list[str]:
    """Return the files and folders of the modules that a submission must not have."""
    hidden = []
    for name in rules.masked:
        with suppress(ImportError, ValueError):
            found = importlib.util.find_spec(name)
            if found is not None and found.has_location and found.origin is not None:
                folders = found.submodule_search_locations
                hidden += list(folders) if folders else _files_of(found.origin)
    return hidden


def _files_of(source: str) -> list[str]:
    """Return the file of a module, and those that Python keeps of it compiled, or may."""
    levels = ("", 1, 2)
    compiled = [importlib.util.cache_from_source(source, optimization=level) for level in levels]
    others = Path(compiled[0]).parent.glob(f"{glob.escape(Path(source).stem)}.*.pyc")
    return [source, *compiled, *map(str, others)]


def set_noise_keys(simulation: Simulation, seeds: RunSeeds) -> None:
    """Give the noise of each frame a key of its own, if there are any."""
    if seeds.noise_keys is not None:
        simulation._world.set_noise_keys(seeds.noise_keys)


def _with_model(scenario: Scenario) -> Scenario:
    """Return a scenario whose world follows no model of a submission."""
    return scenario if scenario.model is not None else scenario.replace(model=RobotModel())


def _check_dt(model: RobotModel, scenario: Scenario) -> None:
    known = scenario._model
    assert known is not None
    if model.dt != known.dt:
        raise SubmissionError(
            f"in define_model at the start: the model must have the dt of the world, {known.dt:g} "
            f"s, got {model.dt:g}",
            slot="define_model",
        )


def _setup(task: Task, scenario: Scenario, seeds: RunSeeds) -> Setup:
    switches = {"measure": scenario.measure, "estimate_parameters": scenario.estimate_parameters}
    given = switches | {"control": True} | dict(task.callbacks)
    on = tuple(stage for stage in STAGES if given.get(stage) not in (None, False))
    model = scenario._model
    assert model is not None
    return Setup(
        submission=task.submission,
        rules=task.rules,
        on=on,
        robot=scenario._robot_definition,
        area=scenario.area,
        resolution=frame_size(scenario),
        colors=scenario._color_classes,
        markers=scenario._marker_layout,
        smoothing=scenario.smoothing,
        model=model,
        estimates_parameters=given["estimate_parameters"] is True,
        controller_seed=stream_number(seeds.robot, "controller"),
    )


@contextmanager
def all_here(task: Task, scenario: Scenario, seeds: RunSeeds) -> Iterator[Simulation]:
    """Give a simulation that has all in this process, and trusts the submission.

    It gives to the byte what must come with a worker, where that is given the same samples.
    """
    simulation = Simulation(_with_model(scenario), seed=seeds.world, **task.callbacks)
    set_noise_keys(simulation, seeds)
    with loaded_slots(task.submission, task.rules) as callbacks:
        for slot in SLOTS:
            if slot in callbacks:
                value = callbacks[slot]
                simulation._set_slot(slot, None if value is False else value)
        if is_code(simulation._callbacks["control"]):
            simulation._core.set_controller_seed(stream_number(seeds.robot, "controller"))
        yield simulation
