"""The simulation: options, callbacks, runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from os import PathLike
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._core import ColorClass, Controller, Frame, Locator, Step
from robsim.colors import as_colors
from robsim.options import (
    choice,
    count,
    phase_count,
    share,
    size,
    start_within,
    step_count,
    visual_noise,
)
from robsim.pictures import Pixels
from robsim.robots import RobotDefinition, as_robot
from robsim.scene import PHASES, as_floor, draw_red_square, make_renderer
from robsim.seeds import Seed, seed_record, seed_sequence, stream, stream_number
from robsim.trace import RunInfo, Trace

F = TypeVar("F", bound=Callable[..., Any])

ONCE_SLOTS = ("define_model", "init_parameter_estimator", "adjust_background")
STEP_SLOTS = ("evaluate_model", "estimate_parameters", "measure", "estimate_state", "control")
SOURCES = ("truth", "measurement", "estimate")
_ALWAYS_RECORDED = {"pose_true": 3, "u": 2, "bounced": 1}
OPTIONAL_SLOTS = ("estimate_parameters", "measure", "estimate_state")


class _Slot:
    """One slot of a simulation: ``@sim.control`` or ``sim.control = ...`` fills it."""

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

    At every step, in this order: the robot model moves the robot; the parameter estimator gets
    the newest sample; the measurement looks at the camera's frame; the state estimator; the
    controller gives the input of the next step.

    Parameters
    ----------
    robot : str, path or RobotDefinition
        Name of a robot that ships with robsim, a folder with a ``robot.toml``, or a definition.
    area : tuple of int
        Width and height of the work area (px).
    camera : tuple of int, optional
        Width and height of the frames (px). Default: those of the area.
    boundary : str
        ``"bounce"``: the robot bounces off the walls. ``"unlimited"``: it does not, and the view
        follows it.
    rotation : str
        ``"phases"``: the robot is shown in the nearest of `phases` headings, at whole pixels.
        ``"continuous"``: at its exact place and heading.
    phases : int
        Number of headings for ``rotation="phases"``.
    noise : str
        ``"none"``, ``"uniform"`` or ``"gaussian"`` noise of the camera.
    noise_percent : float, optional
        Its level p: uniform within +-2.55 p, or Gaussian with sigma = 2.55 p.
    dropout, dropout_steps : float, int
        Something hides the robot from the camera: in each stretch of `dropout_steps` steps with
        the probability `dropout`, 0..1.
    background : array (H, W, 3) of uint8, or path, optional
        The floor, scaled to the area. Default: the floor that ships with robsim.
    start : array (3,) or "random", optional
        The first pose: x, y (px), heading (rad). Default: the middle of the area, facing right.
    seed : int, SeedSequence, Generator or None
        What all random numbers of the run come from; the trace has it in ``info.seed``.
    colors : path or iterable of ColorClass, optional
        The colours to look for. Default: red and blue as they ship with robsim.
    locator : Locator, RobotDefinition, str or path, optional
        What the default measurement takes the markers' geometry from. Default: the robot.
    identify_from : str
        The data that samples are made of: ``"truth"``, ``"measurement"`` or ``"estimate"``.
    define_model, init_parameter_estimator, adjust_background : callable, optional
        Called once, at the start.
    evaluate_model : callable or Unicycle, optional
        ``evaluate_model(world) -> (3,)``: the new pose. Default: the model's own equations.
    estimate_parameters : callable or bool, optional
        ``estimate_parameters(step) -> (3, 5) or None``. True = recursive least squares.
    measure : callable or bool, optional
        ``measure(step) -> Measurement or None``. True = the red and the blue marker.
    estimate_state : callable, optional
        ``estimate_state(step) -> Estimate``.
    control : callable or Controller, optional
        ``control(step) -> (u1, u2)`` in V. Default: `Spin`.

    Raises
    ------
    TypeError, ValueError
        If a value does not fit; the message names it.

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
        robot: str | PathLike[str] | RobotDefinition = "lab",
        area: tuple[int, int] = (1200, 1200),
        camera: tuple[int, int] | None = None,
        boundary: str = "bounce",
        rotation: str = "phases",
        phases: int = PHASES,
        noise: str = "none",
        noise_percent: float | None = None,
        dropout: float = 0.0,
        dropout_steps: int = 1,
        background: Pixels | str | PathLike[str] | None = None,
        start: ArrayLike | str | None = None,
        seed: Seed = None,
        colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
        locator: Locator | RobotDefinition | str | PathLike[str] | None = None,
        identify_from: str = "truth",
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
        self.robot = as_robot(robot)
        self.area = size("area", area)
        self.camera = self.area if camera is None else size("camera", camera)
        self.boundary = choice("boundary", boundary, ("bounce", "unlimited"))
        self.identify_from = choice("identify_from", identify_from, SOURCES)
        self.colors = as_colors(colors)
        self.locator = _as_locator(self.robot if locator is None else locator)
        self._phases = phase_count(rotation, phases)
        self._background = as_floor(background, self.area)
        self._seed = seed_sequence(seed)
        self._rng = np.random.default_rng(stream(self._seed, "user"))
        self._callbacks: dict[str, Any] = dict.fromkeys((*ONCE_SLOTS, *STEP_SLOTS))
        self._core = _core.Simulation(
            area=self.area,
            boundary=boundary,
            robot_radius=self.robot.radius,
            start=self._start_pose(start),
            noise=visual_noise(noise, noise_percent),
            colors=self.colors,
            locator=self.locator,
            identify_from=identify_from,
            controller_seed=stream_number(self._seed, "controller"),
            noise_seed=stream_number(self._seed, "noise"),
            dropout=share("dropout", dropout),
            dropout_steps=count("dropout_steps", dropout_steps),
            dropout_seed=stream_number(self._seed, "dropout"),
        )
        self._core.set_stage("make_renderer", self._make_renderer)
        for slot in self._callbacks:
            if given[slot] is not None:
                self._set_slot(slot, given[slot])

    def __setattr__(self, name: str, value: Any) -> None:
        is_made = "_core" in self.__dict__
        if is_made and not name.startswith("_") and name not in self._callbacks:
            raise AttributeError(
                f"a simulation has no slot {name!r}: there are {', '.join(self._callbacks)}; "
                "options are given when it is made"
            )
        super().__setattr__(name, value)

    def _set_slot(self, slot: str, callback: Any) -> None:
        if slot in ONCE_SLOTS and self._core.has_started:
            raise RuntimeError(f"{slot} comes once, at the start: call sim.reset() before")
        if slot == "adjust_background":
            if callback is not None and not callable(callback):
                raise TypeError(f"adjust_background must be callable, got {callback!r}")
        else:
            self._core.set_stage(slot, callback)
        self._callbacks[slot] = callback
        if slot == "init_parameter_estimator" and self._callbacks["estimate_parameters"] is None:
            # Whoever brings an estimator wants it to be used.
            self._set_slot("estimate_parameters", True)

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
        return make_renderer(
            robot=self.robot,
            area=self.area,
            camera=self.camera,
            phases=self._phases,
            background=self._background,
            adjust_background=self._callbacks["adjust_background"] or draw_red_square,
        )

    def run(self, steps: int, *, progress: bool | str = False) -> Trace:
        """Do some steps; a run goes on where the one before ended.

        Parameters
        ----------
        steps : int
            Number of steps.
        progress : bool or str
            Show a progress bar, with this label if it is one.

        Returns
        -------
        Trace
            All steps since the start.

        Raises
        ------
        Exception
            Whatever a callback raises, with a note that names the callback and the step. The
            trace up to the step before is kept in `trace`, and the next run goes on from there.
        RuntimeError
            If the simulation is running already.
        """
        steps = step_count(steps)
        self._check_stages()
        if not progress:
            self._core.run(steps)
            return self.trace
        from tqdm.auto import tqdm

        label = progress if isinstance(progress, str) else None
        with tqdm(total=steps, unit="step", desc=label) as bar:
            self._core.run(steps, lambda done: bar.update(done - bar.n))
            bar.update(steps - bar.n)
        return self.trace

    def step(self) -> Step:
        """Do one step.

        Returns
        -------
        Step
            What the robot half knows of it.
        """
        self._check_stages()
        self._core.run(1)
        return self._core.newest

    def reset(self) -> None:
        """Go back to the start: the next run begins anew.

        Without callbacks that remember something it gives the same again.
        """
        self._core.reset()
        self._rng = np.random.default_rng(stream(self._seed, "user"))

    def _check_stages(self) -> None:
        missing = {"red", "blue"} - {color.name for color in self.colors}
        if missing and self._callbacks["measure"] is True:
            names = ", ".join(color.name for color in self.colors)
            raise ValueError(
                f"colors must have red and blue for the default measurement, got {names}"
            )
        if self.boundary == "bounce" and min(self.area) <= 2 * self.robot.radius + 1:
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

    @property
    def trace(self) -> Trace:
        """All steps since the start, as arrays."""
        empty = {name: np.empty((0, size)) for name, size in _ALWAYS_RECORDED.items()}
        return Trace(self._core.columns() or empty, self._info())

    def _info(self) -> RunInfo:
        model = self._core.model if self._core.has_started else _core.RobotModel()
        return RunInfo(
            dt=model.dt,
            theta_true=tuple(tuple(map(float, row)) for row in model.theta),
            seed=seed_record(self._seed),
            identify_from=self.identify_from,
            area=self.area,
            boundary=self.boundary,
            robot=self.robot.name,
        )

    @property
    def rng(self) -> np.random.Generator:
        """Random numbers for your callbacks: a stream of the run's seed."""
        return self._rng

    @property
    def model(self) -> _core.RobotModel:
        """The robot model in use."""
        self._core.start()
        return self._core.model

    @property
    def estimator(self) -> Any:
        """The object that init_parameter_estimator made."""
        self._core.start()
        return self._core.estimator

    @property
    def frame(self) -> Frame:
        """The newest camera frame."""
        self._core.start()
        return self._core.frame

    def frame_of(self, k: int) -> Frame:
        """Return the frame of a recorded step, drawn anew.

        Parameters
        ----------
        k : int
            Number of the step.

        Raises
        ------
        IndexError
            If there is no such step.
        """
        return self._core.frame_of(k)

    @property
    def newest(self) -> Step:
        """What the robot half knows of the newest step."""
        self._core.start()
        return self._core.newest

    def __repr__(self) -> str:
        stages = [slot for slot in OPTIONAL_SLOTS if self._callbacks[slot]]
        return (
            f"<Simulation: robot {self.robot.name!r}, {len(self.trace)} steps done, "
            f"stages on: {', '.join(stages) or 'none'}>"
        )


def _as_locator(locator: Locator | RobotDefinition | str | PathLike[str]) -> Locator:
    if isinstance(locator, Locator):
        return locator
    if not isinstance(locator, (str, PathLike, RobotDefinition)):
        raise TypeError(
            f"locator must be a Locator, a RobotDefinition, a robot's name or a folder, "
            f"got {locator!r}"
        )
    try:
        return as_robot(locator).locator()
    except ValueError as error:
        raise ValueError(f"locator: {error}") from error
