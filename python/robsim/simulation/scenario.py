"""`Scenario`: the complete description of a simulated world and its run, as one value."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from os import PathLike
from typing import Any

from robsim._core import ColorClass, MarkerLayout, Replay, RobotModel, RobotParameters
from robsim.base.files import as_path, read_text, write_whole
from robsim.base.spelling import check_names
from robsim.base.warn import warn_user
from robsim.simulation.options import OPTIONS as OPTIONS
from robsim.simulation.options import Options, check_images, start_value
from robsim.simulation.world.scene import Floor
from robsim.trace import NotRecordedError, Trace
from robsim.trace.trace import check_trace
from robsim.vision.robots.definition import RobotDefinition


@dataclass(frozen=True, kw_only=True, repr=False)
class Scenario(Options):
    """The complete description of a simulated world and its run: `Simulation`'s options as data.

    A scenario is a value: scenarios with the same content are equal, regardless of their origin.
    Names and files are read immediately, so that a scenario is complete.

    Parameters
    ----------
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
    evaluate_model : Unicycle, optional
        The motion of the robot. Default: the model's own equations.
    estimate_parameters : bool
        Whether recursive least squares estimate the parameters.
    measure : bool
        Whether the robot is located by its markers.
    control : Spin, DriveAround or Replay or None
        The controller.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or is out of range; the message names the
        argument.

    Notes
    -----
    ``motor_delay = n + f`` has a whole part n and a fraction 0 <= f < 1. Two inputs then act from
    step k to step k + 1. Their mean is (1 - f) u(k - n) + f u(k - n - 1); inputs before step 0 are
    0. The mean is exact for a constant input, and for quantities that depend only on the mean
    input. The mean neglects that an input in the second part of a step has less time to move the
    robot.

    The latency of a live loop, from the exposure of a frame until its input acts, counts as a
    single delay. Live frames are numbered and timed by their exposure, so the complete latency
    (camera, vision, transmission, motors) is a `motor_delay`. `Trace.timing` measures it,
    `robsim.estimation.reference` compensates it, and `robsim.batch_estimate` accepts it as
    ``motor_delay``.

    Examples
    --------
    >>> scenario = robsim.Scenario(measure=True, noise=robsim.GaussianNoise(10), seed=1)
    >>> scenario.save("noisy.toml")
    >>> robsim.Scenario.load("noisy.toml") == scenario
    True
    >>> others = [scenario.replace(seed=seed) for seed in range(10)]
    """

    def __post_init__(self) -> None:
        for name, option in OPTIONS.items():
            object.__setattr__(self, name, option.checked(getattr(self, name)))
        check_images(self.area, self.resolution, self._robot_definition)
        within = self.area if self.boundary == "bounce" else None
        object.__setattr__(self, "start", start_value(self.start, within))

    @property
    def _floor(self) -> Floor | None:
        """The floor in its own size; None = the floor shipped with robsim."""
        assert self.background is None or isinstance(self.background, Floor)
        return self.background

    @property
    def _robot_definition(self) -> RobotDefinition:
        """The robot, as read."""
        assert isinstance(self.robot, RobotDefinition)
        return self.robot

    @property
    def _model(self) -> RobotModel | None:
        """The model; None = from the default parameters, unless a callback defines another."""
        return RobotModel(self.model) if isinstance(self.model, RobotParameters) else self.model

    @property
    def _color_classes(self) -> tuple[ColorClass, ...]:
        """The colours to detect, as read."""
        assert isinstance(self.colors, tuple)
        return self.colors

    @property
    def _marker_layout(self) -> MarkerLayout:
        """Geometry of the markers for the default measurement."""
        assert self.markers is None or isinstance(self.markers, MarkerLayout)
        return self.markers or self._robot_definition.marker_layout()

    @classmethod
    def of(cls, trace: Trace) -> Scenario:
        """Return the scenario of a recorded run, which reproduces the run.

        Parameters
        ----------
        trace : Trace
            A run of a `Simulation`, from its first step on.

        Returns
        -------
        Scenario
            With the seed of the run. A controller in Python is replaced by the recorded inputs, as
            a `Replay`.

        Raises
        ------
        NotRecordedError
            If the trace has no scenario.
        TypeError, ValueError
            If `trace` is not a Trace, or does not begin at the first step of the run.

        Warns
        -----
        UserWarning
            If other slots had callbacks in Python, which a scenario cannot contain, or if options
            changed in the middle of the run.
        """
        check_trace(trace)
        scenario = trace.info.scenario
        if scenario is None:
            raise NotRecordedError(("scenario",), "it is not of a Simulation")
        if isinstance(scenario, str):
            scenario = cls.from_toml(scenario)
        callbacks = set(trace.info.callbacks)
        if "control" in callbacks:
            if len(trace) and trace.k[0] != 0:
                raise ValueError(f"trace must begin with step 0, got step {trace.k[0]}")
            scenario = scenario.replace(control=Replay(trace.u))
        if trace.info.changed:
            warn_user(
                f"{', '.join(trace.info.changed)} changed in the run: the scenario has the last "
                "values"
            )
        if missing := sorted(callbacks - {"control"}):
            warn_user(
                f"the run had callbacks in Python for {', '.join(missing)}: pass them again to "
                "Simulation(scenario, ...)"
            )
        assert isinstance(scenario, cls)
        return scenario

    def replace(self, **changes: Any) -> Scenario:
        """Return the scenario with some options changed.

        Parameters
        ----------
        **changes
            Options, as for `Scenario`.

        Returns
        -------
        Scenario
            The new scenario.

        Raises
        ------
        TypeError, ValueError
            As for `Scenario`. For an unknown option, the message gives the closest known name.
        """
        check_names("a scenario has no option", changes, OPTIONS, TypeError)
        return dataclasses.replace(self, **changes)

    def changes(self) -> dict[str, Any]:
        """Return the options whose values differ from the defaults, in the order of the options.

        Returns
        -------
        dict
            Name to value. `robot` is always included: its default depends on the user.
        """
        defaults = {name: option.default for name, option in OPTIONS.items()}
        defaults["colors"] = OPTIONS["colors"].checked(None)
        values = {name: getattr(self, name) for name in defaults}
        return {name: value for name, value in values.items() if value != defaults[name]}

    def to_toml(self) -> str:
        """Return the scenario as the text of a TOML file, for `from_toml`.

        The text contains only the robot and the values that differ from the defaults. A robot that
        ships with robsim is given by its name. The text includes images and recorded inputs, so
        that it is complete.

        Raises
        ------
        ValueError
            If an image, or the record of inputs, is too large for a file.
        """
        from robsim.simulation.scenario_file import to_toml

        return to_toml(self.changes())

    @classmethod
    def from_toml(cls, text: str) -> Scenario:
        """Return the scenario of a TOML text.

        Parameters
        ----------
        text : str
            Text from `to_toml`, or written by hand.

        Raises
        ------
        TypeError
            If `text` is not a str.
        ValueError
            If the text is not TOML, is too large, or an option is unknown or wrong; the message
            names it.
        """
        from robsim.simulation.scenario_file import from_toml

        return from_toml(cls, text, "scenario")

    def save(self, path: str | PathLike[str]) -> None:
        """Write the scenario to a file, in the format of `to_toml`.

        Parameters
        ----------
        path : path
            The file, such as ``run.toml``; an existing file is replaced.

        Raises
        ------
        OSError
            If the file cannot be written.
        ValueError
            If an image, or the record of inputs, is too large for a file.
        """
        write_whole(as_path(path), self.to_toml().encode())

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Scenario:
        """Read a scenario from a file.

        The file is data: nothing in it is executed, and no other file is read, except the files of
        a named robot.

        Parameters
        ----------
        path : path
            The file, from `save`, or written by hand.

        Raises
        ------
        FileNotFoundError
            If the file does not exist.
        ValueError
            If the file is not TOML, is too large, or an option is unknown or wrong; the message
            names the file and the option.
        """
        from robsim.simulation.scenario_file import MOST_BYTES, from_toml

        return from_toml(cls, read_text(as_path(path), MOST_BYTES), f"scenario file {path}")

    def __repr__(self) -> str:
        shown = {name: repr(value) for name, value in self.changes().items()}
        shown["robot"] = repr(self._robot_definition.name)
        if isinstance(self.background, Floor):
            shown["background"] = f"<array of shape {self.background.pixels.shape}>"
        return f"Scenario({', '.join(f'{name}={text}' for name, text in shown.items())})"
