"""The least error of a measured pose that the pixels of the markers allow."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import Frame
from robsim.base.checks import Floats, as_float_array, check_kind
from robsim.base.report import Quantity, Report
from robsim.base.text import quoted
from robsim.vision.imaging.noise import GaussianNoise, Noise, as_native_noise
from robsim.vision.robots.polygons import area_and_centroid, blurred, depths, samples

# Frame px: how far outside of a marker pixels are used; how far it is moved for derivatives.
_MARGIN = 2.5
_STEP = 0.02
_SHARPEST_CURVE = math.radians(30)  # at a corner of a polygon that stands for a curve


class MarkerView:
    """The pixels of a marker in a frame, with the covered share of each."""

    def __init__(self, frame: Frame, pose: Floats, polygon: Floats) -> None:
        self._plane_map, self._pose = frame.plane_map, pose
        # dense where a lens may bend its sides
        self._outline = polygon if self._plane_map.intrinsics is None else samples(polygon)
        corners = self._in_frame(pose)
        height, width = frame.image.shape[:2]
        left, top = np.floor(corners.min(axis=0) - _MARGIN).clip(0, (width, height)).astype(int)
        right, bottom = np.ceil(corners.max(axis=0) + _MARGIN).clip(0, (width, height)).astype(int)
        down, across = np.mgrid[top:bottom, left:right]
        self._pixels = np.column_stack((across.ravel(), down.ravel())).astype(float)
        depth = depths(corners, self._pixels)
        is_used = depth > -_MARGIN
        if depth.max(initial=-1.0) <= 0:
            raise _not_shown(pose)
        self._pixels, self.depth = self._pixels[is_used], depth[is_used]
        self._has_corners = _has_corners(polygon)
        self.values = frame.image[down.ravel()[is_used], across.ravel()[is_used]].astype(float)

    def _in_frame(self, pose: Floats) -> Floats:
        """Return the outline at a pose in px of the frame (N, 2)."""
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        # position = centre + R(heading) (forward, right)
        positions = self._outline @ np.array(((cos, sin), (-sin, cos))) + pose[:2]
        pixels = self._plane_map.to_pixel(positions)
        if not np.isfinite(pixels).all():
            raise _not_shown(pose)
        return np.asarray(pixels)

    def _covered(self, moved: Floats, width: float) -> Floats:
        """Return the coverages (N,) with the marker moved by so much (px, px, rad)."""
        from scipy.special import ndtr

        if self._has_corners:
            return blurred(self._in_frame(self._pose + moved), self._pixels, width)
        depth = self.depth
        if moved.any():
            depth = depths(self._in_frame(self._pose + moved), self._pixels)
        covered: Floats = ndtr(depth / width)
        return covered

    def changes(self, width: float) -> Floats:
        """Return the derivatives of the coverages by pose and ln w (N, 4)."""
        # One step moves the marker by about _STEP px of the frame.
        across = (
            np.ptp(self._outline, axis=0).max() / np.ptp(self._in_frame(self._pose), axis=0).max()
        )
        far = np.linalg.norm(self._outline, axis=1).max()
        steps = _STEP * np.array((across, across, across / far, 1.0))
        changes = np.empty((len(self.depth), 4))
        for i, step in enumerate(steps):
            ahead, behind = (
                self._covered(moved[:3], width * math.exp(moved[3]))
                for moved in np.eye(4)[i] * np.array(((step,), (-step,)))
            )
            changes[:, i] = (ahead - behind) / (2 * step)
        return changes

    def coverage(self, width: float) -> Floats:
        """Return 1 and the coverage of each pixel (N, 2)."""
        covered = self._covered(np.zeros(3), width)
        return np.column_stack((np.ones_like(covered), covered))

    def levels(self, coverage: Floats) -> Floats:
        """Return level and contrast of each channel (2, 3), by least squares."""
        return np.asarray(np.linalg.lstsq(coverage, self.values, rcond=None)[0])

    def misfit(self, width: float) -> float:
        """Return the sum of the squared residuals."""
        coverage = self.coverage(width)
        residuals = self.values - coverage @ self.levels(coverage)
        return float(np.square(residuals).sum())

    def channels(self, width: float, coverage: Floats) -> Iterator[tuple[Floats, Floats, float]]:
        """Yield mean (N,), its derivatives by pose and ln w (N, 4), and contrast of a channel."""
        changes = self.changes(width)
        for level, contrast in self.levels(coverage).T:
            yield level + contrast * coverage[:, 1], contrast * changes, float(contrast)


def _has_corners(polygon: Floats) -> bool:
    """Whether the outline turns by more at a corner than for corners that approximate a curve."""
    side = np.roll(polygon, -1, axis=0) - polygon
    way = np.arctan2(side[:, 1], side[:, 0])
    turn = (np.roll(way, -1) - way + np.pi) % (2 * np.pi) - np.pi
    return bool(np.abs(turn).max() > _SHARPEST_CURVE)


def _not_shown(pose: Floats) -> ValueError:
    return ValueError(f"pose must show the markers in the frame, got {quoted(pose.tolist())}")


def density(q: Floats) -> Floats:
    """Return the density of the standard normal distribution."""
    density: Floats = np.exp(-0.5 * np.square(q)) / math.sqrt(2 * math.pi)
    return density


_ROUNDING = 1 / 12  # variance of the rounding error (grey levels^2)
_PER_LEVEL = 16  # means of the table in a grey level
_RARE = 1e-12  # probability of a value that tells nothing


def pixel_information(noise: Noise | None) -> Callable[[Floats], Floats]:
    """Return the function mean (N,) -> information of a pixel of that mean (N,).

    Gaussian noise: Fisher's information of the value k = round(mu + e), clipped to 0..255,

        J(mu) = sum_k P_k'(mu)^2 / P_k(mu)

    Others: the information of the best estimate that is linear in the value, (d mean / d mu)^2 /
    variance. J is averaged over a grey level, as the place of the mean between two is unknown. It
    is at most 12, as for a value that is rounded without noise.
    """
    if noise is None or noise.percent == 0:
        return lambda mean: np.full(len(mean), 1 / _ROUNDING)
    means, table = _table(noise)
    return lambda mean: np.interp(mean, means, table)


@functools.lru_cache(maxsize=32)
def _table(noise: Noise) -> tuple[Floats, Floats]:
    """Return means (M,) and the information of each (M,)."""
    half = _PER_LEVEL // 2
    means = np.arange(-half, 255 * _PER_LEVEL + half + 1) / _PER_LEVEL
    # How far the limits between the values 0, 1, ... 255 lie above each mean.
    limits = np.arange(0.5, 255) - means[:, np.newaxis]
    scale = 2.55 * noise.percent
    table = _fisher(limits, scale) if isinstance(noise, GaussianNoise) else _linear(limits, scale)
    return means[half:-half], np.minimum(table, 1 / _ROUNDING)


def _fisher(limits: Floats, sigma: float) -> Floats:
    """Return Fisher's information for Gaussian noise, averaged over a grey level."""
    from scipy.special import ndtr

    z = limits / sigma
    ends = np.zeros((len(z), 1))
    # P_k = Phi(z_k+1) - Phi(z_k),  P_k' = (phi(z_k) - phi(z_k+1)) / sigma
    P = np.diff(np.hstack((ends, ndtr(z), ends + 1)))
    density = np.exp(-0.5 * np.square(z)) / (sigma * math.sqrt(2 * math.pi))
    change = np.diff(np.hstack((ends, density, ends)))
    terms = np.divide(np.square(change), P, out=np.zeros_like(P), where=P > _RARE)
    return _averaged(terms.sum(axis=1))


