"""`calibrate_lens`: focal length, centre and distortion from pictures of a board."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim._core import Frame, Intrinsics
from robsim.base.checks import Floats, check_text
from robsim.base.text import quoted
from robsim.lab.calibration.lens_report import (
    BoardPicture,
    LensCalibration,
    coverage_of,
    said_missing,
)
from robsim.lab.calibration.patterns.boards import Charuco, Chessboard
from robsim.lab.calibration.patterns.pattern import Corners
from robsim.lab.calibration.patterns.unseen import why_unseen
from robsim.vision.imaging.calibration import Calibration, Residuals
from robsim.vision.imaging.images import Pixels, frame_pixels, frame_size
from robsim.vision.imaging.video import load_opencv


def images_of(pictures: Any, names: Sequence[str] | None = None) -> Iterator[Pixels]:
    """Yield the pixels of at least one picture, all of one size; raise TypeError or ValueError."""
    is_single = isinstance(pictures, (Frame, str, bytes, dict)) or (
        isinstance(pictures, np.ndarray) and pictures.ndim < 4
    )
    if is_single or not isinstance(pictures, Iterable):
        raise TypeError(f"pictures must be a list or an iterable, got {quoted(pictures)}")
    size = None
    for number, picture in enumerate(pictures):
        image = frame_pixels("pictures", picture)
        found = frame_size(image)
        if size is not None and found != size:
            named = names is not None and number < len(names)
            which = names[number] if names and named else f"the one with number {number + 1}"
            raise ValueError(
                f"pictures must have one size, got {size[0]} x {size[1]} px and {found[0]} x "
                f"{found[1]} px ({which})"
            )
        size = found
        yield image
    if size is None:
        raise ValueError("pictures must not be empty")


def checked_names(names: Any) -> Sequence[str] | None:
    """Return names, a sequence of texts, or None."""
    if names is None:
        return None
    if isinstance(names, (str, bytes)) or not isinstance(names, (Sequence, np.ndarray)):
        raise TypeError(f"names must be a sequence of texts, got {quoted(names)}")
    return [check_text("names", name) for name in names]


FEWEST = 4  # pictures with a board
_FAR = 6.0  # of a robust standard deviation: a corner that was found in a wrong place
_LEAST_FAR = 0.5  # px
_OUTLIER = 3.0  # of the median rms: a picture that does not fit the others
_LEAST_OUTLIER = 0.4  # px
_BENT = 0.4  # of the variance that remains after removing a picture that distorts the fit.
_LEAST_BENT = 0.1  # px
_SUSPECTS = 3  # pictures that fit worst
_LEVEL = 1e-3  # for adding a third coefficient
_REACH = 0.75  # of the half diagonal, required radius of corners for this


def calibrate_lens(
    pictures: Iterable[Pixels | Frame],
    board: Chessboard | Charuco,
    *,
    names: Sequence[str] | None = None,
) -> LensCalibration:
    """Calibrate a lens by pictures of a board at different positions and tilts.

    Parameters
    ----------
    pictures : iterable of Frame or array (H, W, 3) of uint8
        RGB pictures of one size: ten or more, with the board tilted by 20 to 45 degrees, and
        reaching all corners of the picture.
    board : Chessboard or Charuco
        The board in the pictures.
    names : sequence of str, optional
        Names of the pictures. Default: their numbers, from 1.

    Returns
    -------
    LensCalibration
        The lens, the fit of each picture, and missing coverage.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    TypeError, ValueError
        If an argument has the wrong type, the pictures have different sizes, or fewer than four
        show the board.

    Notes
    -----
    Source: Z. Zhang, A flexible new technique for camera calibration, IEEE Transactions on Pattern
    Analysis and Machine Intelligence 22(11), 2000. OpenCV computes two radial and two tangential
    coefficients, and a third radial coefficient if the pictures determine it.

    Examples
    --------
    >>> import cv2
    >>> squares = np.dstack(3 * [255 * np.uint8(np.indices((7, 10)).sum(axis=0) % 2)])
    >>> camera = np.array([(500, 0, 320), (0, 500, 240), (0, 0, 1)])  # its focal length: 500 px
    >>> def picture(*tilt):  # of squares of 20 mm, at a distance of 300 mm
    ...     turn, _ = cv2.Rodrigues(np.array(tilt))
    ...     view = camera @ np.column_stack([20 * turn[:, :2], (-90, -60, 300)])
    ...     return cv2.warpPerspective(squares, view, (640, 480), flags=0, borderValue=3 * [255])
    >>> tilts = [(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, -0.5, 0.0), (0.0, 0.5, 0.0)]
    >>> pictures = [picture(*tilt) for tilt in tilts]
    >>> found = robsim.lab.calibrate_lens(pictures, robsim.lab.Chessboard(square=20))
    >>> int(found.calibration.intrinsics.matrix[0, 0].round(-1))
    500
    """
    cv2 = load_opencv("calibrating a lens")
    if not isinstance(board, (Chessboard, Charuco)):
        raise TypeError(f"board must be a Chessboard or a Charuco, got {quoted(board)}")
    size, views, missing = _views(pictures, board, checked_names(names))
    if len(views) < FEWEST:
        raise ValueError(
            f"at least {FEWEST} pictures must show the whole board, got {len(views)} of "
            f"{len(views) + len(missing)}: "
            + (f"{said_missing(missing)}; {why_missing(board)}" if missing else "take 10 to 20")
        )
    return lens_of_views(cv2, size, views, missing)


def why_missing(board: Chessboard | Charuco) -> str:
    """Return hints for pictures without a board."""
    unit = "squares" if isinstance(board, Charuco) else "inner corners"
    return (
        f"is it a board of {board.columns} x {board.rows} {unit}, sharp, evenly lit, with white "
        "all around it?"
    )


@dataclass
class View:
    """A picture with a board."""

    name: str
    corners: Corners
    is_used: bool = True


@dataclass(frozen=True)
class Fit:
    """OpenCV's calibration from the used views."""

    matrix: Floats
    distortion: Floats
    tilts: list[Floats]  # rotation vectors
    deviations: Floats  # of fx, fy, cx, cy, k1, k2, p1, p2, k3
    errors: list[Floats]  # (N, 2) of each view (px)

    @property
    def squares(self) -> float:
        return float(sum((one**2).sum() for one in self.errors))

    @property
    def variance(self) -> float:
        """Mean of the squared errors (px^2)."""
        return self.squares / sum(map(len, self.errors))


