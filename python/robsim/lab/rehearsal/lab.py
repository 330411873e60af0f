"""`SimulatedLab`: the simulated world in real time, with a camera and a motor line."""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np

from robsim import _core
from robsim._core import MotorReceiver, PlaneMap, RobotModel, RobotParameters
from robsim.base.checks import check_float, check_kind
from robsim.base.seeds import seed_sequence, stream_number
from robsim.base.text import quoted
from robsim.base.values import Closing
from robsim.lab.rehearsal.camera_faults import CameraFaults
from robsim.lab.rehearsal.lab_truth import LabTruth, truth_of
from robsim.lab.rehearsal.lens import Lens
from robsim.simulation import Scenario
from robsim.simulation.scenario_file import TABLES
from robsim.simulation.world import world_of_scenario as worlds
from robsim.vision.imaging.noise import as_native_noise

#: Most pixels of the scene per work-area px, for an oblique camera close to the floor.
_FINEST = 4.0


class SimulatedLab(Closing):
    """The simulated world in real time: a camera and a robot for rehearsals.

    ``robsim.Camera(lab)`` is its camera, which exposes `fps` times per second. The robot of the lab
    receives commands at `address`, like a real robot. The world starts when the camera is first
    opened, and runs until the lab is closed, even if no camera reads frames. Native threads run the
    world, so a callback that blocks the interpreter does not delay it.

    Parameters
    ----------
    scenario : Scenario, optional
        The world: robot, area, resolution of the frames, floor, start, noises, dropout, mismatch,
        model and seed. Options of the robot's software (such as `control` and `measure`) belong to
        the `Experiment` that drives the robot. Default: ``Scenario()``.
    fps : float
        Frames per second (1/s); a step of the world takes 1 / fps.
    faults : CameraFaults, optional
        Faults of the camera. Default: none.
    lens : Lens, optional
        Distortion of the camera's lens. Default: none.
    plane_map : PlaneMap, optional
        The camera's view: the map of its frames, before the distortion by `lens`, to the work area,
        such as from `PlaneMap.from_points`. A map with intrinsics includes the distortion of a
        lens. Pixels outside the work area are grey. Default: the whole area, seen from above.
    robot_height : float
        Height of the robot's top, with its markers, above the floor (work-area px). A height above
        0 requires a `plane_map` with intrinsics. The camera sees only the robot's top, not its
        sides.
    camera_delay : float
        Delay of a frame after its exposure (s).
    receiver : MotorReceiver, optional
        The robot's end of a motor line; the lab closes it. Default: a receiver that listens to
        UDP on this computer only, at a port that the system chooses.

    Attributes
    ----------
    area, size : tuple of int
        Width and height of the work area, and of the frames (px).
    dt : float
        Time from frame to frame (s).
    plane_map : PlaneMap
        Pixels of the frames, before the distortion by `lens`, <-> work area.
    receiver : MotorReceiver
        The robot's end of the motor line.
    scenario : Scenario
        The world, with its actual model and seed.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names it.

    Notes
    -----
    The input of a step is the mean input of the robot since the previous step. Camera noise is
    added after the optics, and process noise is added in each step. A computer that is too slow for
    the rate loses frames (`skipped_frames`), but the world keeps real time.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     with robsim.lab.UdpMotors(lab.address) as motors:
    ...         trace = robsim.Experiment(camera, send=motors, control=robsim.Spin()).run(3)
    >>> camera.size, len(trace)
    ((1200, 1200), 3)
    """

    def __init__(
        self,
        scenario: Scenario | None = None,
        *,
        fps: float = 30.0,
        faults: CameraFaults | None = None,
        lens: Lens | None = None,
        plane_map: PlaneMap | None = None,
        robot_height: float = 0.0,
        camera_delay: float = 0.0,
        receiver: MotorReceiver | None = None,
    ) -> None:
        self.dt = 1 / check_float("fps", fps, "1/s", minimum=0.1, maximum=1000)
        self._delay = check_float("camera_delay", camera_delay, "s", minimum=0, maximum=3600)
        self._faults = check_kind("faults", faults, CameraFaults, or_none=True) or CameraFaults()
        self._lens = check_kind("lens", lens, Lens, or_none=True)
        check_kind("plane_map", plane_map, PlaneMap, or_none=True)
        if plane_map is not None and plane_map.intrinsics and lens:
            raise ValueError(
                "lens must be omitted, because plane_map already has the intrinsics of a lens"
            )
        check_kind("receiver", receiver, MotorReceiver, or_none=True)
        given = check_kind("scenario", scenario, Scenario, or_none=True)
        scenario = _real_time(given or Scenario(), self.dt)
        self._seed = seed_sequence(scenario.seed)
        self.scenario = scenario.replace(seed=self._seed)
        self.area = scenario.area
        self.size = worlds.frame_size(scenario)
        self.plane_map = plane_map or PlaneMap.scaled(self.size, self.area)
        self._top_map = _map_at(self.plane_map, robot_height)
        is_from_above = plane_map is None and lens in (None, Lens())
        self._world = _new_world(self.scenario, self._seed, None if is_from_above else self._scale)
        self.receiver = MotorReceiver() if receiver is None else receiver
        model = self.scenario._model
        assert model is not None  # of `_real_time`
        self._laboratory = _core.Laboratory(self._world, model, self.receiver)
        self._warp = None if is_from_above else self._new_warp(self.plane_map)
        self._top = None if self._top_map is None else self._new_warp(self._top_map)
        self._end = weakref.finalize(self, _end, self._laboratory, self.receiver)

    @property
    def _scale(self) -> float:
        """Largest number of frame pixels per work-area px."""
        width, height = self.size
        grid = np.meshgrid(np.linspace(0, width - 1, 32), np.linspace(0, height - 1, 32))
        pixels = np.stack(grid, axis=-1).reshape(-1, 2)
        nearest = self._top_map or self.plane_map
        here, right, below = (
            nearest.to_world(pixels + shift) for shift in ((0, 0), (1, 0), (0, 1))
        )
        shortest = np.minimum(
            np.linalg.norm(right - here, axis=1), np.linalg.norm(below - here, axis=1)
        )
        is_seen = ((here >= -0.5) & (here <= np.subtract(self.area, 0.5))).all(axis=1)
        if not is_seen.any():
            raise ValueError("plane_map must show a part of the work area, but shows no part")
        return float(1 / shortest[is_seen].min())

    def _new_warp(self, seen: PlaneMap) -> _core.Warp:
        scene = self._world.scene
        assert scene is not None  # the world has started
        if self._lens is not None:
            seen = PlaneMap(seen.matrix, self._lens._before(self.size))
        return _core.view_warp(scene, self.size, seen)

    def _open_device(self) -> _core.LaboratoryCamera:
        scene = self._world.scene
        assert scene is not None
        return _core.LaboratoryCamera(
            self._laboratory,
            scene,
            warp=self._warp,
            top=self._top,
            noise=as_native_noise(self.scenario.noise),
            noise_seed=stream_number(self._seed, "noise"),
            delay=self._delay,
            faults=self._faults._native(stream_number(self._seed, "faults")),
        )

    @property
    def _headings(self) -> int | None:
        """Number of headings of the drawn robot, for the frames of a `robsim.Camera`."""
        return self.scenario.headings

    @property
    def address(self) -> str:
        """The robot's address for inputs, in the form of ``robsim.lab.UdpMotors``."""
        return self.receiver.name.removeprefix("UDP ")

    @property
    def true_model(self) -> RobotModel:
        """The model that the robot follows."""
        model = self._world.model
        assert model is not None
        return model

    @property
    def truth(self) -> LabTruth:
        """All ticks so far; any thread may read this attribute."""
        return truth_of(*self._laboratory.ticks(), self.dt)

    @property
    def skipped_frames(self) -> int:
        """Number of frames lost because the computer was too slow."""
        return self._laboratory.skipped

    def stall(self, seconds: float) -> None:
        """Stop the camera's frames for a while; any thread may call this method.

        Parameters
        ----------
        seconds : float
            Duration (s).

        Raises
        ------
        TypeError, ValueError
            If `seconds` is not a number of at least 0.
        """
        self._laboratory.stall(check_float("seconds", seconds, "s", minimum=0))

    def unplug(self) -> None:
        """Unplug the camera; any thread may call this method. The world continues."""
        self._laboratory.unplug()

    def plug_in(self) -> None:
        """Plug the camera in again; any thread may call this method."""
        self._laboratory.plug_in()

    def close(self) -> None:
        """Shut down the simulated world and the motor line for good; `truth` remains readable."""
        self._end()

    def __repr__(self) -> str:
        return f"<SimulatedLab: {self.size[0]} x {self.size[1]} px, {1 / self.dt:g} frames/s>"


