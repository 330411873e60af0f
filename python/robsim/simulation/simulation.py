"""The class `Simulation`: the loop in a simulated world."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from robsim._core import ColorClass, Frame, MarkerLayout, RobotModel, RobotParameters
from robsim.base.checks import Floats, is_int
from robsim.base.seeds import Seed, seed_sequence
from robsim.base.text import quoted
from robsim.simulation import slots as slots
from robsim.simulation.options import step_count
from robsim.simulation.runner import Runner
from robsim.simulation.scenario import OPTIONS, Scenario
from robsim.simulation.slots import SLOTS, WorldSlots
from robsim.simulation.slotted import suggests_names
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
from robsim.simulation.world.scene import Floor
from robsim.simulation.world.world_of_scenario import (
    apply_options,
    check_bounces,
    frame_size,
    seed_world,
    set_scene,
    world_of,
)
from robsim.trace import Trace
from robsim.trace.columns import SIMULATED
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import Noise, standard_deviation
from robsim.vision.robots.definition import RobotDefinition


class _AsInScenario:
    """Default of an option: the scenario's value."""

    def __repr__(self) -> str:
        return "<as in the scenario>"


_SAME: Any = _AsInScenario()

#: The slots whose native stages are part of a scenario.
_STAGES = tuple(slot for slot in SLOTS if slot in OPTIONS)


