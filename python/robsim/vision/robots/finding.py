"""A robot definition from a plain image: outline by opacity, markers by colour."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._core import Blob, ColorClass, find_blobs, rgb_to_yuv
from robsim.base.checks import Floats
from robsim.base.text import quoted
from robsim.base.warn import warn_user
from robsim.vision.imaging.images import Pixels, check_pixels, resized
from robsim.vision.markers.color_files import as_colors
from robsim.vision.robots.definition import (
    DEFAULT_COLORS,
    RobotDefinition,
    check_color_names,
    from_colors,
)
from robsim.vision.robots.marker_check import MINIMUM_AREA, over_grey, ranges
from robsim.vision.robots.polygon_checks import finite_array
from robsim.vision.robots.polygons import area_and_centroid, fitted

MAXIMUM_SIDE = 1000  # px, larger images are scaled down
_SIZE = 120.0  # work-area px
OPAQUE = 127  # alpha above it is opaque
_CORNERS = 36  # of a polygon
_POINTS = 200_000  # approximate number of sample points in a blob.


def robot_from_image(
    name: str,
    image: Pixels,
    *,
    size: float | None = None,
    alignment: float | None = None,
    centre: ArrayLike | None = None,
    outline: ArrayLike | None = None,
    markers: Mapping[str, ArrayLike] | None = None,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    marker_colors: Sequence[str] | None = None,
) -> RobotDefinition:
    """Make a robot definition from an image; missing arguments are derived from the image.

    Parameters
    ----------
    name : str
        Name of the robot.
    image : array (h, w, 4) of uint8
        RGBA. If its longer side exceeds 1000 px, the image and the points are scaled down.
    size : float, optional
        Width of the image on the work area (px). Default: 120.
    alignment : float, optional
        Clockwise rotation of the image (degrees) that makes the robot face right. Default: 0.
    centre : array (2,), optional
        The robot's centre (image px). Default: the centroid of the outline.
    outline : array (N, 2), optional
        Polygon around the robot (image px). Default: the outline of the opaque pixels, which is the
        border of an image without transparency.
    markers : dict of str to array (N, 2), optional
        Polygons around the markers (image px) by their colours: ``{"red": polygon}``. Default for
        each marker: a polygon around the largest blob of the colour, with the area and the centroid
        of the blob. The roles of the markers follow from their positions on a robot that faces
        right.
    colors : path or iterable of ColorClass, optional
        Colour file, or classes, to find the markers. Default: the colours shipped with robsim.
    marker_colors : sequence of 2 str, optional
        The colours of the markers, in any order. Default: red and blue.

    Returns
    -------
    RobotDefinition
        The robot.

    Raises
    ------
    TypeError, ValueError
        If `image` has the wrong type or shape, a marker is not found, or the resulting robot is
        invalid.

    Warns
    -----
    UserWarning
        If the image has no transparency and no `outline` is given.

    Examples
    --------
    >>> robot = robsim.vision.robot_from_image("mine", robsim.load_robot("lab").image)
    >>> {role: marker.color for role, marker in robot.markers.items()}
    {'front': 'red', 'back': 'blue'}
    """
    small, scale = _reduced(check_pixels("image", image, 4))
    around = opaque_outline(small) if outline is None else _scaled("outline", outline, scale)
    names = DEFAULT_COLORS if marker_colors is None else marker_colors
    names = check_color_names("marker_colors", names)
    drawn = check_markers_by_color(markers, names)
    polygons = {
        color: _scaled(f"markers[{color!r}]", drawn[color], scale)
        if color in drawn
        else marker_in(small, color, as_colors(colors))
        for color in names
    }
    if centre is None:
        scaled_centre = area_and_centroid(around)[1]
    else:
        scaled_centre = _in_scale(finite_array("centre", centre, (2,)), scale)
    robot = from_colors(
        polygons,
        0.0 if alignment is None else alignment,
        name=name,
        image=small,
        size=_SIZE if size is None else size,
        centre=scaled_centre,
        outline=around,
    )
    if outline is None and (small[..., 3] > OPAQUE).all():
        warn_user(
            "the image has no transparency, so its border is the outline, with the surroundings "
            "of the robot: make the surroundings transparent, or give an outline"
        )
    return robot


def _reduced(image: Pixels) -> tuple[Pixels, Floats]:
    """Return the image, scaled down to the maximum side, and the scale factors (2,)."""
    height, width = image.shape[:2]
    factor = min(1.0, MAXIMUM_SIDE / max(height, width))
    small = resized(image, max(1, round(factor * width)), max(1, round(factor * height)))
    return small, np.array((small.shape[1] / width, small.shape[0] / height))


def _scaled(name: str, points: ArrayLike, scale: Floats) -> Floats:
    return _in_scale(finite_array(name, points, (-1, 2)), scale)


def _in_scale(points: Floats, scale: Floats) -> Floats:
    return (points + 0.5) * scale - 0.5


def check_markers_by_color(
    markers: Mapping[str, ArrayLike] | None, colors: Sequence[str]
) -> Mapping[str, ArrayLike]:
    """Return polygons of markers by their colours, if they match the robot's colours."""
    if markers is None:
        return {}
    expected = f"markers must be polygons by the colours {' and '.join(colors)}"
    if not isinstance(markers, Mapping):
        raise TypeError(f"{expected}, got {quoted(markers)}")
    if not set(markers) <= set(colors):
        raise ValueError(f"{expected}, got {quoted(list(markers))}")
    return markers


