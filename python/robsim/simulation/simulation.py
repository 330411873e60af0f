"""The class `Simulation`: the loop in a simulated world."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, Unpack

from numpy.typing import ArrayLike

from robsim._core import Frame, RobotModel, RobotParameters
from robsim.base.checks import Floats, is_int
from robsim.base.seeds import Seed, seed_sequence
from robsim.base.text import quoted
from robsim.simulation import options as options
from robsim.simulation import slots as slots
from robsim.simulation.runner import Runner
from robsim.simulation.scenario import OPTIONS, Scenario
from robsim.simulation.slots import SLOTS, AllCallbacks, WorldSlots
from robsim.simulation.world.disturbances import Dropout, ParameterMismatch, PoseNoise, WheelNoise
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
    """Default of an option: that of the scenario."""

    def __repr__(self) -> str:
        return "<as in the scenario>"


_SAME: Any = _AsInScenario()

#: The slots whose native stages are part of a scenario.
_STAGES = tuple(slot for slot in SLOTS if slot in OPTIONS)


class Simulation(WorldSlots, Runner):
    """A robot on a work area under a ceiling camera, driven by callbacks.

    Each step runs these stages in order: the model moves the robot, from step 1 on; the parameter
    estimator gets the newest sample; the measurement evaluates the camera's frame; the state
    estimator updates its estimate; the controller returns the input of the step.

    Parameters
    ----------
    scenario : Scenario, optional
        What the options have that are not given here. Default: ``Scenario()``.
    OPTIONS
    time_limit : float, optional
        Maximum duration of a call of a callback, or of the ``update`` of your own estimator (s);
        a call that exceeds it ends the run with a TimeoutError.
    SLOTS

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range; the message names it.

    Notes
    -----
    The slots that are options of a scenario take callbacks, too:

    CALLBACKS

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, seed=1)
    >>> @sim.control
    ... def control(step):
    ...     return 0.5, 0.4
    >>> trace = sim.run(100)
    """

    SLOTS = slots.names()
    _GROUPS = SIMULATED
    _AGAIN = "robsim.Simulation(sim.scenario, control=...)"

    @slots.shows_slots(AllCallbacks, dict.fromkeys(_STAGES, _SAME))
    def __init__(
        self,
        scenario: Scenario | None = None,
        *,
        robot: str | PathLike[str] | RobotDefinition | None = _SAME,
        area: tuple[int, int] | None = _SAME,
        resolution: tuple[int, int] | None = _SAME,
        boundary: str = _SAME,
        headings: int | None = _SAME,
        noise: Noise | None = _SAME,
        dropout: Dropout | None = _SAME,
        process_noise: PoseNoise | WheelNoise | None = _SAME,
        mismatch: ParameterMismatch | None = _SAME,
        camera_delay: int = _SAME,
        motor_delay: float = _SAME,
        background: options.Background = _SAME,
        start: ArrayLike | str | None = _SAME,
        seed: Seed = _SAME,
        colors: options.Colors = _SAME,
        markers: options.Markers = _SAME,
        smoothing: int | None = _SAME,
        identify_from: str = _SAME,
        model: RobotModel | RobotParameters | None = _SAME,
        time_limit: float | None = None,
        **callbacks: Unpack[AllCallbacks],
    ) -> None:
        given = {name: value for name, value in locals().items() if value is not _SAME}
        self._check_names(callbacks)
        given |= callbacks
        if scenario is not None and not isinstance(scenario, Scenario):
            hint = "give options by name"
            if isinstance(scenario, (str, PathLike)):
                is_file = Path(scenario).suffix == ".toml"
                load = f"robsim.Scenario.load({quoted(str(scenario))})"
                hint = f"give {load}" if is_file else f"{hint}, such as robot={quoted(scenario)}"
            raise TypeError(f"scenario must be a Scenario, got {quoted(scenario)}: {hint}")
        data = {name: given[name] for name in OPTIONS if name in given}
        code = {
            name: data.pop(name) for name in _STAGES if name in data and not _is_data(name, data)
        }
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
        self._earlier: list[tuple[int, Simulation]] = []  # what draws the steps up to a number
        stages = {name: given.get(name, self._not_default(name)) for name in _STAGES}
        self._fill_slots(given | stages)

    def _not_default(self, stage: str) -> Any:
        """Return the stage of the scenario, None if it is the default."""
        value = getattr(self._scenario, stage)
        return None if value == getattr(Scenario, stage) else value

    @property
    def scenario(self) -> Scenario:
        """All that describes the world and the run, with the seed that is used."""
        stages = {
            name: value if _is_data(name, {name: value}) else None
            for name, value in self._callbacks.items()
            if name in _STAGES
        }
        return self._scenario.replace(seed=self._seed, **stages)

    def _headings(self) -> int | None:
        return self._scenario.headings

    def _described(self) -> Scenario:
        return self.scenario

    @property
    def noise(self) -> Noise | None:
        """Camera noise; a change applies to the frames from the next step on."""
        return self._scenario.noise

    @noise.setter
    def noise(self, noise: Noise | None) -> None:
        self._change(noise=noise)
        self._is_marker_size_known = False

    def _camera_noise(self) -> float:
        return standard_deviation(self.noise)

    @property
    def dropout(self) -> Dropout | None:
        """Random occlusion of the robot; a change applies from the next step on."""
        return self._scenario.dropout

    @dropout.setter
    def dropout(self, dropout: Dropout | None) -> None:
        self._change(dropout=dropout)

    @property
    def process_noise(self) -> PoseNoise | WheelNoise | None:
        """Random disturbance of the robot's motion; a change applies from the next step on."""
        return self._scenario.process_noise

    @process_noise.setter
    def process_noise(self, process_noise: PoseNoise | WheelNoise | None) -> None:
        self._change(process_noise=process_noise)

    def _change(self, **changes: Any) -> None:
        self._core.check_thread()
        self._scenario = self._scenario.replace(**changes)
        apply_options(self._world, self._scenario, changes)
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
        """Let the steps up to now be drawn with the robot that was seen in them."""
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

    def _default(self, slot: str) -> Any:
        if slot == "control":
            return Scenario.control
        return self._scenario._model if slot == "define_model" else None

    def _put(self, slot: str, value: Any) -> None:
        if slot == "evaluate_model":
            self._world.set_evaluate_model(self._called(slot, value))
        elif slot == "adjust_background":
            adjust = self._called(slot, value)
            # A callback of the user's is called at the start, whether somebody looks or not.
            set_scene(self._world, self._scenario, adjust, makes_at_start=value is not None)
        else:
            super()._put(slot, value)

    def _check_stages(self) -> None:
        super()._check_stages()
        check_bounces(self._scenario)

    @property
    def true_model(self) -> RobotModel:
        """The model that the robot of the world follows; the robot half believes in `model`."""
        self._start()
        model = self._world.model
        assert model is not None  # it has started
        return model

    def _theta_true(self) -> ArrayLike:
        return (self._world.model or RobotModel()).theta

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
            Any exception of a callback, with a note that names the callback and the step, and the
            attribute ``callback``, a `robsim.simulation.FailedCallback`. The steps before it are
            kept in `trace`. The next run repeats the stage that failed, in the same step; what
            comes before it in the step is not done again.
        RuntimeError
            If it is already running, or another run has its estimator or controller.

        Warns
        -----
        robsim.vision.SmallMarkersWarning
            If the default measurement looks at markers that are too small for the noise of the
            frames.

        Notes
        -----
        Meanwhile other threads can read `trace`, `n_steps` and `stage`, draw a plot of them, and
        `stop` the run; what the run changes, such as `last_step` and `estimator`, refuses to be
        looked at. A run with callbacks in Python takes turns with other busy threads, and waits up
        to 5 ms for each turn: ``sys.setswitchinterval(0.0005)`` makes that shorter. A run without
        any waits for nobody.
        """
        if steps is None:
            raise TypeError("steps must be an int: a simulated world has no end")
        self._run(options.step_count(steps), progress, steps)
        return self.trace

    def render_step(self, k: int, *, out: Pixels | None = None) -> Frame:
        """Return the frame of a step, rendered again.

        Parameters
        ----------
        k : int
            Number of the step, from 0; in a callback that of the step under way, too.
        out : array (H, W, 3) of uint8, optional
            Where to write the pixels, such as shared memory; the frame borrows it.

        Returns
        -------
        Frame
            The frame, identical to that of the run.

        Raises
        ------
        TypeError
            If `k` is not an int.
        IndexError
            If there is no such step, or its frame has not come yet.
        RuntimeError
            While another thread runs the simulation.
        """
        self._start()
        self._core.check_thread()
        newest = self._core.last_step.k
        if not is_int(k):
            raise TypeError(f"k must be an int, the number of a step, got {quoted(k)}")
        if not 0 <= k <= newest:
            raise IndexError(f"there are steps 0..{newest}, got k = {k}")
        earlier = next((one for last, one in self._earlier if k <= last), None)
        if earlier is not None:
            earlier._start()
            return earlier._drawn(k, self._core.columns(), out)
        if k == newest and k >= self._scenario.camera_delay:
            newest_frame: Frame = self._world.draw_newest(out)
            return newest_frame
        return self._drawn(k, self._core.columns(), out)

    def _drawn(self, k: int, columns: Mapping[str, Floats], out: Pixels | None = None) -> Frame:
        """Return the frame of a step from what was recorded of it, by this run or an equal one."""
        captured = k - self._scenario.camera_delay
        if captured < 0:
            raise IndexError(f"no frame has come in step {k}: camera_delay is {k - captured} steps")
        names = ("pose_true", "view", "hidden", "noise")
        recorded = {name: columns[name][captured] for name in names if name in columns}
        return self._world.draw(captured, **recorded, out=out)


def _is_data(name: str, values: dict[str, Any]) -> bool:
    """Return whether the value of a slot is part of a scenario."""
    value = values[name]
    if SLOTS[name].is_switch:
        return value is None or isinstance(value, bool)
    return value is None or type(value) in SLOTS[name].native


def _documentation(text: str) -> str:
    """Return a docstring with the documentation of the options, which stands in `Scenario`."""
    text, options = (inspect.cleandoc(one) for one in (text, Scenario.__doc__ or ""))
    start, end = options.index("robot : "), options.index("\nRaises\n")
    calls = "\n".join(f"- {SLOTS[slot].call}" for slot in _STAGES)
    others = slots.documented(slot for slot in SLOTS if slot not in _STAGES)
    text = text.replace("OPTIONS\n", options[start:end].rstrip() + "\n")
    return text.replace("SLOTS\n", others).replace("CALLBACKS\n", calls + "\n")


if Simulation.__doc__:  # not under python -OO
    Simulation.__doc__ = _documentation(Simulation.__doc__)