class Simulation(WorldSlots, Runner):
    """A robot on a work area under a ceiling camera, driven by callbacks.

    Each step runs these stages in order. The model moves the robot, from step 1 on, then the
    parameter estimator gets the newest sample. The measurement evaluates the camera's frame, and
    the state estimator updates its estimate. The controller returns the input of the step.

    Parameters
    ----------
    scenario : Scenario, optional
        Values of the options not given here. Default: ``Scenario()``.
    robot : str, path or RobotDefinition, optional
        Name of a robot, a folder with a ``robot.toml``, or a definition. Default: the robot chosen
        with ``robsim robots use``, initially ``"lab"``.
    area : tuple of int
        Width and height of the work area (px).
    resolution : tuple of int, optional
        Width and height of the frames (px). Default: the same as the area.
    boundary : str
        ``"bounce"``: the robot bounces off the walls. ``"unlimited"``: there are no walls, and the
        view follows the robot.
    headings : int within 1..360 or None
        Number of drawn headings of the robot: the nearest one, at integer pixels. None: the robot
        is drawn at its exact position and heading.
    noise : UniformNoise or GaussianNoise, optional
        Camera noise.
    dropout : Dropout, optional
        Random occlusion: the probability that the robot is hidden from the camera.
    process_noise : PoseNoise or WheelNoise, optional
        Random disturbance of the robot's motion in every step.
    mismatch : ParameterMismatch, optional
        Difference of the parameters of the world from those of `model`.
    camera_delay : int within 0..1000
        Delay of a frame until it reaches the robot's software (steps). The robot keeps moving
        during the delay, and the software knows the exposure time only from the frame.
    motor_delay : float within 0..1000
        Delay of an input until it reaches the motors (steps). With a fractional delay, two inputs
        act in each step, and the robot gets their mean; see the notes of `Scenario`.
    background : array (H, W, 3) of uint8, or path, optional
        The floor, scaled to the area. Default: the floor that ships with robsim.
    start : array (3,) or "random", optional
        The first pose: x, y (px), heading (rad). Default: the centre of the area, facing right.
    seed : int, SeedSequence or Generator, optional
        Seed of all random numbers of the run. None = unpredictable: each run has another seed.
    colors : path or iterable of ColorClass, optional
        Colour file, or classes, to detect. Default: red and blue as shipped with robsim.
    markers : MarkerLayout, RobotDefinition, str or path, optional
        Geometry of the markers for the default measurement, or the robot that has them. Default:
        `robot`.
    smoothing : int within 1..15, optional
        Width of the averaging window applied before a pixel's colour is classified (px of the
        frame), against noise: 3, 5, ... 15, a quarter to three quarters of a marker's width. 1 =
        off. Default: 0.28 of the smaller marker's width, limited to 3..7. For a marker below 7 px,
        the default is 3 in frames with noise and 1 in others.
    identify_from : str
        Source of the poses in the samples: ``"truth"``, ``"measurement"`` or ``"estimate"``.
    model : RobotModel or RobotParameters, optional
        The model of the world, except for `mismatch`, and the belief of the robot's software,
        unless ``define_model`` gives another. Default: the result of ``define_model``, or the model
        of ``RobotParameters()``.
    time_limit : float, optional
        Maximum duration of a call of a callback, or of the ``update`` of your own estimator (s);
        a call that exceeds it ends the run with a TimeoutError.
    define_model : callable, optional
        ``define_model() -> RobotModel``, called once, at the start: the model that the robot's
        software believes in.
    init_parameter_estimator : callable, optional
        ``init_parameter_estimator(model) -> estimator``, called once, at the start: the object
        whose ``update(phi, y)`` estimates the parameters.
    adjust_background : callable, optional
        ``adjust_background(background) -> background``, called once, at the start, with the work
        area as an image, uint8 (H, W, 3): the changed image.
    evaluate_model : callable, optional
        ``evaluate_model(world) -> (3,)``, called at each step from step 1 on, as the first stage:
        the new pose of the robot.
    estimate_parameters : callable or bool, optional
        ``estimate_parameters(step) -> (3, 5) or None``, called at each step: the parameters, None =
        no update. True: the estimator updates them.
    measure : callable or bool, optional
        ``measure(step) -> Measurement or None``, called at each step with a frame: the pose seen in
        it, None = not seen. True: the two markers are located.
    estimate_state : callable, optional
        ``estimate_state(step) -> Estimate``, called at each step: the pose and its covariance.
    control : callable, optional
        ``control(step) -> (u1, u2)``, called at each step, as the last stage: the voltages of the
        left and the right motor (V).

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range; the message names the
        argument.

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> @sim.control
    ... def control(step):
    ...     return 0.5, 0.4
    >>> trace = sim.run(100)
    >>> len(trace), trace.u[-1], trace.pose_measured.shape
    (100, array([0.5, 0.4]), (100, 3))
    """

    SLOTS = slots.names()
    _GROUPS = SIMULATED
    _AGAIN = "robsim.Simulation(sim.scenario, control=...)"

    @suggests_names
    def __init__(
        self,
        scenario: Scenario | None = None,
        *,
        # options: written by ./run stubs
        robot: str | PathLike[str] | RobotDefinition | None = _SAME,
        area: tuple[int, int] = _SAME,
        resolution: tuple[int, int] | None = _SAME,
        boundary: str = _SAME,
        headings: int | None = _SAME,
        noise: Noise | None = _SAME,
        dropout: Dropout | None = _SAME,
        process_noise: PoseNoise | WheelNoise | None = _SAME,
        mismatch: ParameterMismatch | None = _SAME,
        camera_delay: int = _SAME,
        motor_delay: float = _SAME,
        background: Pixels | Floor | str | PathLike[str] | None = _SAME,
        start: ArrayLike | None = _SAME,
        seed: Seed = _SAME,
        colors: str | PathLike[str] | Iterable[ColorClass] | None = _SAME,
        markers: MarkerLayout | RobotDefinition | str | PathLike[str] | None = _SAME,
        smoothing: int | None = _SAME,
        identify_from: str = _SAME,
        model: RobotModel | RobotParameters | None = _SAME,
        # end
        time_limit: float | None = None,
        # slots: written by ./run stubs
        define_model: slots.DefineModel | None = None,
        init_parameter_estimator: slots.InitParameterEstimator | None = None,
        adjust_background: slots.AdjustBackground | None = None,
        evaluate_model: slots.EvaluateModel | None = _SAME,
        estimate_parameters: slots.EstimateParameters | None = _SAME,
        measure: slots.Measure | None = _SAME,
        estimate_state: slots.EstimateState | None = None,
        control: slots.Control | None = _SAME,
        # end
    ) -> None:
        # given: written by ./run stubs
        given = _given(
            robot=robot, area=area, resolution=resolution, boundary=boundary, headings=headings,
            noise=noise, dropout=dropout, process_noise=process_noise, mismatch=mismatch,
            camera_delay=camera_delay, motor_delay=motor_delay, background=background, start=start,
            seed=seed, colors=colors, markers=markers, smoothing=smoothing,
            identify_from=identify_from, model=model, define_model=define_model,
            init_parameter_estimator=init_parameter_estimator, adjust_background=adjust_background,
            evaluate_model=evaluate_model, estimate_parameters=estimate_parameters, measure=measure,
            estimate_state=estimate_state, control=control,
        )  # fmt: skip
        # end
        if scenario is not None and not isinstance(scenario, Scenario):
            hint = "give options by name"
            if isinstance(scenario, (str, PathLike)):
                is_file = Path(scenario).suffix == ".toml"
                load = f"robsim.Scenario.load({quoted(str(scenario))})"
                hint = f"give {load}" if is_file else f"{hint}, such as robot={quoted(scenario)}"
            raise TypeError(f"scenario must be a Scenario, got {quoted(scenario)}: {hint}")
        code = [one for one in _STAGES if one in given and not is_data(one, given[one])]
        data = {name: given[name] for name in OPTIONS if name in given and name not in code}
        if data.get("area", _SAME) is None:
            del data["area"]
        base = Scenario(**data) if scenario is None else scenario.replace(**data)
        self._seed = seed_sequence(base.seed)
        self._scenario = base.replace(**dict.fromkeys(code)) if code else base
        self.resolution = frame_size(self._scenario)
        self._world = world_of(self._scenario, self._seed)
        super().__init__(
            self._world,
            robot=self._scenario._robot_definition,
            area=self._scenario.area,
            boundary=self._scenario.boundary,
            seed=self._seed,
            colors=self._scenario._color_classes,
            markers=self._scenario._marker_layout,
            smoothing=self._scenario.smoothing,
            identify_from=self._scenario.identify_from,
            time_limit=time_limit,
        )
        self._earlier: list[
            tuple[int, Simulation]
        ] = []  # simulations that draw steps up to a number
        # The scenario of the trace, behind the options, the seed and the stages it was made of.
        self._made_scenario: tuple[Scenario | None, Any, dict[str, Any], Scenario]
        self._made_scenario = (None, self._seed, {}, self._scenario)
        stages = {name: given.get(name, self._not_default(name)) for name in _STAGES}
        self._fill_slots(**(given | stages))

    def _not_default(self, stage: str) -> Any:
        """Return the stage of the scenario, None if it is the default."""
        value = getattr(self._scenario, stage)
        return None if value == getattr(Scenario, stage) else value

    @property
    def scenario(self) -> Scenario:
        """The complete description of the world and the run, with the actual seed."""
        stages = {
            name: value if is_data(name, value) else None
            for name, value in self._callbacks.items()
            if name in _STAGES
        }
        base, seed, known, made = self._made_scenario
        if base is not self._scenario or seed is not self._seed or known != stages:
            made = self._scenario.replace(seed=self._seed, **stages)
            self._made_scenario = (self._scenario, self._seed, stages, made)
        return made

    def _headings(self) -> int | None:
        return self._scenario.headings

    def _described(self) -> Scenario:
        return self.scenario

    # live: written by ./run stubs
    @property
    def noise(self) -> Noise | None:
        """Camera noise.

        A change applies from the next step on.
        """
        return self._scenario.noise

    @noise.setter
    def noise(self, noise: Noise | None) -> None:
        self._change(noise=noise)

    @property
    def dropout(self) -> Dropout | None:
        """Random occlusion: the probability that the robot is hidden from the camera.

        A change applies from the next step on.
        """
        return self._scenario.dropout

    @dropout.setter
    def dropout(self, dropout: Dropout | None) -> None:
        self._change(dropout=dropout)

    @property
    def process_noise(self) -> PoseNoise | WheelNoise | None:
        """Random disturbance of the robot's motion in every step.

        A change applies from the next step on.
        """
        return self._scenario.process_noise

    @process_noise.setter
    def process_noise(self, process_noise: PoseNoise | WheelNoise | None) -> None:
        self._change(process_noise=process_noise)

    # end

    def _camera_noise(self) -> float:
        return standard_deviation(self.noise)

    def _change(self, **changes: Any) -> None:
        self._core.check_thread()
        self._scenario = self._scenario.replace(**changes)
        apply_options(self._world, self._scenario, changes)
        if "noise" in changes:
            self._is_marker_size_known = False
        self._note_change(changes)

    def _change_vision(self, **changes: Any) -> None:
        self._core.check_thread()
        scenario = self.scenario
        changed = scenario.replace(**changes)
        check_bounces(changed)
        if "robot" in changes and (self._core.rows or self._core.stage != "world"):
            self._keep_drawing(scenario)
        self._change(**changes)
        if "robot" in changes:
            self._put("adjust_background", self._callbacks["adjust_background"])
        self._look_for(
            self._scenario._robot_definition,
            self._scenario._color_classes,
            self._scenario._marker_layout,
        )

    def _keep_drawing(self, scenario: Scenario) -> None:
        """Let the steps up to now be drawn with the robot of their time."""
        newest = self._core.last_step
        _ = newest.frame  # drawn now
        once = {slot: self._callbacks[slot] for slot in ("adjust_background", "define_model")}
        given = {slot: value for slot, value in once.items() if value is not None}
        self._earlier.append((newest.k, Simulation(scenario, **given)))

    def _seed_core(self) -> None:
        super()._seed_core()
        seed_world(self._world, self._scenario, self._seed)

    def _forget_run(self) -> None:
        super()._forget_run()
        self._earlier = []

    def _renew(self, scenario: Scenario, kept: Iterable[str]) -> None:
        """Go to the start of another scenario; the `kept` slots keep their callbacks."""
        limit = None if self._time_limit is None else self._time_limit.seconds
        slots = {slot: self._callbacks[slot] for slot in kept}
        renewed = vars(Simulation(scenario, time_limit=limit, **slots))
        renewed["_given"] |= {slot: self._given[slot] for slot in slots}
        times = self._call_times
        stays = ("_folder", "_from_folder", "_call_times", "_n_resets", "_time_limit")
        vars(self).update({name: renewed[name] for name in renewed.keys() - {*stays}})
        self._n_resets += 1  # now that the steps are gone
        self._time_calls(times)

    def _default(self, slot: str) -> Any:
        if slot == "control":
            return Scenario.control
        return self._scenario._model if slot == "define_model" else None

    def _put(self, slot: str, value: Any) -> None:
        if slot == "evaluate_model":
            self._world.set_evaluate_model(self._called(slot, value))
        elif slot == "adjust_background":
            adjust = self._called(slot, value)
            # A callback of the user's is called at the start, even if the frame is never used.
            set_scene(self._world, self._scenario, adjust, makes_at_start=value is not None)
        else:
            super()._put(slot, value)

    def _check_stages(self) -> None:
        super()._check_stages()
        check_bounces(self._scenario)

    @property
    def true_model(self) -> RobotModel:
        """The model of the simulated robot's motion; the robot's software believes in `model`."""
        self._start()
        model = self._world.model
        assert model is not None  # it has started
        return model

    def _theta_true(self) -> ArrayLike:
        return (self._world.model or RobotModel()).theta

    def run(self, steps: int, *, progress: bool | str = False) -> Trace:
        """Run some steps; a run continues where the previous run ended.

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
            Any exception raised by a callback. Its note names the callback and the step, and its
            attribute ``callback`` is a `robsim.simulation.FailedCallback`. `trace` keeps the
            previous steps. The next run repeats the failed stage in the same step, but not the
            earlier stages.
        RuntimeError
            If the simulation is already running, or another run uses its estimator or controller.

        Warns
        -----
        UserWarning
            Once per run, if results of callbacks are implausible: headings in degrees, more than
            100 V, covariances without symmetry or with a negative eigenvalue.
        robsim.vision.SmallMarkersWarning
            If the default measurement evaluates markers that are too small for the noise of the
            frames.

        Notes
        -----
        During a run, other threads can read and plot `trace`, `n_steps` and `stage`, and `stop` the
        run. Attributes that the run changes, such as `last_step` and `estimator`, raise an error
        during the run. A run with callbacks in Python takes turns with other busy threads, and
        waits up to 5 ms for each turn: ``sys.setswitchinterval(0.0005)`` shortens this wait. A run
        without such callbacks never waits.
        """
        self._run(step_count(steps), progress, steps)
        return self.trace

    def render_step(self, k: int, *, out: Pixels | None = None) -> Frame:
        """Return the frame of a step, rendered again.

        Parameters
        ----------
        k : int
            Number of the step, from 0; in a callback also the current step.
        out : array (H, W, 3) of uint8, optional
            Array for the pixels, such as shared memory; the frame borrows it.

        Returns
        -------
        Frame
            The frame, identical to the frame in the run.

        Raises
        ------
        TypeError
            If `k` is not an int.
        IndexError
            If the step does not exist, or its frame has not arrived yet.
        RuntimeError
            While another thread runs the simulation.
        """
        self._start()
        self._core.check_thread()
        newest = self._core.last_step.k
        if not is_int(k):
            raise TypeError(f"k must be the number of a step, an int, got {quoted(k)}")
        if not 0 <= k <= newest:
            raise IndexError(f"k must be one of the steps 0..{newest}, got {k}")
        earlier = next((one for last, one in self._earlier if k <= last), None)
        if earlier is not None:
            earlier._start()
            return earlier._drawn(k, self._core.columns(), out)
        if k == newest and k >= self._scenario.camera_delay:
            newest_frame: Frame = self._world.draw_newest(out)
            return newest_frame
        return self._drawn(k, self._core.columns(), out)

    def _drawn(self, k: int, columns: Mapping[str, Floats], out: Pixels | None = None) -> Frame:
        """Return the frame of a step from its record, by this run or an equal one."""
        captured = k - self._scenario.camera_delay
        if captured < 0:
            raise IndexError(f"no frame came in step {k}: camera_delay is {k - captured} steps")
        names = ("pose_true", "view", "hidden", "noise")
        recorded = {name: columns[name][captured] for name in names if name in columns}
        return self._world.draw(captured, **recorded, out=out)


def _given(**options: Any) -> dict[str, Any]:
    """Return the given options; the scenario has the others."""
    return {name: value for name, value in options.items() if value is not _SAME}


def is_data(name: str, value: Any) -> bool:
    """Return whether the value of a slot is part of a scenario."""
    return value is None or type(value) in (OPTIONS[name].types or (bool,))
