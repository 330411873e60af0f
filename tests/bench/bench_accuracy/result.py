"""The errors of each case, and the tables of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.report import Column, Report, Row, Table
from robsim.base.report.table import plain
from robsim.estimation import nees, wrapped_error
from robsim.trace.tracking import FALSE_POSE_LIMITS

#: What is compared, by its name in programs.
METHODS = {
    "robsim": "robsim",
    "counted": "counted",
    "weighted": "weighted",
    "opencv": "OpenCV",
    "apriltag": "AprilTag",
}

# One way to measure a pose in a case: a pose (3,) for each frame, None = not found.
Poses = Sequence[Floats | None]


@dataclass(frozen=True, kw_only=True)
class Errors:
    """The errors of one way to measure in one case.

    Attributes
    ----------
    xy : float
        Root mean square of the error in place, x and y together, of the poses that are not false
        (work-area px); NaN if there are none.
    heading_deg : float
        That of the heading (degrees).
    misses : int
        Frames in which nothing was found.
    false_poses : int
        Poses more than 10 px or 20 degrees off.
    nees : float or None
        Mean NEES / 3 of the poses that are not false, 1 if the covariance that comes with them is
        right; None if they come without.
    """

    xy: float
    heading_deg: float
    misses: int
    false_poses: int
    nees: float | None = None

    @property
    def lost(self) -> int:
        """Frames without a pose that is right."""
        return self.misses + self.false_poses

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers by their names in JSON."""
        return {
            "rms_xy": self.xy,
            "rms_heading_deg": self.heading_deg,
            "misses": self.misses,
            "false": self.false_poses,
        }


def errors_of(poses: Poses, truth: Floats, covariances: Sequence[Floats | None] = ()) -> Errors:
    """Return the errors of measured poses.

    Parameters
    ----------
    poses : sequence of N arrays (3,) or None
        The measured poses; None = not found.
    truth : array (N, 3)
        The true ones.
    covariances : sequence of N arrays (3, 3) or None, optional
        What the measurement says of its errors; None where it says nothing.
    """
    measured = np.array([np.full(3, np.nan) if pose is None else pose for pose in poses])
    error = wrapped_error(measured, truth)
    distance, turn = np.hypot(error[:, 0], error[:, 1]), np.abs(error[:, 2])
    is_found = ~np.isnan(distance)
    limit, widest = FALSE_POSE_LIMITS
    is_right = is_found & (distance <= limit) & (turn <= widest)
    return Errors(
        xy=_rms(distance[is_right]),
        heading_deg=math.degrees(_rms(turn[is_right])),
        misses=int((~is_found).sum()),
        false_poses=int((is_found & ~is_right).sum()),
        nees=_mean_nees(error, is_right, covariances),
    )


def _rms(values: Floats) -> float:
    return math.sqrt(np.square(values).mean()) if len(values) else math.nan


def _mean_nees(
    error: Floats, is_right: NDArray[np.bool_], covariances: Sequence[Floats | None]
) -> float | None:
    known = [
        (row, P)
        for row, right, P in zip(error, is_right, covariances, strict=False)
        if right and P is not None
    ]
    return float(np.mean([nees(row, P) for row, P in known])) / 3 if known else None


@dataclass(frozen=True, kw_only=True)
class AccuracyCase:
    """A size of the frames, a noise, and what was measured in them.

    Attributes
    ----------
    name : str
        Size, kind and percentage of the noise, such as ``"480_gaussian_10"``.
    size : int
        Width and height of the frames (px).
    kind : str
        ``"gaussian"`` or ``"uniform"``; ``"clean"`` without noise.
    percent : float
        Level of the noise.
    bound_xy, bound_heading_deg : float
        Root mean square of the bounds of all frames (work-area px, degrees).
    errors : dict of str to Errors
        By the names in `METHODS`.
    """

    name: str
    size: int
    kind: str
    percent: float
    bound_xy: float
    bound_heading_deg: float
    errors: Mapping[str, Errors]

    def to_dict(self) -> dict[str, Any]:
        """Return robsim's numbers, the bound, and those of the others by their names."""
        others = {name: self.errors[name].to_dict() for name in METHODS if name != "robsim"}
        ours = self.errors["robsim"]
        bound = {"bound_xy": self.bound_xy, "bound_heading_deg": self.bound_heading_deg}
        return ours.to_dict() | bound | {"nees": ours.nees} | others


