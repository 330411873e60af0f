"""A graded run: the world half here, with truth and trace, the robot half in a worker."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from robsim import _core
from robsim._core import RobotModel
from robsim.base.checks import check_int
from robsim.base.seeds import Seed, stream_number
from robsim.base.source_line import SourceLine
from robsim.campaigns.choices import WholeRun
from robsim.simulation import FailedCallback, Scenario, Simulation
from robsim.simulation.callbacks.errors import callback_of
from robsim.simulation.slots import SLOTS, are_samples_given
from robsim.simulation.slotted import is_code
from robsim.simulation.world.world_of_scenario import frame_size
from robsim.teach.errors import AssignmentError, GradingError, SubmissionError
from robsim.teach.grading._frame_memory import FrameMemory, has_frame_memory
from robsim.teach.grading._wire import Ready
from robsim.teach.grading._worker import Worker, done
from robsim.teach.grading.calling import calling, world_slots
from robsim.teach.grading.keys import Key, RunSeeds
from robsim.teach.grading.robot_half import STAGES, Setup
from robsim.teach.grading.task import WORLD_SLOTS, Done, Task, given_to
from robsim.teach.submissions import loaded_slots
from robsim.teach.texts import error_text
from robsim.trace import RunInfo, Trace

LARGEST_INPUT = 12.0  # V


class GradedSimulation(Simulation):
    """A simulation with some slots in a worker."""

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
        # Samples of the truth reveal the robot's pose: they are for an estimator of parameters.
        self._gives_samples = are_samples_given(scenario.identify_from, filled)
        sends_frames = given_to(filled, task.frames) != "pose"
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


def graded_run(task: Task, scenario: Scenario, steps: int, seeds: RunSeeds) -> Done[Trace]:
    """Run a submission; return its trace, with the truth.

    A SubmissionError has slot, step and line, and in its attributes the printed text (``output``)
    and the steps so far (``trace``). A teacher's callback raises AssignmentError.
    """
    if task.rules.slots[0] in WORLD_SLOTS:
        with calling(task) as answering:
            return done(
                answering,
                lambda: _driven(_world(task, scenario, seeds, world_slots(answering)), steps, task),
            )
    with started(task, scenario, seeds) as worker:
        return done(worker, lambda: _driven(asking(worker, task, scenario, seeds), steps, task))


@contextmanager
def started(task: Task, scenario: Scenario, seeds: RunSeeds) -> Iterator[Worker]:
    """Yield a worker that knows a task, and end it."""
    scenario = _with_model(scenario)
    with ExitStack() as stack:
        memory = None
        may_see = given_to(task.rules.slots, task.frames) != "pose"
        if may_see and has_frame_memory():
            memory = stack.enter_context(closing(FrameMemory(frame_size(scenario))))
        yield stack.enter_context(Worker(_setup(task, scenario, seeds), task, memory))


def asking(worker: Worker, task: Task, scenario: Scenario, seeds: RunSeeds) -> GradedSimulation:
    """Return the simulation of a worker's robot half."""
    scenario = _with_model(scenario)
    ready = worker.ready()
    known = scenario._model
    assert known is not None
    if ready.model.dt != known.dt:
        raise SubmissionError(
            f"in define_model at the start: the model must have the world's dt = {known.dt:g} s, "
            f"got dt = {ready.model.dt:g} s",
            slot="define_model",
        )
    return GradedSimulation(task, scenario, seeds, worker, ready)


def _world(
    task: Task, scenario: Scenario, seeds: RunSeeds, more: Mapping[str, Any] = MappingProxyType({})
) -> Simulation:
    callbacks = {**task.callbacks, **more}
    simulation = Simulation(_with_model(scenario), seed=seeds.world, **callbacks)
    set_noise_keys(simulation, seeds)
    return simulation


def _driven(simulation: Simulation, steps: int, task: Task) -> Trace:
    """Run; report whether a failing callback is here or in the worker."""
    simulation._warns = False
    try:
        return simulation.run(steps)
    except GradingError as error:
        # No name here for the raised error: with its traceback it would keep the worker.
        raise _with_trace(error, simulation) from None
    except Exception as error:
        failed = callback_of(error)
        if failed is None:
            raise
        text = error_text(error, slot=failed.slot, step=failed.k)
        if failed.slot in task.rules.slots and failed.slot not in task.callbacks:
            told = SubmissionError(str(text), slot=failed.slot, step=failed.k)
            raise _with_trace(told, simulation) from None
        raise AssignmentError(
            f"a callback of the assignment has failed: {text}", slot=failed.slot, step=failed.k
        ) from error


def _with_trace(error: GradingError, simulation: Simulation) -> GradingError:
    """Return an error with the steps until then, without the loop's notes on a callback here."""
    told = error._anew()
    if isinstance(told, SubmissionError) and len(simulation.trace):
        told.trace = simulation.trace
    return told


def set_noise_keys(simulation: Simulation, seeds: RunSeeds) -> None:
    if seeds.noise_keys is not None:
        simulation._world.set_noise_keys(seeds.noise_keys)


def _with_model(scenario: Scenario) -> Scenario:
    return scenario if scenario.model is not None else scenario.replace(model=RobotModel())


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
        # Otherwise it gets the parameters: it must not see the samples of the truth.
        estimates_parameters=given["estimate_parameters"] is True
        and are_samples_given(scenario.identify_from, task.rules.slots),
        controller_seed=stream_number(seeds.robot, "controller"),
        frames=task.frames,
    )


@contextmanager
def all_here(task: Task, scenario: Scenario, seeds: RunSeeds) -> Iterator[Simulation]:
    """Yield a simulation that has all in this process, and trusts the submission.

    Its results equal a worker's results to the byte if the worker gets the same samples.
    """
    simulation = _world(task, scenario, seeds)
    with loaded_slots(task.submission, task.rules) as callbacks:
        for slot in SLOTS:
            if slot in callbacks:
                value = callbacks[slot]
                simulation._set_slot(slot, None if value is False else value)
        if is_code(simulation._callbacks["control"]):
            simulation._core.set_controller_seed(stream_number(seeds.robot, "controller"))
        yield simulation


@dataclass(frozen=True)
class GradedRuns(WholeRun):
    """Graded runs for a campaign."""

    task: Task
    key: Key | None
    student: str
    test: str

    def trace(
        self, scenario: Scenario, steps: int, *, seed: np.random.SeedSequence, run: int
    ) -> Trace:
        given = seed if self.key is None else None
        seeds = seeds_of(self.key, self.student, self.test, run, steps, given)
        try:
            return graded_run(self.task, scenario, steps, seeds).result
        except SubmissionError as error:  # a row has the line of a callback
            if error.slot is not None and error.file is not None:
                line = SourceLine(error.file, error.line or 1, "")
                error.callback = FailedCallback(error.slot, error.step, line)
            raise

    @property
    def content(self) -> bytes:
        rules, files = dataclasses.asdict(self.task.rules), self.task.submission.to_message()
        return pickle.dumps((rules, self.task.frames, self.student, self.test)) + files


def seeds_of(
    key: Key | None, student: str, test: str, run: int, steps: int, seed: Seed
) -> RunSeeds:
    """Return the seeds of `seed`; else of the key, or of a new one."""
    if seed is not None:
        return RunSeeds.of(seed)
    check_int("number", run, minimum=0, maximum=2**62)
    return RunSeeds.of_key(key or Key.new(), student, test, run, steps)
