"""The report of a calibrated lens: residuals, coverage, and missing pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.base.report import Column, Problem, Quantity, Report, Row, Table
from robsim.base.text import listed
from robsim.vision.imaging.calibration import Calibration

_WORDS = (
    ("top left", "top", "top right"),
    ("left", "centre", "right"),
    ("bottom left", "bottom", "bottom right"),
)
_PICTURES = 8  # with fewer, the lens is poorly determined
_RMS = (0.5, 1.5)  # px: good, poor
_TILT = np.radians(15)
_TILTED = 3  # pictures
_FOCAL = (0.005, 0.03)  # standard deviation, relative


def coverage_of(size: tuple[int, int], pixels: Floats) -> NDArray[np.int64]:
    """Return the number of corners (N, 2) in each cell (4, 4) of a picture of a size (px)."""
    counts, _, _ = np.histogram2d(
        pixels[:, 1] / size[1], pixels[:, 0] / size[0], bins=4, range=[[0, 1], [0, 1]]
    )
    return counts.astype(int)


def said_missing(missing: Mapping[str, str]) -> str:
    """Return the names of pictures without a board, with the reason of each."""
    names = {why: [name for name in missing if missing[name] == why] for why in missing.values()}
    return "; ".join(f"{listed(those)}: {why}" for why, those in names.items())


def parts_without(coverage: NDArray[np.int64]) -> tuple[str, ...]:
    """Return the parts of a picture without corners; the middle part has four cells."""
    thirds = ([0], [1, 2], [3])
    return tuple(
        word
        for rows, words in zip(thirds, _WORDS, strict=True)
        for columns, word in zip(thirds, words, strict=True)
        if not coverage[np.ix_(rows, columns)].any()
    )


@dataclass(frozen=True)
class BoardPicture:
    """A picture with a board.

    Attributes
    ----------
    name : str
        Its name.
    corners : int
        Number of corners found.
    rms, worst : float
        Root mean square and largest distance of the corners from their expected positions (px).
    tilt : float
        Angle between the board and the picture (rad).
    is_used : bool
        False: the picture does not fit the others, and was left out.

    Examples
    --------
    >>> squares = np.pad(np.indices((7, 10)).sum(axis=0) % 2, 3, constant_values=1)
    >>> picture = np.dstack(3 * [np.kron(squares, np.full((30, 30), 255)).astype(np.uint8)])
    >>> pictures = [np.roll(picture, shift, axis=(0, 1)) for shift in (-40, 0, 40, 80)]
    >>> found = robsim.lab.calibrate_lens(pictures, robsim.lab.Chessboard())
    >>> [(one.name, one.corners, f"{np.degrees(one.tilt):.0f}") for one in found.pictures[:2]]
    [('1', 54, '0'), ('2', 54, '0')]
    """

    name: str
    corners: int
    rms: float
    worst: float
    tilt: float
    is_used: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class LensCalibration(Report):
    """The result of `calibrate_lens`.

    Attributes
    ----------
    calibration : Calibration
        The lens, as a value, without a floor.
    pictures : tuple of BoardPicture
        The pictures with a board.
    missing : mapping of str to str
        Reasons for pictures without a board: a few words, by name of the picture.
    deviations : array (9,)
        Standard deviations of fx, fy, cx, cy (px), k1, k2, p1, p2, k3; 0 = not fitted.
    has_k3 : bool
        Whether the pictures determine a third radial coefficient.
    coverage : array (4, 4) of int
        Corners in each cell of the picture, row by row from the top left.

    Examples
    --------
    >>> squares = np.pad(np.indices((7, 10)).sum(axis=0) % 2, 3, constant_values=1)
    >>> picture = np.dstack(3 * [np.kron(squares, np.full((30, 30), 255)).astype(np.uint8)])
    >>> pictures = [np.roll(picture, shift, axis=(0, 1)) for shift in (-40, 0, 40, 80)]
    >>> found = robsim.lab.calibrate_lens(pictures, robsim.lab.Chessboard())
    >>> [problem.kind for problem in found.problems]
    ['pictures', 'coverage', 'tilt']
    """

    calibration: Calibration
    pictures: tuple[BoardPicture, ...]
    missing: Mapping[str, str] = field(default_factory=dict)
    deviations: Floats = field(repr=False)
    has_k3: bool = False
    coverage: NDArray[np.int64] = field(repr=False)

    @property
    def title(self) -> str:
        """Name of the calibrated object."""
        return "Calibration of the lens"

    @property
    def rms(self) -> float:
        """Root mean square distance of the corners from their expected positions (px)."""
        residuals = self.calibration.lens_residuals
        assert residuals is not None  # of `calibrate_lens`
        return residuals.rms

    @property
    def empty_parts(self) -> tuple[str, ...]:
        """Parts of the picture without corners: ``"top left"`` and so on to ``"bottom right"``."""
        return parts_without(self.coverage)

    @property
    def verdict(self) -> str:
        """``"good"``, ``"poor"`` (more pictures are required) or ``"bad"``."""
        if self.rms > _RMS[1] or self._focal_deviation > _FOCAL[1]:
            return "bad"
        return "poor" if self.problems else "good"

    @property
    def _focal_deviation(self) -> float:
        """Relative standard deviation of the focal length."""
        assert self.calibration.intrinsics is not None
        focal = np.diag(self.calibration.intrinsics.matrix)[:2]
        return float((self.deviations[:2] / focal).max())

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Residuals and parameters."""
        intrinsics = self.calibration.intrinsics
        assert intrinsics is not None
        matrix, lens = intrinsics.matrix, intrinsics.distortion
        names = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
        values = (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *lens)
        units = ("px",) * 4 + ("",) * 5
        shown = [
            Quantity(name, f"{name} (+- {deviation:.2g})", float(value), unit)
            for name, value, unit, deviation in zip(
                names, values, units, self.deviations, strict=True
            )
        ]
        residuals = self.calibration.lens_residuals
        assert residuals is not None
        return (
            Quantity("rms", "rms", residuals.rms, "px", ".2f"),
            Quantity("worst", "worst corner", residuals.worst, "px", ".2f"),
            Quantity("n_pictures", "pictures used", residuals.pictures),
            *shown[: 9 if self.has_k3 else 8],
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """The pictures."""
        columns = (
            Column("corners", "corners", unit=""),
            Column("rms", "rms", unit="px", format=".2f"),
            Column("tilt", "tilt", unit="rad", format=".0f"),
            Column("used", "used", unit=""),
        )
        rows = [
            Row(one.name, (one.corners, one.rms, one.tilt, "yes" if one.is_used else "no"))
            for one in self.pictures
        ]
        return (Table(key="pictures", columns=columns, rows=rows, row_title="picture"),)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Missing coverage and other problems, with remedies."""
        return tuple(Problem(kind=kind, sentence=text) for kind, text in self._problems())

    def _problems(self) -> Iterator[tuple[str, str]]:
        used = [one for one in self.pictures if one.is_used]
        if self.rms > _RMS[0]:
            yield (
                "rms",
                f"rms {self.rms:.2f} px, expected is below {_RMS[0]:g}: is the board flat, its "
                "--square measured, the picture sharp, and the zoom locked?",
            )
        if len(used) < _PICTURES:
            yield "pictures", f"{len(used)} pictures are not enough: take {_PICTURES} to 20"
        if parts := listed(self.empty_parts):
            yield "coverage", f"no corners at the {parts} of the picture: move the board there"
        if sum(one.tilt > _TILT for one in used) < _TILTED:
            yield (
                "tilt",
                "the board is nearly parallel to the picture in most of them: tilt it by 20 to 45 "
                "degrees, in different directions, or the focal length is not determined",
            )
        elif self._focal_deviation > _FOCAL[0]:
            yield (
                "focal length",
                f"the focal length is only known to {100 * self._focal_deviation:.1f} %: take more "
                "pictures, closer and at larger tilts",
            )
        if outliers := [one.name for one in self.pictures if not one.is_used]:
            yield (
                "outlier",
                f"{listed(outliers)} does not fit the others and was left out: was it blurred by "
                "motion, or was the zoom changed?",
            )

    @property
    def remarks(self) -> tuple[str, ...]:
        """Pictures without a board."""
        return (f"no board was found in {said_missing(self.missing)}",) if self.missing else ()
