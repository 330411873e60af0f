"""The benchmark of the blob detection against OpenCV's functions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from robsim._core import Blob, ColorClass, Frame, find_blobs
from robsim.bench._cases import Call
from robsim.imaging._images import Pixels
from robsim.imaging._noise import GaussianNoise, UniformNoise
from robsim.simulation._simulation import Simulation

NOISE_PERCENT = 40.0
NOISES = {
    "none": None,
    "uniform": UniformNoise(NOISE_PERCENT),
    "gaussian": GaussianNoise(NOISE_PERCENT),
}
MINIMUM_AREA = 12  # px, of a blob
_MINIMUM_POINTS = 5  # of the outline of a blob of that area

# Per colour the blobs: area, u, v of the centroid (N, 3).
Found = dict[str, npt.NDArray[np.float64]]


@dataclass(frozen=True)
class Scene:
    """A frame with the robot in it, and the options of its marker detection.

    Attributes
    ----------
    frame : Frame
        The frame.
    colors : tuple of ColorClass
        The colour classes of the markers.
    minimum_area, smoothing : int
        The options of `find_blobs` for it (px).
    """

    frame: Frame
    colors: tuple[ColorClass, ...]
    minimum_area: int
    smoothing: int


def scene(kind: str, size: int, smoothing: int | None = None) -> Scene:
    """Return a clean or a noisy frame, with the detection options of the simulation."""
    simulation = Simulation(
        robot="lab",
        resolution=(size, size),
        headings=None,
        noise=NOISES[kind],
        start=(450, 700, 0.5),
        measure=True,
        smoothing=smoothing,
        seed=1,
    )
    simulation.step()
    frame = simulation.frame
    core = simulation._core
    return Scene(frame, simulation.colors, core.minimum_area, core.smoothing)


def detect_calls(cv2: Any, shown: Scene) -> dict[str, Call]:
    """Return the calls that find the blobs of a scene, after a check that all find the same.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    shown : Scene
        The scene. With smoothing OpenCV blurs the frame first.

    Returns
    -------
    dict of str to callable
        ``"ours"``; ``"opencv"``, by contours and their moments; ``"components"``, by
        ``connectedComponentsWithStats``.

    Raises
    ------
    RuntimeError
        If they find different blobs.
    """
    pixels = shown.frame.image.copy()
    limits = {color.name: opencv_limits(color) for color in shown.colors}

    def ours() -> dict[str, list[Blob]]:
        return find_blobs(
            pixels, shown.colors, minimum_area=shown.minimum_area, smoothing=shown.smoothing
        )

    calls: dict[str, Callable[[], Found]] = {
        name: opencv_finder(cv2, pixels, limits, shown.smoothing, parts)
        for name, parts in (("opencv", contours), ("components", components))
    }
    ours_found = as_found(ours())
    for name, call in calls.items():
        check_same(ours_found, call(), name, 5 * shown.minimum_area)
    return {"ours": ours, **calls}


def opencv_limits(color: ColorClass) -> tuple[Pixels, Pixels]:
    """Return the limits in OpenCV's order: Y, Cr, Cb."""
    lower, upper = zip(color.y, color.v, color.u, strict=True)
    return np.array(lower, np.uint8), np.array(upper, np.uint8)


def opencv_finder(
    cv2: Any,
    pixels: Pixels,
    limits: dict[str, tuple[Pixels, Pixels]],
    window: int,
    parts: Callable[[Any, Any], npt.NDArray[np.float64]],
) -> Callable[[], Found]:
    """Return a function that finds the blobs of an image with OpenCV."""

    def find() -> Found:
        smooth = pixels if window == 1 else cv2.blur(pixels, (window, window))
        converted = cv2.cvtColor(smooth, cv2.COLOR_RGB2YCrCb)
        return {name: parts(cv2, cv2.inRange(converted, *limits[name])) for name in limits}

    return find


def contours(cv2: Any, mask: Any) -> npt.NDArray[np.float64]:
    """Return area and centroid of the blobs of a mask, from their outlines."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    moments = [cv2.moments(outline) for outline in outlines if len(outline) >= _MINIMUM_POINTS]
    rows = [
        (m["m00"], m["m10"] / m["m00"], m["m01"] / m["m00"])
        for m in moments
        if m["m00"] >= MINIMUM_AREA
    ]
    return np.array(rows).reshape(-1, 3)


def components(cv2: Any, mask: Any) -> npt.NDArray[np.float64]:
    """Return area and centroid of the blobs of a mask, from their labels."""
    _, _, stats, centroids = cv2.connectedComponentsWithStats(mask, connectivity=8)
    area = stats[1:, cv2.CC_STAT_AREA]
    is_kept = area >= MINIMUM_AREA
    return np.column_stack((area[is_kept], centroids[1:][is_kept]))


def as_found(blobs: dict[str, list[Blob]]) -> Found:
    """Return blobs of ours in the form of the others'."""
    return {
        name: np.array([(blob.area, *blob.centroid) for blob in several]).reshape(-1, 3)
        for name, several in blobs.items()
    }


def check_same(ours: Found, theirs: Found, name: str, minimum_area: float) -> None:
    """Raise RuntimeError unless each finds the large blobs of the other."""
    for color in ours:
        for mine, others in ((ours[color], theirs[color]), (theirs[color], ours[color])):
            for area, *position in mine:
                distances = np.hypot(*(others[:, 1:] - position).T)
                if area >= minimum_area and distances.min(initial=np.inf) > 2:
                    raise RuntimeError(
                        f"robsim and OpenCV ({name}) must find the same {color} blobs: only one "
                        f"finds that of {area:.0f} px at ({position[0]:.1f}, {position[1]:.1f})"
                    )
