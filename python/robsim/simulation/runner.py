"""The common base of `Simulation` and `Experiment`: the loop, its runs and its trace."""

from __future__ import annotations

import sys
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from os import PathLike
from threading import Lock
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._core import ColorClass, Frame, MarkerLayout, RobotModel, Step
from robsim.base import seeds
from robsim.base.checks import check_kind
from robsim.base.text import one_line, quoted
from robsim.base.warn import warn_user
from robsim.simulation.callbacks.errors import callback_of, note_misuse
from robsim.simulation.callbacks.missing_data import note_missing_data, unmet_needs
from robsim.simulation.callbacks.slot import held
from robsim.simulation.options import check_marker_colors, colors_value
from robsim.simulation.slots import SLOTS, are_samples_given
from robsim.simulation.slotted import Slotted, is_code
from robsim.trace import RunInfo, Trace
from robsim.trace.columns import empty_groups
from robsim.vision.markers.missed_detections import warn_of_small_markers
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot


def run_info(runner: Runner) -> RunInfo:
    """Return the description of a simulation's or an experiment's run."""
    core = runner._core
    return RunInfo(
        dt=core.model.dt if core.has_started else RobotModel().dt,
        theta_true=runner._theta_true(),
        seed=seeds.seed_record(runner._seed),
        identify_from=runner.identify_from,
        area=runner.area,
        boundary=runner.boundary,
        robot=runner.robot.name,
        marker_colors=(*runner.markers.colors.values(),),
        scenario=runner._described(),
        changed=runner._changed,
        mm_per_px=runner._mm_per_px(),
        headings=runner._headings(),
        callbacks=tuple(slot for slot, value in runner._callbacks.items() if is_code(value)),
    )


