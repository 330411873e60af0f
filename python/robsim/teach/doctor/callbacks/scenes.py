"""Simulated worlds with frames, in which the doctor tries controllers and measurements."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import Estimate, Measurement, RobotModel, Step, WorldState, locate, wrap_angle
from robsim.base.checks import Floats
from robsim.simulation import Dropout, Scenario, Simulation
from robsim.simulation.world.world_of_scenario import frame_size
from robsim.teach.doctor._situations import DT, Situation
from robsim.teach.doctor._trial import TIME_LIMIT
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise, Noise
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import load_robot

AREA = (1200, 1200)  # px
CENTRE = (600.0, 600.0, 0.0)  # px, px, rad

Place = tuple[float, float]
_SEED = 1
_HIDDEN = Dropout(1.0)
_NOISE = GaussianNoise(5.0)
_WALL = 150.0  # px
_CLEAN = np.diag((1.3e-4, 1.3e-4, 3e-7))  # px^2, px^2, rad^2: of a frame without noise


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene(Situation):
    """A robot in a simulated world with a camera.

    A measurement of None hides the robot. The poses belong to the robot; of a driven robot, only
    the start.
    """

    is_driven: bool = False  # whether the inputs move the robot
    noise: Noise | None = None  # of the camera
    resolution: tuple[int, int] = AREA  # of the frames (px)
    background: Callable[[Pixels], Pixels] | None = None  # None = with a red square
    robot: RobotDefinition
    area: tuple[int, int] = AREA  # width, height (px)

    @property
    def is_hidden(self) -> list[bool]:
        return [measurement is None for measurement in self.measurements]


@dataclass(frozen=True, kw_only=True)
class Setting:
    """The robot, the work area and the camera of scenes, whose places are in px of `AREA`."""

    robot: RobotDefinition
    area: tuple[int, int] = AREA  # px
    resolution: tuple[int, int] = AREA  # of the frames (px)
    noise: GaussianNoise = _NOISE  # of the camera, in scenes with noise

    @classmethod
    def usual(cls) -> Setting:
        """Return the setting of the robot that the user has chosen, one frame pixel per px."""
        return cls(robot=default_robot())

    @classmethod
    def of(cls, scenario: Scenario) -> Setting:
        noise = scenario.noise if isinstance(scenario.noise, GaussianNoise) else cls.noise
        robot, size = scenario._robot_definition, frame_size(scenario)
        return cls(robot=robot, area=scenario.area, resolution=size, noise=noise)

    def place(self, place: Place) -> Place:
        x, y = self.places(np.array(place))
        return float(x), float(y)

    def places(self, places: Floats) -> Floats:
        """Return places of `AREA`, (2,) or (N, 2), in this work area."""
        return np.asarray(places * self.area / AREA)

    def driven(
        self,
        name: str,
        start: tuple[float, float, float],
        steps: int,
        *,
        hidden: Collection[int] = (),
    ) -> Scene:
        poses = np.tile((*self.place(start[:2]), start[2]), (steps, 1))
        return self.scripted(name, poses, hidden=hidden, is_driven=True)

    def turned(self, name: str, place: Place, headings: ArrayLike, **options: Any) -> Scene:
        turns = np.asarray(headings, dtype=float)
        poses = np.column_stack((np.tile(self.place(place), (len(turns), 1)), turns))
        return self.scripted(name, poses, **options)

    def scripted(
        self, name: str, poses: ArrayLike, *, hidden: Collection[int] = (), **options: Any
    ) -> Scene:
        """Return a scene in which the robot stands at given poses, independent of the inputs."""
        path = np.array(poses, dtype=float)
        path[:, 2] = [wrap_angle(heading) for heading in path[:, 2]]
        return Scene(
            name=name,
            dt=DT,
            poses=path,
            u=np.zeros((len(path), 2)),
            measurements=tuple(None if k in hidden else Measurement(p) for k, p in enumerate(path)),
            robot=self.robot,
            area=self.area,
            resolution=self.resolution,
            **options,
        )


@cache
def default_robot() -> RobotDefinition:
    """Return the robot that the user has chosen."""
    return load_robot()


def simulate(
    scene: Situation, callback: Callable[[Step], Any], slot: str, **slots: Any
) -> Simulation:
    assert isinstance(scene, Scene)
    hidden = scene.is_hidden
    pose: Floats = scene.poses[0]

    def evaluate_model(world: WorldState) -> Floats:
        nonlocal pose
        if scene.is_driven:
            pose = world.model.predict(world.pose_1, world.pose_2, world.last_u)
        else:
            pose = np.asarray(scene.poses[world.k])
        return pose

    def measure(step: Step) -> Measurement | None:
        """Return the true pose, without a frame to be drawn."""
        if step.k < len(hidden) and hidden[step.k]:
            return None
        if min(*pose[:2], *(scene.area - pose[:2])) < _WALL:  # it may have bounced
            return locate(step.blobs, step.markers, image=step.frame)
        return Measurement((*pose[:2], wrap_angle(pose[2])), covariance=_CLEAN)

    def call(step: Step) -> Any:
        result = callback(step)
        if step.k + 1 < len(hidden) and hidden[step.k + 1] != hidden[step.k]:
            simulation.dropout = _HIDDEN if hidden[step.k + 1] else None
        return result

    simulation = Simulation(
        robot=scene.robot,
        area=scene.area,
        resolution=scene.resolution,
        headings=None,
        noise=scene.noise,
        dropout=_HIDDEN if hidden[0] else None,
        start=scene.poses[0],
        adjust_background=scene.background,
        evaluate_model=evaluate_model,
        seed=_SEED,
        time_limit=TIME_LIMIT,
        **{"measure": measure} | slots | {slot: call},
    )
    return simulation


class LastPose:
    """A state estimator for the test of a controller: the last measured pose."""

    def __init__(self) -> None:
        self._pose: Floats = np.array(CENTRE)

    def __call__(self, step: Step) -> Estimate:
        if step.measurement is not None:
            self._pose = step.measurement.pose
        return Estimate(self._pose, np.eye(3))


def model_parameters(step: Step) -> Floats:
    return RobotModel().theta
