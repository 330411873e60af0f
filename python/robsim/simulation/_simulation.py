"""The class `Simulation`: options, the slots for callbacks, runs; the loop itself is in C++."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from os import PathLike
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._base.checks import check_choice, check_int, check_size
from robsim._base.seeds import Seed, seed_record, seed_sequence, stream, stream_number
from robsim._core import (
    ColorClass,
    Controller,
    DriveAround,
    Frame,
    MarkerLayout,
    Spin,
    Step,
    Unicycle,
)
from robsim.imaging._images import Pixels
from robsim.imaging._noise import Noise, as_native_noise
from robsim.robots import RobotDefinition
from robsim.robots._lookup import as_robot
from robsim.simulation import _slots as slots
from robsim.simulation._dropout import Dropout, as_dropout
from robsim.simulation._frame_source import FrameSource, check_no_world
from robsim.simulation._options import heading_count, start_within, step_count
from robsim.simulation._scene import HEADINGS, as_floor, draw_red_square, make_renderer
from robsim.simulation._time_limit import TimeLimit
from robsim.trace import RunInfo, Trace
from robsim.trace._columns import POSES, RECORDED, SIMULATED, empty_groups
from robsim.vision._color_files import as_colors

if TYPE_CHECKING:
    from robsim.simulation._folders.callback_folder import CallbackFolder, Callbacks

F = TypeVar("F", bound=Callable[..., Any])

SOURCES = tuple(POSES)
_AREA = (1200, 1200)
_UNLIMITED = 2**62 - 1  # steps

# Stages that run in C++ without Python: they need no time limit.
_NATIVE = (Spin, DriveAround, Unicycle)


class _Slot:
    """Descriptor of a slot: ``@sim.control`` or ``sim.control = ...`` fills it."""

    def __init__(self, doc: str) -> None:
        self.__doc__ = doc

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, simulation: Simulation | None, owner: type) -> Any:
        if simulation is None:
            return self

        def register(callback: F) -> F:
            simulation._set_slot(self.name, callback)
            return callback

        register.__name__ = self.name
        register.__doc__ = self.__doc__
        return register

    def __set__(self, simulation: Simulation, callback: Any) -> None:
        simulation._set_slot(self.name, callback)


class Simulation:
    """A robot on a work area under a ceiling camera, driven by callbacks.

    Each step runs these stages in order: the model moves the robot; the parameter estimator gets
    the newest sample; the measurement evaluates the camera's frame; the state estimator updates
    its estimate; the controller returns the input of the next step.

    Parameters
    ----------
    robot : str, path or RobotDefinition, optional
        Name of a robot, a folder with a ``robot.toml``, or a definition. Default: the one chosen
        with ``robsim robots use``, initially ``"lab"``.
    frames : iterable of Frame, optional
        Camera frames, such as a `Recording`, in place of a simulated world: nothing is rendered,
        the true pose is unknown, and a run ends with the frames. Their times ``t`` (s) increase, or
        are all 0: then consecutive frames are one `dt` of the model apart. Optional attributes
        ``area`` and ``dt`` of the iterable set the area and the model's dt.
    area : tuple of int, optional
        Width and height of the work area (px). Default: ``frames.area`` if there is one, or
        1200 x 1200.
    resolution : tuple of int, optional
        Width and height of the frames (px). Default: the same as the area.
    boundary : str
        ``"bounce"``: the robot bounces off the walls. ``"unlimited"``: there are no walls, and the
        view follows the robot.
    headings : int or None
        Number of headings that the robot is drawn in: the nearest one, at integer pixels. None:
        drawn at its exact position and heading.
    noise : GaussianNoise, UniformNoise or None
        Camera noise.
    dropout : Dropout or None
        Random occlusion of the robot.
    background : array (H, W, 3) of uint8, or path, optional
        The floor, scaled to the area. Default: the floor that ships with robsim.
    start : array (3,) or "random", optional
        The first pose: x, y (px), heading (rad). Default: the centre of the area, facing right.
    seed : int, SeedSequence, Generator or None
        Seed of all random numbers of the run, stored in ``trace.info.seed``. None = unpredictable.
    colors : path or iterable of ColorClass, optional
        Colour file, or classes, to detect. Default: red and blue as shipped with robsim.
    markers : MarkerLayout, RobotDefinition, str or path, optional
        Geometry of the markers for the default measurement, or the robot that has them. Default:
        `robot`.
    smoothing : int, optional
        Width of the averaging window applied before a pixel's colour is classified (px of the
        frame), against noise: 3, 5, ... 15, a quarter to three quarters of a marker's width. 1 =
        off, as in the program of 2008. Default: 0.28 of the width of the smaller marker, at most 7.
    identify_from : str, optional
        Source of the poses in the samples: ``"truth"``, the default in a simulated world,
        ``"measurement"`` or ``"estimate"``.
    time_limit : float, optional
        Maximum duration of a call of a callback, or of the ``update`` of your own estimator (s);
        a call that exceeds it ends the run with a TimeoutError.
    define_model, init_parameter_estimator, adjust_background : callable, optional
        Called once, at the start.
    evaluate_model : callable or Unicycle, optional
        ``evaluate_model(world) -> (3,)``: the new pose. Default: the model's own equations.
    estimate_parameters : callable or bool, optional
        ``estimate_parameters(step) -> (3, 5) or None``. True = recursive least squares.
    measure : callable or bool, optional
        ``measure(step) -> Measurement or None``. True = locate the red and the blue marker, the
        default if `frames` is given.
    estimate_state : callable, optional
        ``estimate_state(step) -> Estimate``.
    control : callable or Controller, optional
        ``control(step) -> (u1, u2)`` in V. Default: `Spin`.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range; the message names it.

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> @sim.control
    ... def control(step):
    ...     return 0.5, 0.4
    >>> trace = sim.run(100)
    """

    define_model = _Slot("Once: ``define_model() -> RobotModel``.")
    init_parameter_estimator = _Slot("Once: ``init_parameter_estimator(model) -> estimator``.")
    adjust_background = _Slot("Once: ``adjust_background(background) -> background``.")
    evaluate_model = _Slot("Each step: ``evaluate_model(world) -> (3,)``, the new pose.")
    estimate_parameters = _Slot("Each step: ``estimate_parameters(step) -> (3, 5) or None``.")
    measure = _Slot("Each step: ``measure(step) -> Measurement or None``.")
    estimate_state = _Slot("Each step: ``estimate_state(step) -> Estimate``.")
    control = _Slot("Each step: ``control(step) -> (u1, u2)`` in V.")

    def __init__(
        self,
        *,
        robot: str | PathLike[str] | RobotDefinition | None = None,
        frames: Iterable[Frame] | None = None,
        area: tuple[int, int] | None = None,
        resolution: tuple[int, int] | None = None,
        boundary: str = "bounce",
        headings: int | None = HEADINGS,
        noise: Noise | None = None,
        dropout: Dropout | None = None,
        background: Pixels | str | PathLike[str] | None = None,
        start: ArrayLike | str | None = None,
        seed: Seed = None,
        colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
        markers: MarkerLayout | RobotDefinition | str | PathLike[str] | None = None,
        smoothing: int | None = None,
        identify_from: str | None = None,
        time_limit: float | None = None,
        define_model: Callable[[], _core.RobotModel] | None = None,
        init_parameter_estimator: Callable[[_core.RobotModel], Any] | None = None,
        adjust_background: Callable[[Pixels], Pixels] | None = None,
        evaluate_model: Callable[[_core.WorldState], ArrayLike] | _core.Unicycle | None = None,
        estimate_parameters: Callable[[Step], ArrayLike | None] | bool | None = None,
        measure: Callable[[Step], _core.Measurement | None] | bool | None = None,
        estimate_state: Callable[[Step], _core.Estimate] | None = None,
        control: Callable[[Step], Sequence[float]] | Controller | None = None,
    ) -> None:
        given = locals()
        if frames is not None:
            check_no_world(given)
        self.robot = as_robot(robot)
        self._source = None if frames is None else FrameSource(frames)
        default_area = (self._source and self._source.area) or _AREA
        self.area = check_size("area", default_area if area is None else area)
        self.resolution = self.area if resolution is None else check_size("resolution", resolution)
        check_choice("boundary", boundary, ("bounce", "unlimited"))
        self.boundary = boundary if frames is None else "recorded"
        if identify_from is None:
            identify_from = "truth" if frames is None else "measurement"
        self.identify_from = check_choice("identify_from", identify_from, SOURCES)
        self._time_limit = None if time_limit is None else TimeLimit(time_limit)
        self._is_guarded = False
        self._renderer: _core.Renderer | None = None  # kept across resets
        self._folder: CallbackFolder | None = None
        self._from_folder: set[str] = set()
        self.colors = as_colors(colors)
        self.markers = _as_marker_layout(self.robot if markers is None else markers)
        self._smoothing = (
            None if smoothing is None else check_int("smoothing", smoothing, minimum=1, maximum=15)
        )
        self._headings = heading_count(headings)
        self._background = as_floor(background, self.area)
        self._seed = seed_sequence(seed)
        self._rng = np.random.default_rng(stream(self._seed, "user"))
        self._callbacks: dict[str, Any] = dict.fromkeys(slots.ARGUMENTS)
        self._given = {slot: given[slot] for slot in self._callbacks}
        hidden = as_dropout(dropout)
        self._core = _core.Simulation(
            area=self.area,
            boundary=boundary,
            robot_radius=self.robot.radius,
            start=self._start_pose(start),
            noise=as_native_noise(noise),
            colors=self.colors,
            markers=self.markers,
            smoothing=self._smoothing,
            identify_from=identify_from,
            controller_seed=stream_number(self._seed, "controller"),
            noise_seed=stream_number(self._seed, "noise"),
            dropout=hidden.probability,
            dropout_length=hidden.steps,
            dropout_seed=stream_number(self._seed, "dropout"),
        )
        self._core.set_stage("make_renderer", self._make_renderer)
        if self._source is not None:
            self._core.set_stage("take_frame", self._source.take)
            self._core.set_stage("define_model", self._source.define_model)
            self._core.set_stage("control", None)
            if measure is None:
                self._given["measure"] = True
        for slot in self._callbacks:
            if self._given[slot] is not None:
                self._set_slot(slot, self._given[slot])

    @classmethod
    def from_folder(cls, folder: str | PathLike[str], **options: Any) -> Simulation:
        """Return a simulation with the callbacks of a folder, as written by ``robsim new``.

        When a file of the folder has changed, the next run or reset reloads all of them. If one
        fails, the simulation is unchanged. A callback given here for a slot overrides the file;
        True does not: it applies if the file is missing or has ``ENABLED = False``.

        Parameters
        ----------
        folder : path
            The folder: ``control.py``, ``measure.py`` and so on, named after the slots.
        **options
            The options of `Simulation`.

        Raises
        ------
        FileNotFoundError
            If there is no such folder.
        ValueError
            If it has no callback files, or a file does not define the callback it is named after.
        SyntaxError
            If a file is not valid Python; the message has its name and the line.
        """
        from robsim.simulation._folders.callback_folder import CallbackFolder

        simulation = cls(**options)
        simulation._folder = CallbackFolder(folder)
        simulation._load_folder()
        return simulation

    def _load_folder(self) -> None:
        assert self._folder is not None
        self._use(self._folder.load())

    def _use(self, callbacks: Callbacks) -> None:
        """Fill the slots with the callbacks of the folder."""
        for slot in slots.ARGUMENTS:
            is_fixed = slot in slots.ONCE and self._core.has_started
            is_open = self._given[slot] is None or self._given[slot] is True
            if slot in self._from_folder | callbacks.keys() and is_open and not is_fixed:
                # A file that is switched off counts as missing.
                callback = callbacks.get(slot, False)
                self._set_slot(slot, self._given[slot] if callback is False else callback)
        self._from_folder = set(callbacks)

    def __setattr__(self, name: str, value: Any) -> None:
        is_made = "_core" in self.__dict__
        if is_made and not name.startswith("_") and name not in self._callbacks:
            raise AttributeError(
                f"a simulation has no slot {name!r}: there are {', '.join(self._callbacks)}; "
                "options are given to Simulation(...)"
            )
        super().__setattr__(name, value)

    def _set_slot(self, slot: str, callback: Any) -> None:
        if slot in slots.ONCE and self._core.has_started:
            raise RuntimeError(
                f"{slot} runs only at the start of a simulation: call sim.reset() first"
            )
        if slot == "adjust_background":
            if callback is not None and not callable(callback):
                raise TypeError(f"adjust_background must be callable, got {callback!r}")
        else:
            self._core.set_stage(slot, self._limited(self._stage(slot, callback)))
        self._callbacks[slot] = callback
        update = self._callbacks["estimate_parameters"]
        if slot == "init_parameter_estimator" and (update is None or update is True):
            # An estimator of the user's is meant to be used.
            self._set_slot("estimate_parameters", True)

    def _stage(self, slot: str, callback: Any) -> Any:
        """Return the stage that the C++ core gets for a callback."""
        if slot == "define_model" and self._source and callable(callback):
            return self._source.checked(callback)
        is_users = slot == "estimate_parameters" and self._callbacks["init_parameter_estimator"]
        if callback is True and is_users and self._time_limit:
            return _update_estimator  # in Python, where the time limit applies
        return callback

    def _limited(self, callback: Any) -> Any:
        is_native = type(callback) in _NATIVE
        if self._time_limit is None or is_native or not callable(callback):
            return callback
        return self._time_limit.limited(callback)

    def find_blobs(self, frame: Frame) -> dict[str, list[_core.Blob]]:
        """Return the blobs of a frame, found with the colours and smoothing of this simulation.

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

    def _start_pose(self, start: ArrayLike | str | None) -> ArrayLike:
        width, height = self.area
        if start is None:
            return (width / 2, height / 2, 0.0)
        if not isinstance(start, str):
            return start_within(start, self.area if self.boundary == "bounce" else None)
        if start != "random":
            raise ValueError(f"start must be a pose (x, y, heading) or 'random', got {start!r}")
        margin = min(self.robot.radius, width / 2, height / 2)
        random = np.random.default_rng(stream(self._seed, "start"))
        x = random.uniform(margin, width - 1 - margin)
        y = random.uniform(margin, height - 1 - margin)
        return (x, y, random.uniform(-np.pi, np.pi))

    def _make_renderer(self) -> _core.Renderer:
        adjust = self._limited(self._callbacks["adjust_background"])
        if adjust is None and self._renderer is not None:
            return self._renderer  # nothing has changed since the last reset
        renderer = make_renderer(
            robot=self.robot,
            area=self.area,
            resolution=self.resolution,
            headings=self._headings,
            background=self._background,
            adjust_background=adjust or draw_red_square,
        )
        self._renderer = renderer if adjust is None else None
        return renderer

    def run(self, steps: int | None = None, *, progress: bool | str = False) -> Trace:
        """Run some steps; a run continues where the last one ended.

        Parameters
        ----------
        steps : int, optional
            Number of steps. May be omitted only if `frames` was given: then the run ends with the
            frames.
        progress : bool or str
            Show a progress bar; a str is its label.

        Returns
        -------
        Trace
            All steps since the start of the simulation.

        Raises
        ------
        Exception
            Any exception of a callback, with a note that names the callback and the step. The
            steps before it are kept in `trace`, and the next run continues from there.
        RuntimeError
            If the simulation is already running.
        """
        if steps is None and self._source is None:
            raise TypeError("steps must be an int: a simulated world has no end")
        total, steps = steps, _UNLIMITED if steps is None else step_count(steps)
        self._prepare()
        if not progress:
            with self._guarded():
                self._core.run(steps)
            return self.trace
        from tqdm.auto import tqdm

        label = progress if isinstance(progress, str) else None
        before = self._core.rows
        with tqdm(total=total, unit="step", desc=label) as bar, self._guarded():
            self._core.run(steps, lambda done: bar.update(done - bar.n))
            bar.update(self._core.rows - before - bar.n)
        return self.trace

    def step(self) -> Step:
        """Run one step.

        Returns
        -------
        Step
            The data of the step that the robot's software may use.

        Raises
        ------
        EOFError
            If `frames` was given and there are no more frames.
        """
        self._prepare()
        before = self._core.rows
        with self._guarded():
            self._core.run(1)
        if self._core.rows == before:
            raise EOFError("there are no more frames")
        return self._core.last_step

    def _start(self) -> None:
        if not self._core.has_started:
            with self._guarded():
                self._core.start()

    def _prepare(self) -> None:
        if self._folder is not None and (changed := self._folder.changed):
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

    def reset(self) -> None:
        """Return to the start; the next run begins with step 0 and the same seed.

        It repeats the last run exactly if no callback keeps state of its own.

        Raises
        ------
        RuntimeError
            If `frames` can be read only once, and some have been read.
        """
        if self._source and self._core.rows and self._source.is_single_pass:
            raise RuntimeError(
                "the frames can be read only once: give a list or a Recording to be able to reset"
            )
        callbacks = self._folder.load() if self._folder else None
        self._core.reset()
        if self._source is not None:
            self._source.restart()
        if callbacks is not None:
            self._use(callbacks)
        self._rng = np.random.default_rng(stream(self._seed, "user"))

    def _check_stages(self) -> None:
        missing = {"red", "blue"} - {color.name for color in self.colors}
        if missing and self._callbacks["measure"] is True:
            names = ", ".join(color.name for color in self.colors)
            raise ValueError(
                f"colors must have red and blue for the default measurement, got {names}"
            )
        if self._source is not None:
            self._check_recorded()
        elif self.boundary == "bounce" and min(self.area) <= 2 * self.robot.radius + 1:
            raise ValueError(
                f"area must be wider than the robot, {2 * self.robot.radius:.0f} px, to bounce in "
                f"it, got {self.area}"
            )
        needed = {"measurement": "measure", "estimate": "estimate_state"}.get(self.identify_from)
        if needed and self._callbacks["estimate_parameters"] and not self._callbacks[needed]:
            raise ValueError(
                f"identify_from={self.identify_from!r} needs the stage {needed}, which is off: "
                f"give {needed}=..."
            )

    def _check_recorded(self) -> None:
        if not self._callbacks["measure"]:
            raise ValueError("measure must be on if frames=... is given, got None")
        if not self._callbacks["estimate_parameters"]:
            return
        if not self._callbacks["control"]:
            raise ValueError(
                "estimate_parameters needs the inputs of the robot, which recorded frames do not "
                "have: give control=..."
            )
        if self.identify_from == "truth":
            raise ValueError("identify_from='truth' needs a simulated world, got frames=...")

    @property
    def trace(self) -> Trace:
        """All steps since the start, as arrays."""
        empty = empty_groups(SIMULATED if self._source is None else RECORDED)
        return Trace(self._core.columns() or empty, self._info())

    def _info(self) -> RunInfo:
        model = self._core.model if self._core.has_started else _core.RobotModel()
        theta = model.theta if self._source is None else np.full((3, 5), np.nan)
        return RunInfo(
            dt=model.dt,
            theta_true=tuple(tuple(map(float, row)) for row in theta),
            seed=seed_record(self._seed),
            identify_from=self.identify_from,
            area=self.area,
            boundary=self.boundary,
            robot=self.robot.name,
        )

    @property
    def rng(self) -> np.random.Generator:
        """Random generator for your callbacks, derived from the seed of the run."""
        return self._rng

    @property
    def model(self) -> _core.RobotModel:
        """The robot model of the run."""
        self._start()
        return self._core.model

    @property
    def estimator(self) -> Any:
        """The object that init_parameter_estimator returned."""
        self._start()
        return self._core.estimator

    @property
    def frame(self) -> Frame:
        """The newest camera frame."""
        self._start()
        return self._core.frame

    def render_step(self, k: int) -> Frame:
        """Return the frame of an earlier step, rendered again.

        Parameters
        ----------
        k : int
            Number of the step, from 0.

        Returns
        -------
        Frame
            The frame, identical to that of the run.

        Raises
        ------
        IndexError
            If there is no such step.
        """
        return self._core.render_step(k)

    @property
    def last_step(self) -> Step:
        """The data of the last step that the robot's software may use."""
        self._start()
        return self._core.last_step

    def __repr__(self) -> str:
        stages = [slot for slot in slots.OPTIONAL if self._callbacks[slot]]
        return (
            f"<Simulation: robot {self.robot.name!r}, {len(self.trace)} steps done, "
            f"stages on: {', '.join(stages) or 'none'}>"
        )


def _update_estimator(step: Step) -> ArrayLike | None:
    """Update the user's estimator: the stage estimate_parameters=True in Python."""
    if step.sample is None:
        return None
    update: ArrayLike = step.estimator.update(step.sample.phi, step.sample.y)
    return update


def _as_marker_layout(
    markers: MarkerLayout | RobotDefinition | str | PathLike[str],
) -> MarkerLayout:
    if isinstance(markers, MarkerLayout):
        return markers
    if not isinstance(markers, (str, PathLike, RobotDefinition)):
        raise TypeError(
            f"markers must be a MarkerLayout, a RobotDefinition, a robot's name or a folder, "
            f"got {markers!r}"
        )
    try:
        return as_robot(markers).marker_layout()
    except ValueError as error:
        raise ValueError(f"markers: {error}") from error