def _views(
    pictures: Iterable[Any], board: Chessboard | Charuco, names: Sequence[str] | None
) -> tuple[tuple[int, int], list[View], dict[str, str]]:
    """Return the size of the pictures, the views with a board, and reasons for the others."""
    size = (0, 0)
    views, missing = [], {}
    for number, image in enumerate(images_of(pictures, names)):
        if names is not None and number >= len(names):
            raise ValueError(f"names must have one name per picture, got {len(names)}")
        name = str(number + 1) if names is None else names[number]
        size = frame_size(image)
        corners = board.find(image)
        if corners is None:
            missing[name] = why_unseen(board, image)
        else:
            views.append(View(name, corners))
    return size, views, missing


def lens_of_views(
    cv2: Any, size: tuple[int, int], views: list[View], missing: Mapping[str, str]
) -> LensCalibration:
    """Calibrate a lens by at least `FEWEST` views; this changes the views."""
    fit = _fit(cv2, size, views)
    if _drop_far_corners(views, fit):
        fit = _fit(cv2, size, views)
    used, fit = _without_outliers(cv2, size, views, fit)
    fit, has_k3 = _with_k3(cv2, size, used, fit)
    distances = [np.linalg.norm(errors, axis=1) for errors in fit.errors]
    all_distances = np.concatenate(distances)
    residuals = Residuals(
        rms=float(np.sqrt((all_distances**2).mean())),
        worst=float(all_distances.max()),
        points=len(all_distances),
        pictures=len(used),
    )
    calibration = Calibration(
        size=size,
        intrinsics=Intrinsics(fit.matrix, distortion=fit.distortion.tolist()),
        lens_residuals=residuals,
        date=datetime.datetime.now(datetime.UTC).replace(microsecond=0),
    )
    fitted = iter(zip(distances, fit.tilts, strict=True))
    return LensCalibration(
        calibration=calibration,
        pictures=tuple(_picture(cv2, view, fit, fitted) for view in views),
        missing=missing,
        deviations=fit.deviations,
        has_k3=has_k3,
        coverage=coverage_of(size, np.concatenate([view.corners.pixels for view in used])),
    )


def _picture(cv2: Any, view: View, fit: Fit, fitted: Any) -> BoardPicture:
    if view.is_used:
        distances, tilt = next(fitted)
    else:
        distances, tilt = _seen_alone(cv2, view, fit)
    normal = cv2.Rodrigues(tilt)[0][:, 2]
    return BoardPicture(
        name=view.name,
        corners=len(view.corners.pixels),
        rms=float(np.sqrt((distances**2).mean())),
        worst=float(distances.max()),
        tilt=math.acos(min(1.0, abs(float(normal[2])))),
        is_used=view.is_used,
    )


def _seen_alone(cv2: Any, view: View, fit: Fit) -> tuple[Floats, Floats]:
    """Return the deviation (px) of an unused picture, and the rotation of its board."""
    points = _in_space(view.corners)
    _, rotation, place = cv2.solvePnP(points, view.corners.pixels, fit.matrix, fit.distortion)
    seen, _ = cv2.projectPoints(points, rotation, place, fit.matrix, fit.distortion)
    return np.linalg.norm(seen.reshape(-1, 2) - view.corners.pixels, axis=1), rotation


