"""`run_accuracy_bench`: the errors of measured poses, case by case."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from bench_accuracy.apriltag import AprilTag
from bench_accuracy.blobs import BlobMethods
from bench_accuracy.result import AccuracyCase, AccuracyResult, Errors, errors_of
from robsim._core import Frame, PlaneMap, Renderer
from robsim.base.checks import Floats, check_int
from robsim.cli.simulated.bench import AREA
from robsim.estimation.evaluation._measurement_bound import SeenMarkers, marker_polygons
from robsim.simulation.experiment import Experiment
from robsim.simulation.runner import progress_bar
from robsim.simulation.world.scene import draw_red_square, make_scene
from robsim.vision import RobotDefinition, load_robot
from robsim.vision.imaging.noise import GaussianNoise, Noise, UniformNoise
from robsim.vision.imaging.video import load_opencv

SIZES = (1200, 480)
LEVELS = (2.0, 5.0, 10.0, 20.0, 40.0)
NOISES: tuple[Noise | None, ...] = (
    None,
    *(GaussianNoise(percent) for percent in LEVELS),
    *(UniformNoise(percent) for percent in LEVELS),
)
_SEED = 19
_MOST_FRAMES = 10_000  # of each case: each takes some 100 kB for its bound


def run_accuracy_bench(
    *,
    frames: int,
    sizes: tuple[int, ...] = SIZES,
    noises: tuple[Noise | None, ...] = NOISES,
) -> AccuracyResult:
    """Measure the poses of a robot that is drawn at known ones, by robsim and by others.

    Parameters
    ----------
    frames : int
        Frames of each case, with the robot anywhere within the area: the same poses in all.
    sizes : tuple of int
        Widths and heights of the frames (px).
    noises : tuple of GaussianNoise, UniformNoise or None
        The camera's noise.

    Returns
    -------
    AccuracyResult
        The errors; print it.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If `frames` is no int, or out of range.
    """
    check_int("frames", frames, minimum=1, maximum=_MOST_FRAMES)
    cv2 = load_opencv("the comparison")
    robot = load_robot("lab")
    poses = _poses(robot, frames)
    cases = []
    with progress_bar(total=len(sizes) * len(noises) * frames, unit=" frames") as bar:
        for size in sizes:
            places = _Places(cv2, robot, size, poses)
            cases += [places.measured(noise, bar) for noise in noises]
    return AccuracyResult(frames=frames, cases=tuple(cases))


def _poses(robot: RobotDefinition, count: int) -> Floats:
    """Return poses (N, 3) at which the robot is within the area."""
    rng = np.random.default_rng(_SEED)
    x, y = (rng.uniform(robot.radius, side - robot.radius, count) for side in AREA)
    return np.column_stack((x, y, rng.uniform(-math.pi, math.pi, count)))


class _Places:
    """The poses of a benchmark as a camera of one size sees them.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    robot : RobotDefinition
        The robot.
    size : int
        Width and height of the frames (px).
    poses : array (N, 3)
        Where it is.
    """

    def __init__(self, cv2: Any, robot: RobotDefinition, size: int, poses: Floats) -> None:
        self._cv2, self._robot, self._size, self._poses = cv2, robot, size, poses
        layout = robot.marker_layout()
        self._tag = AprilTag(cv2, sum(layout.areas.values()))
        self._plane_map = PlaneMap.scaled((size, size), AREA)
        polygons = marker_polygons(robot)
        self._seen = [
            SeenMarkers(frame, pose, polygons)
            for frame, pose in zip(self._frames(robot, None), poses, strict=True)
        ]

    def measured(self, noise: Noise | None, bar: Any) -> AccuracyCase:
        """Return what is measured with a noise."""
        kind, percent = ("clean", 0.0) if noise is None else (noise._kind, float(noise.percent))
        least = [seen.bound(noise) for seen in self._seen]
        return AccuracyCase(
            name=f"{self._size}_{kind}" + (f"_{percent:g}" if percent else ""),
            size=self._size,
            kind=kind,
            percent=percent,
            bound_xy=_rms([bound.rmse_xy for bound in least]),
            bound_heading_deg=_rms([bound.rmse_heading_deg for bound in least]),
            errors=self._errors(noise, bar),
        )

    def _errors(self, noise: Noise | None, bar: Any) -> dict[str, Errors]:
        experiment = Experiment(
            self._frames(self._robot, noise), robot=self._robot, area=AREA, measure=True
        )
        tags = self._frames(self._tag.definition(), noise)
        found: dict[str, list[Floats | None]] = {}
        covariances: list[Floats | None] = []
        for pose, tag in zip(self._poses, tags, strict=True):
            step = experiment.step()
            frame, blobs, measurement = step.frame, step.blobs, step.measurement
            assert frame is not None
            methods = BlobMethods(
                self._cv2, experiment.colors, experiment.markers, experiment._core.smoothing
            )
            for name, value in (
                ("robsim", None if measurement is None else measurement.pose),
                ("counted", methods.counted(frame, blobs)),
                ("weighted", methods.weighted(frame, blobs)),
                ("opencv", methods.opencv(frame)),
                ("apriltag", self._tag.pose(tag, near=pose)),
            ):
                found.setdefault(name, []).append(value)
            covariances.append(None if measurement is None else measurement.covariance)
            bar.update()
        return {
            name: errors_of(poses, self._poses, covariances if name == "robsim" else ())
            for name, poses in found.items()
        }

    def _frames(self, robot: RobotDefinition, noise: Noise | None) -> Iterator[Frame]:
        """Yield the frames of a robot at all poses."""
        scene = make_scene(
            robot=robot,
            area=AREA,
            resolution=(self._size, self._size),
            headings=0,
            background=None,
            adjust_background=draw_red_square,
        )
        renderer = Renderer(scene)
        for index, pose in enumerate(self._poses):
            clean = renderer.render(pose)
            image = clean if noise is None else noise.add(clean, _SEED, index)
            yield Frame(image, index=index, plane_map=self._plane_map)


def _rms(values: list[float]) -> float:
    return math.sqrt(float(np.mean(np.square(values))))