class Runner(Slotted):
    """The loop with the slots of the robot half; the subclasses add the world half."""

    #: Whether it warns of results of callbacks; a grader judges them.
    _warns = True
    #: The groups of columns of an empty trace.
    _GROUPS: ClassVar[tuple[str, ...]]

    def __init__(
        self,
        world: _core.World,
        *,
        robot: RobotDefinition,
        area: tuple[int, int],
        boundary: str,
        seed: np.random.SeedSequence,
        colors: tuple[ColorClass, ...],
        markers: MarkerLayout,
        smoothing: int | None,
        identify_from: str,
        time_limit: float | None,
    ) -> None:
        super().__init__(time_limit)
        self._robot = robot
        self.area = area
        self.boundary = boundary
        self.identify_from = identify_from
        self._colors = colors
        self._markers = markers
        self._smoothing = smoothing
        self._guarding = Lock()
        self._pulse: Callable[[int], None] | None = None
        self._seed = seed
        self._rng: np.random.Generator | None = None
        self._run_info: list[RunInfo] = []  # empty, or the one that is known by now
        self._n_resets = 0  # counted once the steps are gone
        self._is_marker_size_known = False
        self._changed: tuple[str, ...] = ()  # options, in the middle of the run
        self._warned: set[str] = set()  # doubts that were warned of
        self._world_half = world  # here the garbage collector sees into it
        self._core = _core.Loop(
            world=world,
            colors=colors,
            markers=markers,
            smoothing=smoothing,
            identify_from=identify_from,
            controller_seed=seeds.stream_number(seed, "controller"),
        )

    @property
    def robot(self) -> RobotDefinition:
        """The robot; a new value is used from the next step on."""
        return self._robot

    @robot.setter
    def robot(self, robot: str | PathLike[str] | RobotDefinition) -> None:
        if robot is None:
            raise TypeError("robot must be a name, a folder or a RobotDefinition, got None")
        self._change_vision(robot=as_robot(robot))

    @property
    def colors(self) -> tuple[ColorClass, ...]:
        """The colour classes; new values are used from the next step on."""
        return self._colors

    @colors.setter
    def colors(self, colors: str | PathLike[str] | Iterable[ColorClass]) -> None:
        if colors is None:
            raise TypeError("colors must be a path or ColorClass objects, got None")
        known = colors_value(colors)
        self._check_colors(known)
        self._change_vision(colors=known)

    @property
    def markers(self) -> MarkerLayout:
        """The positions of the markers on the robot."""
        return self._markers

    @abstractmethod
    def _change_vision(self, **changes: Any) -> None:
        """Look for another robot, or other colours, from the next step on."""

    def _look_for(
        self, robot: RobotDefinition, colors: tuple[ColorClass, ...], markers: MarkerLayout
    ) -> None:
        self._core.set_vision(colors, markers, self._smoothing)
        self._robot, self._colors, self._markers = robot, colors, markers
        self._is_marker_size_known = False

    def _give(self, given: str, slots: Iterable[str]) -> None:
        """Limit callbacks of `slots` to the graded data: frames, blobs, pose, or all."""
        is_all = given == "all"
        self._core.set_given(given, is_all or are_samples_given(self.identify_from, slots))

    def _note_change(self, names: Iterable[str]) -> None:
        """Note options that have changed, if in the middle of a run."""
        self._run_info = []
        if self._core.rows or self._core.is_running:
            self._changed = tuple(sorted({*self._changed, *names}))

    def find_blobs(self, frame: Frame) -> dict[str, list[_core.Blob]]:
        """Return the blobs of a frame, found with the colours and smoothing of this object.

        Parameters
        ----------
        frame : Frame
            The frame.

        Returns
        -------
        dict of str to list of Blob
            The blobs by colour, the largest first.

        Raises
        ------
        TypeError
            If `frame` is not a Frame.
        """
        check_kind("frame", frame, Frame)
        return _core.find_blobs(frame, self.colors, markers=self.markers, smoothing=self._smoothing)

    @abstractmethod
    def run(self, steps: int, *, progress: bool | str = False) -> Trace:
        """Run some steps; a run continues where the previous run ended."""

    def _run(self, steps: int, progress: bool | str, total: int | None) -> bool:
        """Run some steps; return whether the world has come to its end."""
        if not isinstance(progress, (bool, str)):
            raise TypeError(f"progress must be True, False or a label, got {quoted(progress)}")
        self._prepare()
        with self._doubts_told():
            is_at_end = self._run_guarded(steps, progress, total)
        self._check_marker_size()
        return is_at_end

    def _run_guarded(self, steps: int, progress: bool | str, total: int | None) -> bool:
        if not progress:
            with self._guarded():
                return self._core.run(steps, self._pulse)
        label = progress if isinstance(progress, str) else None
        before = self._core.rows
        with progress_bar(total=total, unit="step", desc=label) as bar, self._guarded():

            def show(done: int) -> None:
                bar.update(done - bar.n)
                if self._pulse is not None:
                    self._pulse(done)

            is_at_end = self._core.run(steps, show)
            bar.update(self._core.rows - before - bar.n)
        return is_at_end

    def _check_marker_size(self) -> None:
        """Warn once if the default measurement evaluates too small markers."""
        if self._is_marker_size_known or self._callbacks["measure"] is not True:
            return
        if self._core.rows and (frame := self._core.last_frame) is not None:
            self._is_marker_size_known = True
            warn_of_small_markers(self.markers, frame, self._camera_noise())

    def _camera_noise(self) -> float | None:
        """Return the standard deviation of the camera's noise (grey levels); None = not known."""
        return None

    def step(self) -> Step:
        """Run one step.

        Returns
        -------
        Step
            The data of the step for the robot's software.

        Raises
        ------
        EOFError
            If there are no more frames.
        RuntimeError
            If another thread calls `stop` before a frame comes, or already runs this object.
        """
        self._prepare()
        before = self._core.rows
        with self._doubts_told(), self._guarded():
            is_at_end = self._core.run(1, self._pulse, stops_robot=False)
        if is_at_end:
            raise EOFError("there are no more frames")
        if self._core.rows == before:
            raise RuntimeError("stop() was called before a frame came")
        self._check_marker_size()
        return self._core.last_step

    def step_stage(self) -> str:
        """Run the next stage of a step.

        Returns
        -------
        str
            Its name: ``"world"`` (the robot has moved, or a frame has come), or the name of a slot.
            Stages that are off are skipped.

        Raises
        ------
        EOFError
            If there are no more frames.
        """
        self._prepare()
        with self._doubts_told(), self._guarded():
            stage = self._core.step_stage(self._pulse)
        if stage is None:
            raise EOFError("there are no more frames")
        return stage

    def stop(self) -> bool:
        """End the current run between two steps; any thread may call this.

        Returns
        -------
        bool
            False if nothing was running.
        """
        return self._core.stop()

    @property
    def is_running(self) -> bool:
        """Whether a run is in progress; any thread may read this."""
        return self._core.is_running

    @property
    def n_steps(self) -> int:
        """Number of steps recorded so far; any thread may read this."""
        return self._core.rows

    @property
    def stage(self) -> str:
        """Name of the current or next stage; any thread may read this.

        See `step_stage` for the names; ``"send"``: the input is being sent.
        """
        return self._core.stage

    @contextmanager
    def _looking_up(self, pulse: Callable[[int], None]) -> Iterator[None]:
        """Call `pulse` about every 50 ms during runs in this context; it may stop the runs."""
        self._pulse, before = pulse, self._pulse
        try:
            yield
        finally:
            self._pulse = before

    def _watched(self) -> AbstractContextManager[None]:
        """Enforce the time limit with one watchdog on all steps and runs in the context."""
        return nullcontext() if self._time_limit is None else self._time_limit.watching()

    @contextmanager
    def _doubts_told(self) -> Iterator[None]:
        """Warn afterwards of implausible results of callbacks, once per run."""
        has_failed = True
        try:
            yield
            has_failed = False
        finally:
            # Where warnings are errors, none takes the place of an error.
            with suppress(Warning) if has_failed else nullcontext():
                if not self._core.is_running:
                    self._tell_doubts()

    @property
    def _doubts(self) -> list[str]:
        """Warnings of the run so far, such as of implausible results; any thread may read this."""
        return self._core.doubts

    def _tell_doubts(self) -> None:
        for doubt in self._doubts if self._warns else ():
            if doubt not in self._warned:
                self._warned.add(doubt)
                warn_user(doubt)

    def _start(self) -> None:
        if not self._core.has_started:
            with self._guarded():
                self._core.start()

    def _prepare(self) -> None:
        self._reload_folder()
        self._check_stages()

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        """Let callbacks import the helper modules of their folder, and enforce the time limit."""
        if not self._guarding.acquire(blocking=False):  # the core raises if it is running
            yield
            return
        with ExitStack() as stack:
            stack.callback(self._guarding.release)
            stack.enter_context(held(self._callbacks.values()))
            if self._folder is not None:
                stack.enter_context(self._folder.importable())
            if self._time_limit is not None:
                stack.enter_context(self._time_limit.watching())
            try:
                yield
            except Exception as error:
                if callback_of(error) is not None and self._core.has_started:
                    note_missing_data(error, self._core.last_step, self._is_on)
                    note_misuse(error, self._core.last_step)
                raise

    def reset(self, *, seed: seeds.Seed = None) -> None:
        """Return to the start; the next run begins with step 0.

        Parameters
        ----------
        seed : int, SeedSequence or Generator, optional
            Seed of the next run. Default: the same seed, which repeats the last run exactly if no
            callback keeps its own state.
        """
        new_seed = None if seed is None else seeds.seed_sequence(seed)
        callbacks = self._folder.load() if self._folder else None
        self._core.reset()
        self._n_resets += 1
        if new_seed is not None:
            self._seed = new_seed
            self._seed_core()
        if callbacks is not None:
            self._use(callbacks)
        self._forget_run()

    def _forget_run(self) -> None:
        """Forget the data of removed steps."""
        self._rng = None
        self._run_info = []
        self._changed = ()
        self._warned = set()

    def _seed_core(self) -> None:
        self._core.set_controller_seed(seeds.stream_number(self._seed, "controller"))

    def _slots_changed(self) -> None:
        self._run_info = []

    def _check_colors(self, colors: tuple[ColorClass, ...]) -> None:
        if self._callbacks["measure"] is True:
            check_marker_colors(self.markers, colors, "the default measurement")

    def _check_stages(self) -> None:
        """Raise the error that prevents a run from continuing, or warn of it."""
        self._check_slots()

    def _check_slots(self) -> None:
        self._check_colors(self.colors)
        if self._is_on("estimate_parameters"):
            self._check_source()
        for slot in self.SLOTS:
            if (problem := unmet_needs(slot, self._callbacks[slot], self._is_on)) is not None:
                self._lacks(problem)

    def _lacks(self, problem: str) -> None:
        """Raise ValueError if a callback needs data that no slot gives."""
        raise ValueError(problem)

    def _check_source(self) -> None:
        """Raise ValueError if the source of the poses for parameter estimation is off."""
        needed = {"measurement": "measure", "estimate": "estimate_state"}.get(self.identify_from)
        if needed and not self._is_on(needed):
            remedy = {
                "measure": "measure=True, or --measure in the shell",
                "estimate_state": "estimate_state=..., or in the shell a folder with an enabled "
                "estimate_state.py, as from robsim new",
            }[needed]
            raise ValueError(
                "identify_from: parameter estimation needs the "
                f"{self.identify_from}, but the stage {needed} is off: give {remedy}"
            )

    @property
    def trace(self) -> Trace:
        """All steps since the start, as arrays."""
        return Trace(self._core.columns() or empty_groups(self._GROUPS), self._info())

    def _info(self) -> RunInfo:
        known = self._run_info  # another thread replaces the list, and never changes it
        if known:
            return known[0]
        # Read first, because a start in another thread may just be about to define the model.
        is_settled = self._core.has_started and not self._core.is_running  # a start may fail yet
        info = run_info(self)
        if is_settled:
            known.append(info)
        return info

    def _mm_per_px(self) -> float | None:
        """Return the length of a px of the work area on the floor (mm); None = not known."""
        return None

    def _headings(self) -> int | None:
        """Return the number of drawn headings of the robot; None = any, or not known."""
        return None

    def _described(self) -> Any:
        """Return the scenario of the run, None without one."""
        return None

    @abstractmethod
    def _theta_true(self) -> ArrayLike:
        """Return the true parameters, (3, 5); NaN = not known."""

    @property
    def rng(self) -> np.random.Generator:
        """Random generator for your callbacks, derived from the seed of the run."""
        if self._rng is None:
            self._rng = np.random.default_rng(seeds.stream(self._seed, "user"))
        return self._rng

    @property
    def model(self) -> _core.RobotModel:
        """The model that the robot half believes in."""
        self._start()
        return self._core.model

    @property
    def estimator(self) -> Any:
        """The object that init_parameter_estimator returned."""
        self._start()
        return self._core.estimator

    @property
    def frame(self) -> Frame:
        """The newest camera frame. RuntimeError if none came in the last step."""
        self._start()
        frame = self._core.last_frame
        if frame is None:
            raise RuntimeError(f"no frame came in step {self._core.last_step.k}")
        return frame

    @property
    def last_step(self) -> Step:
        """The data of the last step for the robot's software."""
        self._start()
        return self._core.last_step

    @property
    def missed_detections(self) -> list[_core.MissedDetections]:
        """The reasons for missing detections by the default measurement, most frequent first."""
        return self._core.missed_detections

    def __repr__(self) -> str:
        stages = [slot for slot in self.SLOTS if SLOTS[slot].is_optional and self._is_on(slot)]
        return (
            f"<{type(self).__name__}: robot {self.robot.name!r}, {self.n_steps} steps done, "
            f"stages on: {', '.join(stages) or 'none'}>"
        )


def progress_bar(items: Iterable[Any] | None = None, **options: Any) -> Any:
    """Return a bar of tqdm, with its options, which is silent outside a terminal or notebook."""
    from tqdm.auto import tqdm

    if "desc" in options:
        options["desc"] = one_line(options["desc"])

    is_notebook = any(base.__module__ == "tqdm.notebook" for base in tqdm.__mro__)
    return tqdm(
        items,
        disable=not (is_notebook or (sys.stderr is not None and sys.stderr.isatty())),
        **options,
    )