def _end(laboratory: _core.Laboratory, receiver: MotorReceiver) -> None:
    if laboratory.is_elsewhere:  # lab and receiver belong to the parent process
        return
    laboratory.close()
    receiver.close()


def _map_at(plane_map: PlaneMap, height: Any) -> PlaneMap | None:
    """Return the map of a height above the floor; None for the floor itself."""
    if not check_float("robot_height", height, "work-area px", minimum=0):
        return None
    try:
        return plane_map.at_height(height)
    except ValueError as error:
        raise ValueError(f"robot_height: {error}") from error


def _real_time(scenario: Scenario, dt: float) -> Scenario:
    """Return a scenario with the model for steps of `dt`."""
    for name, remedy in (
        ("camera_delay", "pass camera_delay in s to the lab"),
        ("motor_delay", "the robot's end of the motor line has its own delays"),
    ):
        if getattr(scenario, name):
            raise ValueError(f"scenario must have {name}=0 in a lab in real time: {remedy}")
    if scenario.boundary != "bounce":
        raise ValueError(
            "scenario must have boundary='bounce' in a lab, because the lab's camera stands still, "
            f"but with boundary={quoted(scenario.boundary)} the view follows the robot"
        )
    worlds.check_bounces(scenario)
    model = scenario.model or RobotParameters()
    if isinstance(model, RobotParameters):
        values = {name: getattr(model, name) for name in TABLES[RobotParameters].keys}
        model = RobotModel(RobotParameters(**values | {"dt": dt}))
    elif not np.isclose(model.dt, dt, rtol=1e-9, atol=0):
        raise ValueError(
            f"scenario must have a model with dt = 1 / fps = {dt:g} s, got dt = {model.dt:g} s: "
            f"pass RobotParameters, which are valid for any dt, or fps={1 / model.dt:g}"
        )
    return scenario.replace(model=model)


def _new_world(
    scenario: Scenario, seed: np.random.SeedSequence, scale: float | None
) -> _core.SimulatedWorld:
    """Return the world; its scene has the size of the frames, or is drawn to a scale."""
    if scale is not None:
        width, height = (round(min(scale, _FINEST) * side) for side in scenario.area)
        scenario = scenario.replace(resolution=(max(width, 16), max(height, 16)))
    return worlds.world_of(scenario, seed, makes_scene_at_start=True)