def _in_space(corners: Corners) -> Any:
    return np.column_stack([corners.positions, np.zeros(len(corners.positions))])


def _fit(cv2: Any, size: tuple[int, int], views: list[View], *, with_k3: bool = False) -> Fit:
    points = [_in_space(view.corners).astype(np.float32) for view in views]
    pixels = [view.corners.pixels.astype(np.float32) for view in views]
    flags = 0 if with_k3 else cv2.CALIB_FIX_K3
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 100, 1e-10)
    _, matrix, distortion, rotations, places, deviations, *_ = cv2.calibrateCameraExtended(
        points, pixels, size, None, None, flags=flags, criteria=criteria
    )
    distortion = np.asarray(distortion, float).ravel()[:5]
    errors = []
    for view, rotation, place in zip(views, rotations, places, strict=True):
        seen, _ = cv2.projectPoints(_in_space(view.corners), rotation, place, matrix, distortion)
        errors.append(seen.reshape(-1, 2) - view.corners.pixels)
    return Fit(
        np.asarray(matrix, float),
        distortion,
        [np.asarray(rotation, float) for rotation in rotations],
        np.asarray(deviations, float).ravel()[:9],
        errors,
    )


def _drop_far_corners(views: list[View], fit: Fit) -> bool:
    """Leave out corners found in wrong positions; return whether there were any."""
    dropped = False
    for view, errors in zip(views, fit.errors, strict=True):
        distances = np.linalg.norm(errors, axis=1)
        limit = max(_FAR * 1.2 * float(np.median(distances)), _LEAST_FAR)
        is_near = distances <= limit
        if not is_near.all() and is_near.sum() >= 6:
            kept = view.corners
            view.corners = Corners(kept.positions[is_near], kept.pixels[is_near])
            dropped = True
    return dropped


def _without_outliers(
    cv2: Any, size: tuple[int, int], views: list[View], fit: Fit
) -> tuple[list[View], Fit]:
    """Leave out pictures that do not fit the others, while enough pictures remain."""
    used = views
    while len(used) > FEWEST:
        rms = np.array([np.sqrt((errors**2).sum(axis=1).mean()) for errors in fit.errors])
        limit = max(_OUTLIER * float(np.median(rms)), _LEAST_OUTLIER)
        suspects = np.argsort(rms)[::-1][:_SUSPECTS].tolist()
        # A picture that distorts the whole fit need not have the largest rms.
        fits = [_fit(cv2, size, [*used[:one], *used[one + 1 :]]) for one in suspects]
        best = min(range(len(fits)), key=lambda one: fits[one].variance)
        bends = fit.variance > _LEAST_BENT**2 and fits[best].variance < _BENT * fit.variance
        if not bends:
            best = 0
        if not (bends or rms[suspects[0]] > limit):
            break
        used[suspects[best]].is_used = False
        used, fit = [view for view in used if view.is_used], fits[best]
    return used, fit


def _with_k3(cv2: Any, size: tuple[int, int], views: list[View], fit: Fit) -> tuple[Fit, bool]:
    """Return the fit with a third radial coefficient if the pictures determine it."""
    middle = (np.array(size) - 1) / 2
    pixels = np.concatenate([view.corners.pixels for view in views])
    reach = np.linalg.norm(pixels - middle, axis=1).max() / np.linalg.norm(middle)
    if reach < _REACH:
        return fit, False
    more = _fit(cv2, size, views, with_k3=True)
    free = 2 * len(pixels) - 9 - 6 * len(views)
    if free < 1 or more.squares >= fit.squares:
        return fit, False
    from scipy.special import fdtri  # loading takes 0.1 s

    # F = (SSE - SSE3) / (SSE3 / (n - p)): for a coefficient of zero, F(1, n - p)
    gain = (fit.squares - more.squares) / (more.squares / free)
    is_worth_it = gain > fdtri(1, free, 1 - _LEVEL) and _is_monotonic(more, size)
    return (more, True) if is_worth_it else (fit, False)


def _is_monotonic(fit: Fit, size: tuple[int, int]) -> bool:
    """Return whether the lens is invertible up to the corners of the picture."""
    corner = np.maximum(fit.matrix[:2, 2], np.array(size) - fit.matrix[:2, 2])
    r = np.linspace(0, 1.2 * np.linalg.norm(corner / fit.matrix.diagonal()[:2]), 200)
    k1, k2, _, _, k3 = fit.distortion
    # d/dr of r (1 + k1 r^2 + k2 r^4 + k3 r^6)
    return bool((1 + 3 * k1 * r**2 + 5 * k2 * r**4 + 7 * k3 * r**6 > 0.1).all())