def _linear(limits: Floats, half_width: float) -> Floats:
    """Return the information of the best linear estimate for uniform noise, averaged likewise."""
    above = np.clip((half_width - limits) / (2 * half_width), 0, 1)
    # mean = sum P(value > k), mean of the square = sum (2 k + 1) P(value > k), k = 0..254
    mean = above.sum(axis=1)
    variance = above @ np.arange(1.0, 511, 2) - np.square(mean)
    slope = (np.abs(limits) < half_width).sum(axis=1) / (2 * half_width)
    bias = mean - (0.5 - limits[:, 0])
    spread = _averaged(variance + np.square(bias)) - np.square(_averaged(bias))
    information: Floats = np.square(_averaged(slope)) / spread
    return information


def _averaged(values: Floats) -> Floats:
    """Return the means over a grey level around each; at both ends half a level is missing."""
    weights = np.full(_PER_LEVEL + 1, 1 / _PER_LEVEL)
    weights[[0, -1]] /= 2
    return np.convolve(values, weights, mode="valid")


_EDGE_WIDTHS = (0.15, 4.0)  # px of the frame: the range of the edge width
_NOTHING = 1e-6  # of a signal; of an area
_FARTHEST = 1e4  # px, of a corner from the robot's centre


class _Robot(Protocol):
    """The part of a robot definition that the bound needs."""

    @property
    def markers(self) -> Mapping[str, Floats]: ...

    def to_robot_frame(self, points: ArrayLike) -> Floats: ...


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasurementBound(Report):
    """The smallest possible error of a measured pose, from `measurement_bound`.

    Attributes
    ----------
    covariance : array (3, 3)
        Least covariance of x, y (work-area px) and heading (rad).
    signal_to_noise : float
        Ratio of the markers' edges to the noise: poses are reliable from 4 on.
    edge_width : float
        Standard deviation of the blur across the edges (px of the frame).
    is_bound : bool
        False for uniform noise and without noise, where the bound covers only estimates that are
        linear in the pixels.

    Examples
    --------
    >>> sim = robsim.Simulation(headings=None, start=(500, 600, 0.3))
    >>> step = sim.step()
    >>> bound = robsim.estimation.measurement_bound(sim.frame, (500, 600, 0.3), sim.robot)
    >>> bound.signal_to_noise > 100
    True
    """

    covariance: Floats
    signal_to_noise: float
    edge_width: float
    is_bound: bool

    @property
    def rmse_xy(self) -> float:
        """Smallest possible root mean square error of the position (x, y) (work-area px)."""
        return math.sqrt(self.covariance[0, 0] + self.covariance[1, 1])

    @property
    def rmse_heading_deg(self) -> float:
        """Smallest possible root mean square error of the heading (degrees)."""
        return math.degrees(math.sqrt(self.covariance[2, 2]))

    @property
    def title(self) -> str:
        """The kind of bound."""
        return "Least error of a measured pose" if self.is_bound else "Best linear measurement"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The errors, and the signal-to-noise ratio and the width of the edges."""
        width = "blur of the edges, px of the frame"
        return (
            Quantity("rmse_xy", "rmse of the position", self.rmse_xy, "px", ".4f"),
            Quantity(
                "rmse_heading_deg", "rmse of the heading", self.rmse_heading_deg, "deg", ".4f"
            ),
            Quantity("signal_to_noise", "signal to noise", self.signal_to_noise, "", _ratio),
            Quantity("edge_width", width, self.edge_width, "", ".2f"),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """A doubt about the pose."""
        if self.edge_width < 0.9 * _EDGE_WIDTHS[1]:
            return ()
        return (
            f"no blur up to {_EDGE_WIDTHS[1]:g} px fits the markers' edges: check the frame's "
            "sharpness, and whether the robot is at this pose",
        )


def _ratio(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def measurement_bound(
    frame: Frame,
    pose: ArrayLike,
    robot: _Robot | Sequence[ArrayLike],
    *,
    noise: Noise | None = None,
) -> MeasurementBound:
    """Return the smallest possible error of a pose measured from the robot's markers.

    The bound uses only pixels of the markers and pixels around them. The bound takes three
    properties as unknown: the brightness of the markers, the brightness of the floor next to them,
    and the blur. The rest of the robot does not count.

    Parameters
    ----------
    frame : Frame
        The source of brightness, contrast, blur, and scale (with its plane map): a frame with
        little or no noise. If this frame has 40 % noise and 10 px markers, the result is twice the
        bound.
    pose : array (3,)
        Pose of the robot in the frame: x, y (work-area px), heading (rad).
    robot : RobotDefinition or sequence of array (N, 2)
        The robot; or the polygons of its markers in the robot's frame: forward, right
        (work-area px from its centre).
    noise : GaussianNoise, UniformNoise or None
        The camera's noise, rounded and clipped to 0..255 as by its method `add`. None: only
        rounding.

    Returns
    -------
    MeasurementBound
        The covariance, the root mean square errors and the signal-to-noise ratio.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or no pixel of a marker is in the frame.

    Notes
    -----
    The marker k covers the fraction K of a pixel i. The pixel has the mean in the channel c

        mu = level_kc + contrast_kc K

    K is the integral over the marker of a normal distribution around the pixel [2]_. For a polygon
    that represents a curve, K is Phi(d / w) at a distance of d px inside the edge. The standard
    deviation w of the blur, all levels and all contrasts are unknown, like the pose. With the
    information J(mu) of a pixel the pose has the information

        N = sum_ic J(mu_ic) g_ic g_ic',   g_ic = d mu_ic / d(pose, ln w, levels, contrasts)

    and the bound is the part of N^-1 that belongs to the pose. For Gaussian noise, J is the Fisher
    information of the rounded and clipped value, and the result is the Cramér-Rao bound [1]_. The
    limits of uniform noise and of rounding move with the pose, so that it has no such bound: J is
    (d mean / d mu)^2 / variance, and no estimate that is linear in the pixels is better.
    signal_to_noise^2 = sum_ic J(mu_ic) (contrast_kc phi(d_i / w))^2: the rms error of the position
    is about 2 w / signal_to_noise for two round markers.

    References
    ----------
    .. [1] S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, 3.9, 1993.
    .. [2] D. B. Owen, Tables for computing bivariate normal probabilities, 1956.

    Examples
    --------
    >>> sim = robsim.Simulation(robot="lab", headings=None, start=(500, 600, 0.3))
    >>> step = sim.step()
    >>> noise = robsim.GaussianNoise(10)
    >>> pose = (500, 600, 0.3)
    >>> bound = robsim.estimation.measurement_bound(sim.frame, pose, sim.robot, noise=noise)
    >>> round(bound.rmse_xy, 3)
    0.039
    """
    check_kind("frame", frame, Frame)
    place = as_float_array("pose", pose)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ValueError(f"pose must be 3 finite numbers (px, px, rad), got {quoted(pose)}")
    as_native_noise(noise)  # raises for another type
    return SeenMarkers(frame, place, marker_polygons(robot)).bound(noise)


class SeenMarkers:
    """A robot's markers in a frame, as polygons (N, 2) in its axes (work-area px), for its pose."""

    def __init__(self, frame: Frame, pose: Floats, polygons: Sequence[Floats]) -> None:
        self._pose = pose
        self._views = [MarkerView(frame, pose, polygon) for polygon in polygons]
        self._width = _edge_width(self._views)

    def bound(self, noise: Noise | None) -> MeasurementBound:
        """Return the least error of a measured pose for a noise; see `measurement_bound`."""
        information_at, width = pixel_information(noise), self._width
        information, strength = np.zeros((4, 4)), 0.0
        for view in self._views:
            coverage = view.coverage(width)
            for mean, change, contrast in view.channels(width, coverage):
                weight = information_at(mean)
                information += _without_levels(change, coverage, weight)
                # SNR^2 = sum J (contrast phi(q))^2
                strength += float(weight @ (contrast * density(view.depth / width)) ** 2)
        if strength < _NOTHING:
            raise ValueError(
                "frame must show markers that differ from their surroundings, got a "
                f"signal-to-noise ratio of {math.sqrt(strength):.1f} at the pose "
                f"{quoted(self._pose.tolist())}"
            )
        return MeasurementBound(
            covariance=_inverse(information)[:3, :3],
            signal_to_noise=math.sqrt(strength),
            edge_width=width,
            is_bound=isinstance(noise, GaussianNoise),
        )