def reduced(robot: RobotDefinition) -> RobotDefinition:
    """Return the robot with its image and points scaled down to at most 1000 px a side."""
    small, scale = _reduced(robot.image)
    if small is robot.image:
        return robot
    assert robot.centre is not None
    return replace(
        robot,
        image=small,
        centre=_in_scale(robot.centre, scale),
        outline=_in_scale(robot.outline, scale),
        markers={
            role: replace(marker, polygon=_in_scale(marker.polygon, scale))
            for role, marker in robot.markers.items()
        },
    )


def opaque_outline(image: Pixels) -> Floats:
    """Return the convex polygon around the opaque pixels whose sides have fixed directions."""
    down, right = np.nonzero(image[..., 3] > OPAQUE)
    if not len(right):
        raise ValueError("outline: the image is transparent everywhere")
    height, width = image.shape[:2]
    angle = 2 * np.pi * np.arange(_CORNERS) / _CORNERS
    cos, sin = np.cos(angle), np.sin(angle)
    # Support function: the maximum of cos x + sin y over the pixels and their corners.
    edge = np.unique(np.vstack((_ends(right, down), _ends(down, right)[:, ::-1])), axis=0)
    support = (edge @ np.vstack((cos, sin))).max(axis=0) + (abs(cos) + abs(sin)) / 2
    # A corner lies on two neighbouring sides: cos x + sin y = support, for both.
    sides = np.stack((np.column_stack((cos, sin)), np.roll(np.column_stack((cos, sin)), -1, 0)), 1)
    corners = np.linalg.solve(
        sides, np.column_stack((support, np.roll(support, -1)))[..., np.newaxis]
    )
    within = np.clip(corners[..., 0], -0.5, (width - 0.5, height - 0.5))
    return np.round(within, 2)


