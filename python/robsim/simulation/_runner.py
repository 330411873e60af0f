"""What `Simulation` and `Experiment` have in common: slots, runs, the trace."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._base.seeds import Seed, seed_record, seed_sequence, stream, stream_number
from robsim._core import (
    ColorClass,
    DriveAround,
    Frame,
    MarkerLayout,
    Replay,
    Spin,
    Step,
    Unicycle,
)
from robsim.robots import RobotDefinition
from robsim.simulation import _slots as slots
from robsim.simulation._slots import Slot
from robsim.simulation._time_limit import TimeLimit
from robsim.trace import RunInfo, Trace
from robsim.trace._columns import empty_groups

if TYPE_CHECKING:
    from robsim.simulation._folders.callback_folder import CallbackFolder, Callbacks

#: Stages that run in C++.
NATIVE = (Spin, DriveAround, Replay, Unicycle)


class Runner(ABC):
    """The loop with the slots of the robot half; the subclasses add the world half."""

    #: The slots that there are.
    SLOTS: ClassVar[tuple[str, ...]] = slots.ROBOT
    #: The groups of columns of an empty trace.
    _GROUPS: ClassVar[tuple[str, ...]]

    define_model = Slot("Once: ``define_model() -> RobotModel``.")
    init_parameter_estimator = Slot("Once: ``init_parameter_estimator(model) -> estimator``.")
    estimate_parameters = Slot("Each step: ``estimate_parameters(step) -> (3, 5) or None``.")
    measure = Slot("Each step: ``measure(step) -> Measurement or None``.")
    estimate_state = Slot("Each step: ``estimate_state(step) -> Estimate``.")
    control = Slot("Each step: ``control(step) -> (u1, u2)`` in V.")

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
        self.robot = robot
        self.area = area
        self.boundary = boundary
        self.identify_from = identify_from
        self.colors = colors
        self.markers = markers
        self._smoothing = smoothing
        self._time_limit = None if time_limit is None else TimeLimit(time_limit)
        self._is_guarded = False
        self._folder: CallbackFolder | None = None
        self._from_folder: set[str] = set()
        self._seed = seed
        self._rng: np.random.Generator | None = None
        self._run_info: RunInfo | None = None
        self._changed: tuple[str, ...] = ()  # options, in the middle of the run
        self._callbacks: dict[str, Any] = dict.fromkeys(self.SLOTS)
        self._given: dict[str, Any] = dict(self._callbacks)
        self._world_half = world  # here the garbage collector sees into it
        self._core = _core.Loop(
            world=world,
            colors=colors,
            markers=markers,
            smoothing=smoothing,
            identify_from=identify_from,
            controller_seed=stream_number(seed, "controller"),
        )

    def _fill_slots(self, given: dict[str, Any]) -> None:
        """Fill the slots with what was given for them, or the default."""
        self._given = {slot: given[slot] for slot in self.SLOTS}
        for slot, value in self._given.items():
            # An estimator of the user's has switched estimate_parameters on by then.
            if value is not None or self._callbacks[slot] is None:
                self._set_slot(slot, value)

    @classmethod
    def from_folder(
        cls,
        folder: str | PathLike[str],
        *,
        slots: str | Iterable[str] | None = None,
        **options: Any,
    ) -> Self:
        """Return a runner with the callbacks of a folder, as written by ``robsim new``.

        When a file of the folder has changed, the next run or reset reloads all of them. If one
        fails, the runner is unchanged. A callback given here for a slot, or ``"default"``,
        overrides the file; True does not: it applies if the file is missing or has
        ``ENABLED = False``.

        Parameters
        ----------
        folder : path
            The folder: ``control.py``, ``measure.py`` and so on, named after the slots.
        slots : str or iterable of str, optional
            The slots that the folder may fill; files for other slots are not even executed.
            Default: all slots of the class.
        **options
            The options of the class.

        Raises
        ------
        FileNotFoundError
            If there is no such folder.
        ValueError
            If it has no callback files, a file does not define the callback it is named after, or
            a slot is unknown.
        SyntaxError
            If a file is not valid Python; the message has its name and the line.
        """
        from robsim.simulation._folders.callback_folder import CallbackFolder
        from robsim.simulation._slots import checked_slots

        wanted = cls.SLOTS if slots is None else checked_slots(slots, cls.SLOTS)
        runner = cls(**options)
        runner._folder = CallbackFolder(folder, wanted)
        runner._load_folder()
        return runner

    def _load_folder(self) -> None:
        assert self._folder is not None
        self._use(self._folder.load())

    def _use(self, callbacks: Callbacks) -> None:
        """Fill the slots with the callbacks of the folder."""
        for slot in self.SLOTS:
            is_fixed = slot in slots.ONCE and self._core.has_started
            is_open = self._given[slot] is None or self._given[slot] is True
            if slot in self._from_folder | callbacks.keys() and is_open and not is_fixed:
                # A file that is switched off counts as missing.
                callback = callbacks.get(slot, False)
                self._set_slot(slot, self._given[slot] if callback is False else callback)
        self._from_folder = set(callbacks)

    def __setattr__(self, name: str, value: Any) -> None:
        is_made = "_core" in self.__dict__
        is_known = name.startswith("_") or isinstance(
            getattr(type(self), name, None), (Slot, property)
        )
        if is_made and not is_known:
            kind = type(self).__name__
            raise AttributeError(
                f"{kind} has no slot {name!r}: there are {', '.join(self.SLOTS)}; "
                f"options are given to {kind}(...)"
            )
        super().__setattr__(name, value)

    def _set_slot(self, slot: str, callback: Any) -> None:
        if slot in slots.ONCE and self._core.has_started:
            raise RuntimeError(
                f"{slot} runs only at the start of a simulation: call sim.reset() first"
            )
        value = self._default(slot) if callback is None or slots.is_default(callback) else callback
        if slots.is_default(callback) and slot in slots.SWITCHES:
            value = True
        self._put(slot, value)
        self._callbacks[slot] = value
        self._run_info = None
        update = self._callbacks["estimate_parameters"]
        if slot == "init_parameter_estimator" and value and (update is None or update is True):
            # An estimator of the user's is meant to be used.
            self._set_slot("estimate_parameters", True)

    def _default(self, slot: str) -> Any:
        """Return what fills a slot that nothing is given for; None = the core's own default."""
        return None

    def _put(self, slot: str, value: Any) -> None:
        """Put a value into the slot of the C++ core."""
        self._core.set_slot(slot, self._limited(self._stage(slot, value)))

    def _stage(self, slot: str, callback: Any) -> Any:
        """Return the stage that the C++ core gets for a callback."""
        is_users = slot == "estimate_parameters" and self._callbacks["init_parameter_estimator"]
        if callback is True and is_users and self._time_limit:
            return _update_estimator  # in Python, where the time limit applies
        return callback

    def _limited(self, callback: Any) -> Any:
        # Native stages need no limit.
        if self._time_limit is None or not _is_code(callback):
            return callback
        return self._time_limit.limited(callback)

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
        """
        return _core.find_blobs(frame, self.colors, markers=self.markers, smoothing=self._smoothing)

    @abstractmethod
    def run(self, steps: int | None = None, *, progress: bool | str = False) -> Trace:
        """Run some steps; a run continues where the last one ended."""

    def _run(self, steps: int, progress: bool | str, total: int | None) -> bool:
        """Run some steps; return whether the world has come to its end."""
        self._prepare()
        if not progress:
            with self._guarded():
                return self._core.run(steps)
        from tqdm.auto import tqdm

        label = progress if isinstance(progress, str) else None
        before = self._core.rows
        with tqdm(total=total, unit="step", desc=label) as bar, self._guarded():
            is_at_end = self._core.run(steps, lambda done: bar.update(done - bar.n))
            bar.update(self._core.rows - before - bar.n)
        return is_at_end

    def step(self) -> Step:
        """Run one step.

        Returns
        -------
        Step
            The data of the step that the robot's software may use.

        Raises
        ------
        EOFError
            If there are no more frames.
        RuntimeError
            If another thread calls `stop` before one comes, or runs it already.
        """
        self._prepare()
        before = self._core.rows
        with self._guarded():
            is_at_end = self._core.run(1, stops_robot=False)
        if is_at_end:
            raise EOFError("there are no more frames")
        if self._core.rows == before:
            raise RuntimeError("stop() was called before a frame came")
        return self._core.last_step

    def step_stage(self) -> str:
        """Run the next stage of a step.

        Returns
        -------
        str
            Its name: ``"world"`` (the robot has moved, or a frame has come), or that of a slot.
            Stages that are off are left out.

        Raises
        ------
        EOFError
            If there are no more frames.
        """
        self._prepare()
        with self._guarded():
            stage = self._core.step_stage()
        if stage is None:
            raise EOFError("there are no more frames")
        return stage

    def stop(self) -> bool:
        """End the run under way between two steps; any thread may call this.

        Returns
        -------
        bool
            False if nothing was running.
        """
        return self._core.stop()

    @property
    def is_running(self) -> bool:
        """Whether a run is under way; any thread may ask."""
        return self._core.is_running

    @property
    def n_steps(self) -> int:
        """Number of steps recorded by now; any thread may ask."""
        return self._core.rows

    @property
    def stage(self) -> str:
        """Name of the stage that runs now, or that comes next; any thread may ask.

        See `step_stage` for the names; ``"send"``: the input goes out.
        """
        return self._core.stage

    def _start(self) -> None:
        if not self._core.has_started:
            with self._guarded():
                self._core.start()

    def _prepare(self) -> None:
        if (
            self._folder is not None
            and not self._core.is_running
            and (changed := self._folder.changed)
        ):
            late = changed & slots.ONCE.keys() if self._core.has_started else set()
            for slot in late:
                raise RuntimeError(
                    f"{slot}.py has changed, but runs only at the start of a simulation: call "
                    "sim.reset() first"
                )
            self._load_folder()
        self._check_stages()

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        """Let callbacks import the helper modules of their folder, and enforce the time limit."""
        if self._is_guarded:  # the core raises if it is running
            yield
            return
        self._is_guarded = True
        with ExitStack() as stack:
            stack.callback(setattr, self, "_is_guarded", False)
            if self._folder is not None:
                stack.enter_context(self._folder.importable())
            if self._time_limit is not None:
                stack.enter_context(self._time_limit.watching())
            yield

    def reset(self, *, seed: Seed = None) -> None:
        """Return to the start; the next run begins with step 0.

        Parameters
        ----------
        seed : int, SeedSequence or Generator, optional
            Seed of the next run. Default: the same again, which repeats the last run exactly if no
            callback keeps state of its own.
        """
        new_seed = None if seed is None else seed_sequence(seed)
        callbacks = self._folder.load() if self._folder else None
        self._core.reset()
        if new_seed is not None:
            self._seed = new_seed
            self._seed_core()
        if callbacks is not None:
            self._use(callbacks)
        self._rng = self._run_info = None
        self._changed = ()

    def _seed_core(self) -> None:
        """Give the C++ core the random streams of the seed."""
        self._core.set_controller_seed(stream_number(self._seed, "controller"))

    def _check_stages(self) -> None:
        missing = {"red", "blue"} - {color.name for color in self.colors}
        if missing and self._callbacks["measure"] is True:
            names = ", ".join(color.name for color in self.colors)
            raise ValueError(
                f"colors must have red and blue for the default measurement, got {names}"
            )
        if self._callbacks["estimate_parameters"]:
            self._check_source()

    def _check_source(self) -> None:
        """Raise ValueError if nothing gives the poses that the parameters are estimated from."""
        needed = {"measurement": "measure", "estimate": "estimate_state"}.get(self.identify_from)
        if needed and not self._callbacks[needed]:
            raise ValueError(
                f"identify_from={self.identify_from!r} needs the stage {needed}, which is off: "
                f"give {needed}=..."
            )

    @property
    def trace(self) -> Trace:
        """All steps since the start, as arrays."""
        return Trace(self._core.columns() or empty_groups(self._GROUPS), self._info())

    def _info(self) -> RunInfo:
        if self._run_info is not None:
            return self._run_info
        info = RunInfo(
            dt=self._core.model.dt if self._core.has_started else _core.RobotModel().dt,
            theta_true=self._theta_true(),
            seed=seed_record(self._seed),
            identify_from=self.identify_from,
            area=self.area,
            boundary=self.boundary,
            robot=self.robot.name,
            scenario=self._described(),
            changed=self._changed,
            callbacks=tuple(slot for slot, value in self._callbacks.items() if _is_code(value)),
        )
        if self._core.has_started and not self._core.is_running:  # a start may fail yet
            self._run_info = info
        return info

    def _described(self) -> Any:
        """Return the scenario of the run, None if there is none."""
        return None

    @abstractmethod
    def _theta_true(self) -> ArrayLike:
        """Return the true parameters, (3, 5); NaN = not known."""

    @property
    def rng(self) -> np.random.Generator:
        """Random generator for your callbacks, derived from the seed of the run."""
        if self._rng is None:
            self._rng = np.random.default_rng(stream(self._seed, "user"))
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
        frame = self._core.last_step.frame
        if frame is None:
            raise RuntimeError(f"no frame came in step {self._core.last_step.k}")
        return frame

    @property
    def last_step(self) -> Step:
        """The data of the last step that the robot's software may use."""
        self._start()
        return self._core.last_step

    def __repr__(self) -> str:
        stages = [slot for slot in slots.OPTIONAL if self._callbacks[slot]]
        return (
            f"<{type(self).__name__}: robot {self.robot.name!r}, {self.n_steps} steps done, "
            f"stages on: {', '.join(stages) or 'none'}>"
        )


def _is_code(value: Any) -> bool:
    """Return whether the value of a slot is Python code, and not a native stage."""
    return callable(value) and type(value) not in NATIVE


def _update_estimator(step: Step) -> ArrayLike | None:
    """Update the user's estimator: the stage estimate_parameters=True in Python."""
    if step.sample is None:
        return None
    update: ArrayLike = step.estimator.update(step.sample.phi, step.sample.y)
    return update
