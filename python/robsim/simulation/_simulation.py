"""The class `Simulation`: the loop in a simulated world."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._base.checks import check_choice, check_size
from robsim._base.seeds import Seed, seed_sequence, stream, stream_number
from robsim._core import ColorClass, Controller, Frame, MarkerLayout, Spin, Step
from robsim.imaging._images import Pixels
from robsim.imaging._noise import Noise, as_native_noise
from robsim.robots import RobotDefinition
from robsim.robots._lookup import as_robot
from robsim.simulation import _slots as slots
from robsim.simulation._options import heading_count, start_within, step_count
from robsim.simulation._runner import SOURCES, Runner, as_marker_layout, checked_smoothing
from robsim.simulation._slots import Slot
from robsim.simulation._world.dropout import Dropout, as_dropout
from robsim.simulation._world.scene import HEADINGS, as_floor, draw_red_square, make_scene
from robsim.trace import Trace
from robsim.trace._columns import SIMULATED
from robsim.vision._color_files import as_colors

_AREA = (1200, 1200)


class Simulation(Runner):
    """A robot on a work area under a ceiling camera, driven by callbacks.

    Each step runs these stages in order: the model moves the robot; the parameter estimator gets
    the newest sample; the measurement evaluates the camera's frame; the state estimator updates
    its estimate; the controller returns the input of the next step.

    Parameters
    ----------
    robot : str, path or RobotDefinition, optional
        Name of a robot, a folder with a ``robot.toml``, or a definition. Default: the one chosen
        with ``robsim robots use``, initially ``"lab"``.
    area : tuple of int
        Width and height of the work area (px).
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
    identify_from : str
        Source of the poses in the samples: ``"truth"``, ``"measurement"`` or ``"estimate"``.
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
        ``measure(step) -> Measurement or None``. True = locate the red and the blue marker.
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

    SLOTS = tuple(slots.ARGUMENTS)
    _GROUPS = SIMULATED

    adjust_background = Slot("Once: ``adjust_background(background) -> background``.")
    evaluate_model = Slot("Each step: ``evaluate_model(world) -> (3,)``, the new pose.")

    def __init__(
        self,
        *,
        robot: str | PathLike[str] | RobotDefinition | None = None,
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
        identify_from: str = "truth",
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
        definition = as_robot(robot)
        area = check_size("area", _AREA if area is None else area)
        self.resolution = area if resolution is None else check_size("resolution", resolution)
        check_choice("boundary", boundary, ("bounce", "unlimited"))
        hidden = as_dropout(dropout)
        self._start_option = start
        self._world = _core.SimulatedWorld(
            area=area,
            resolution=self.resolution,
            boundary=boundary,
            robot_radius=definition.radius,
            camera_delay=0,
            motor_delay=0,
        )
        self._world.set_noise(as_native_noise(noise))
        self._world.set_dropout(hidden.probability, hidden.steps)
        self._scene = {
            "robot": definition,
            "area": area,
            "resolution": self.resolution,
            "headings": heading_count(headings),
            "background": as_floor(background, area),
        }
        super().__init__(
            self._world,
            robot=definition,
            area=area,
            boundary=boundary,
            seed=seed_sequence(seed),
            colors=as_colors(colors),
            markers=as_marker_layout(definition if markers is None else markers),
            smoothing=checked_smoothing(smoothing),
            identify_from=check_choice("identify_from", identify_from, SOURCES),
            time_limit=time_limit,
        )
        self._seed_core()
        self._fill_slots(given)

    def _seed_core(self) -> None:
        super()._seed_core()
        self._world.set_seeds(
            noise=stream_number(self._seed, "noise"),
            dropout=stream_number(self._seed, "dropout"),
            disturbance=0,
        )
        self._world.set_start(self._start_pose(self._start_option))

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

    def _default(self, slot: str) -> Any:
        return Spin() if slot == "control" else None

    def _put(self, slot: str, value: Any) -> None:
        if slot == "evaluate_model":
            self._world.set_evaluate_model(self._limited(value))
        elif slot == "adjust_background":
            if value is not None and not callable(value):
                raise TypeError(f"adjust_background must be callable, got {value!r}")
            adjust = self._limited(value) or draw_red_square
            make = partial(make_scene, **self._scene, adjust_background=adjust)
            # A callback of the user's is called at the start, whether somebody looks or not.
            self._world.set_make_scene(make, makes_at_start=value is not None)
        else:
            super()._put(slot, value)

    def _check_stages(self) -> None:
        super()._check_stages()
        if self.boundary == "bounce" and min(self.area) <= 2 * self.robot.radius + 1:
            raise ValueError(
                f"area must be wider than the robot, {2 * self.robot.radius:.0f} px, to bounce in "
                f"it, got {self.area}"
            )

    def _theta_true(self) -> ArrayLike:
        return (self._world.model if self._core.has_started else _core.RobotModel()).theta

    def run(self, steps: int | None = None, *, progress: bool | str = False) -> Trace:
        """Run some steps; a run continues where the last one ended.

        Parameters
        ----------
        steps : int
            Number of steps.
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
            If it is already running.
        """
        if steps is None:
            raise TypeError("steps must be an int: a simulated world has no end")
        self._run(step_count(steps), progress, steps)
        return self.trace

    def render_step(self, k: int, *, out: Pixels | None = None) -> Frame | Pixels:
        """Return the frame of a step, rendered again.

        Parameters
        ----------
        k : int
            Number of the step, from 0; in a callback that of the step under way, too.
        out : array (H, W, 3) of uint8, optional
            Where to write the pixels; it is returned.

        Returns
        -------
        Frame or array
            The frame, identical to that of the run.

        Raises
        ------
        IndexError
            If there is no such step, or no frame came in it.
        RuntimeError
            While another thread runs the simulation.
        """
        self._start()
        self._core.check_thread()
        newest = self._core.last_step.k
        if k == newest:
            return self._world.draw_newest(out)
        if not 0 <= k < newest:
            raise IndexError(f"there are steps 0..{newest}, got k = {k}")
        columns = self._core.columns()

        def recorded(name: str, width: int) -> list[float]:
            return np.nan_to_num(columns[name][k]).tolist() if name in columns else [0.0] * width

        return self._world.draw(
            k,
            columns["pose_true"][k],
            recorded("view", 2),
            recorded("hidden", 1)[0] > 0,
            recorded("noise", 2),
            out,
        )