def _inverse(information: Floats) -> Floats:
    """Return the covariance; ValueError if the markers do not determine the whole pose."""
    try:
        covariance = np.linalg.inv(information)
    except np.linalg.LinAlgError:
        covariance = np.full((4, 4), np.inf)
    variances = np.diag(covariance)
    # Rounding errors make an enormous variance of an infinite one, or a negative one.
    if not ((variances >= 0) & (variances < _FARTHEST**2)).all():
        raise ValueError(
            "robot must have markers that determine its position and heading, but the edges in "
            "the frame fit several poses, as a single straight edge does, or are lost in the noise"
        )
    return np.asarray(covariance, np.float64)


def marker_polygons(robot: Any) -> list[Floats]:
    """Return the polygons of the markers in the robot's frame."""
    if hasattr(robot, "to_robot_frame"):
        return [robot.to_robot_frame(marker.polygon) for marker in robot.markers.values()]
    if not isinstance(robot, (list, tuple)) or not robot:
        raise TypeError(
            "robot must be a RobotDefinition or a sequence of polygons, one per marker, "
            f"got {quoted(robot)}"
        )
    return [_checked_polygon(as_float_array("robot", polygon)) for polygon in robot]


def _checked_polygon(polygon: Floats) -> Floats:
    """Return a marker's polygon; ValueError for another type, or beyond all pictures."""
    given = quoted(polygon.tolist())
    is_polygon = polygon.ndim == 2 and polygon.shape[1] == 2 and len(polygon) >= 3
    if not is_polygon or not np.isfinite(polygon).all():
        raise ValueError(f"robot must have polygons of shape (N, 2), N >= 3, got {given}")
    if np.abs(polygon).max() > _FARTHEST:
        raise ValueError(
            f"robot must have polygons within {_FARTHEST:g} px of its centre, got {given}"
        )
    area, _ = area_and_centroid(polygon)
    if area <= _NOTHING * max(float(np.ptp(polygon)) ** 2, _NOTHING):
        raise ValueError(f"robot must have polygons with an area, got {given}")
    return polygon


def _edge_width(views: Sequence[MarkerView]) -> float:
    """Return the width of the edges (px of the frame) that fits the frame best."""
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda width: sum(view.misfit(width) for view in views),
        bounds=_EDGE_WIDTHS,
        method="bounded",
        options={"xatol": 1e-3},
    )
    return float(found.x)


def _without_levels(change: Floats, basis: Floats, weight: Floats) -> Floats:
    """Return the remaining information if level and contrast are unknown, too (4, 4)."""
    weighted = weight[:, np.newaxis] * basis
    cross = change.T @ weighted
    # N - C B^-1 C'
    information: Floats = (change.T * weight) @ change - cross @ np.linalg.solve(
        basis.T @ weighted, cross.T
    )
    return information
