"""A run that is graded: the world half here, with truth and trace, the robot half in a worker."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

from robsim import _core
from robsim._base.seeds import stream_number
from robsim._core import RobotModel
from robsim.grading._errors import SubmissionError
from robsim.grading._frame_memory import FrameMemory, has_frame_memory
from robsim.grading._robot_half import STAGES, Setup
from robsim.grading._seeds import RunSeeds
from robsim.grading._start import Limits
from robsim.grading._submission_files import loaded
from robsim.grading._wire import Ready
from robsim.grading._worker import Worker
from robsim.simulation import Scenario, Simulation
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
    submission : bytes
        Its sources.
    slots : tuple of str
        The slots that it may fill.
    frames : bool or None
        Whether it sees the frames; None = if it fills `measure`.
    limits : Limits
        What a run may take.
    isolation : str
        How its process is shut in; ``"none"``: there is none, it runs here.
    callbacks : mapping of str to callback
        What the teacher fills other slots with.
    """

    submission: bytes
    slots: tuple[str, ...]
    frames: bool | None
    limits: Limits
    isolation: str
    callbacks: Mapping[str, Any]


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
        self._sends_frames = "measure" in filled if task.frames is None else task.frames
        self._remote = (worker, ready, filled)

    def ask_worker(self, memory: FrameMemory | None) -> None:
        """Fill the slots that the worker fills; it sees the frames in this memory."""
        worker, ready, filled = self._remote
        images = memory.images if memory is not None and self._sends_frames else []
        if images:
            self._world.set_frame_memory(images)
        robot = _core.RemoteRobot(
            worker.exchange,
            worker.refuse,
            slots=filled,
            world=self._world,
            sends_frames=self._sends_frames,
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


def graded_run(task: Task, scenario: Scenario, steps: int, seeds: RunSeeds) -> Trace:
    """Run a submission and return the trace, with the truth.

    Raises
    ------
    SubmissionError
        If the submission fails, with slot, step and line.
    """
    scenario = _with_model(scenario)
    if task.isolation == "none":
        return _run_here(task, scenario, steps, seeds)
    with ExitStack() as stack:
        memory = None
        may_see = "measure" in task.slots if task.frames is None else task.frames
        if may_see and has_frame_memory():
            memory = stack.enter_context(FrameMemory(frame_size(scenario)))
        worker = stack.enter_context(
            Worker(
                _setup(task, scenario, seeds),
                memory=[] if memory is None else [memory.descriptor],
                limits=task.limits,
                isolation=task.isolation,
            )
        )
        ready = worker.ready()
        _check_dt(ready.model, scenario)
        simulation = GradedSimulation(task, scenario, seeds, worker, ready)
        simulation.ask_worker(memory)
        trace = simulation.run(steps)
        worker.end()
    return trace


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
        slots=task.slots,
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


def _run_here(task: Task, scenario: Scenario, steps: int, seeds: RunSeeds) -> Trace:
    """Run without a worker: what a worker must give, to the byte."""
    simulation = Simulation(scenario, seed=seeds.world, **task.callbacks)
    set_noise_keys(simulation, seeds)
    with loaded(task.submission, task.slots) as callbacks:
        for slot in SLOTS:
            if slot in callbacks:
                value = callbacks[slot]
                simulation._set_slot(slot, None if value is False else value)
        if is_code(simulation._callbacks["control"]):
            simulation._core.set_controller_seed(stream_number(seeds.robot, "controller"))
        return simulation.run(steps)