@dataclass(frozen=True, kw_only=True)
class AccuracyResult(Report):
    """How exact the measurement is.

    Attributes
    ----------
    frames : int
        Frames of each case.
    cases : tuple of AccuracyCase
        The cases, those of a size together.
    """

    frames: int
    cases: tuple[AccuracyCase, ...]

    @property
    def title(self) -> str:
        """What was measured."""
        frames = "1 frame" if self.frames == 1 else f"{self.frames} frames"
        return f"Errors of measured poses, {frames} a case"

    @property
    def tables(self) -> tuple[Table, ...]:
        """Errors of place and heading, and what was lost."""
        return (
            self._errors("xy", "place (px)"),
            self._errors("heading_deg", "heading (deg)"),
            self._lost,
        )

    def _errors(self, key: str, title: str) -> Table:
        columns = [
            Column("bound", "bound", "", ".4f"),
            *(Column(name, shown, "", ".3f") for name, shown in METHODS.items()),
            Column("ratio", "robsim/bound", "", ".2f"),
        ]
        rows = []
        for case in self.cases:
            bound = getattr(case, f"bound_{key}")
            errors = [getattr(case.errors[name], key) for name in METHODS]
            rows.append(Row(case.name, [bound, *errors, errors[0] / bound]))
        return self._table(key, title, columns, rows)

    @property
    def _lost(self) -> Table:
        columns = [Column(name, shown, "", ".0f") for name, shown in METHODS.items()]
        rows: list[list[float | None]] = [
            [case.errors[name].lost for name in METHODS] for case in self.cases
        ]
        if self._has_covariances:
            columns.append(Column("nees", "NEES / 3 of robsim", "", ".2f"))
            rows = [
                [*row, case.errors["robsim"].nees]
                for case, row in zip(self.cases, rows, strict=True)
            ]
        named = [Row(case.name, row) for case, row in zip(self.cases, rows, strict=True)]
        return self._table("lost", "missed or false", columns, named)

    def _table(self, key: str, title: str, columns: list[Column], rows: list[Row]) -> Table:
        sizes = len({case.size for case in self.cases})
        group = len(self.cases) // sizes
        return Table(key=key, columns=columns, rows=rows, row_title=title, group=group)

    @property
    def _has_covariances(self) -> bool:
        return any(case.errors["robsim"].nees is not None for case in self.cases)

    @property
    def remarks(self) -> tuple[str, ...]:
        """How to read a row."""
        limit, widest = FALSE_POSE_LIMITS
        remarks = (
            "a row: width of the frames in px, noise, its percentage; root mean square error of "
            "the poses that are found and not false, x and y together, in px of an area of "
            "1200 x 1200",
            f"missed or false: frames, of {self.frames}, in which nothing was found, or a pose "
            f"more than {limit:g} px or {math.degrees(widest):.0f} degrees off",
            "bound: what the pixels of both markers allow; for uniform noise and clean frames the "
            "best estimate that is linear in the pixels",
            "counted, weighted: centroids of robsim's blobs, of pixels alike or by their chroma, "
            "clipped; OpenCV: moments of the contours of the same mask",
            "AprilTag: a 36h11 in the robot's place whose black square is as large as both markers "
            "together, by cv2.aruco, searched around its place, enlarged twice; it has sharper "
            "contrasts and more edges than the markers, so their bound is not its own",
        )
        nees = "NEES / 3: its mean is 1 where the covariances of the measurements are right"
        return (*remarks, nees) if self._has_covariances else remarks

    def to_dict(self) -> dict[str, Any]:
        """Return the cases by their names: robsim's errors, the bound, the errors of the others."""
        values: dict[str, Any] = plain(
            {
                "title": self.title,
                "frames": self.frames,
                "cases": {case.name: case.to_dict() for case in self.cases},
                "units": {"rms_xy": "px", "rms_heading_deg": "deg"},
                "remarks": self.remarks,
            }
        )
        return values