def _ends(positions: NDArray[np.intp], lines: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the first and the last position on each line, an array (N, 2): position, line."""
    order = np.lexsort((positions, lines))
    positions, lines = positions[order], lines[order]
    starts = np.flatnonzero(np.diff(lines, prepend=-1))
    ends = np.append(starts[1:], len(lines)) - 1
    found: NDArray[np.intp] = np.column_stack((positions, lines))[np.concatenate((starts, ends))]
    return found


def marker_in(image: Pixels, name: str, colors: tuple[ColorClass, ...]) -> Floats:
    """Return a polygon with the centroid, the area and about the shape of the largest blob."""
    found = [color for color in colors if color.name == name]
    if not found:
        known = ", ".join(color.name for color in colors)
        raise ValueError(
            f"{name} marker: colour {name} is unknown. Known colours are {known}. Give colours "
            f"that include {name}, other marker_colors, or the marker's polygon"
        )
    pixels = over_grey(image)
    blobs = find_blobs(pixels, found, minimum_area=MINIMUM_AREA, maximum_count=1)[name]
    if not blobs:
        raise ValueError(
            f"{name} marker: nothing in the image has the colour {name} ({ranges(found[0])}): "
            "give its polygon, colours of this light, or the names of other colours, by markers, "
            "colors or marker_colors (in the shell --marker, --colors or --marker-colors)"
        )
    return _polygon_around(pixels_of_blob(blobs[0], pixels, found[0]), blobs[0])


def pixels_of_blob(blob: Blob, pixels: Pixels, color: ColorClass) -> Floats:
    """Return the pixels (N, 2) of a blob: right, down."""
    left, top, right, bottom = blob.bounding_box
    yuv = rgb_to_yuv(np.ascontiguousarray(pixels[top : bottom + 1, left : right + 1]))
    lower, upper = np.array((color.y, color.u, color.v)).T
    is_colored = ((yuv >= lower) & (yuv <= upper)).all(axis=2)
    # A blob has a pixel in the top row of its box; another blob may have one there, too.
    starts = np.flatnonzero(is_colored[0] & ~np.append(False, is_colored[0, :-1]))
    parts = [_connected(is_colored, start) for start in starts.tolist()]
    down, across = np.nonzero(max(parts, key=np.count_nonzero))
    return np.column_stack((across + left, down + top)).astype(float)


def _connected(mask: NDArray[np.bool_], start: int) -> NDArray[np.bool_]:
    """Return the 8-connected component of a mask that contains a pixel of its top row."""
    part = np.zeros_like(mask)
    part[0, start] = True
    count = 0
    while (size := int(np.count_nonzero(part))) > count:
        count = size
        part = mask & _dilated(part)
        part = _along_rows(_along_rows(part, mask).T, mask.T).T
    return part


def _dilated(part: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask dilated by 3 x 3 pixels."""
    wide = part.copy()
    wide[:, 1:] |= part[:, :-1]
    wide[:, :-1] |= part[:, 1:]
    dilated = wide.copy()
    dilated[1:] |= wide[:-1]
    dilated[:-1] |= wide[1:]
    return dilated


def _along_rows(part: NDArray[np.bool_], mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return all horizontal runs of the mask that contain a pixel of the part."""
    before = np.zeros_like(mask)
    before[:, 1:] = mask[:, :-1]
    run = np.cumsum(mask & ~before).reshape(mask.shape)
    is_in_part = np.zeros(run.max() + 1, dtype=bool)
    is_in_part[run[part]] = True
    return mask & is_in_part[run]


def _polygon_around(pixels: Floats, blob: Blob) -> Floats:
    """Return a polygon of up to 36 corners with a blob's area and centroid.

    The blob, whitened by the Cholesky factor of its covariance, is cut into sectors around the
    centroid; each gets a corner with the area of its pixels. So it cannot intersect itself.
    """
    count = int(np.clip(len(pixels) // 12, 8, _CORNERS))
    points = _subdivided(pixels)
    offset = points - blob.centroid
    root = np.linalg.cholesky(offset.T @ offset / len(points))
    x, y = np.linalg.solve(root, offset.T)
    sector = np.floor(np.arctan2(y, x) / (2 * np.pi) * count).astype(int) % count
    # area of a sector of a circle = pi radius^2 / count
    area = np.bincount(sector, minlength=count) / len(points)
    radius = np.sqrt(area * count / np.pi)
    radius = np.maximum(radius, 0.1 * radius.mean())
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    corners = (root @ (radius * (np.cos(angle), np.sin(angle)))).T
    return fitted(corners, blob.area, blob.centroid)


def _subdivided(pixels: Floats) -> Floats:
    """Return sample points (M, 2) on a grid in each pixel, finer if there are fewer pixels."""
    side = int(np.clip(np.sqrt(_POINTS / len(pixels)), 2, 8))
    parts = (np.arange(side) + 0.5) / side - 0.5
    grid = np.stack(np.meshgrid(parts, parts), axis=-1).reshape(-1, 2)
    points: Floats = (pixels[:, np.newaxis] + grid).reshape(-1, 2)
    return points
