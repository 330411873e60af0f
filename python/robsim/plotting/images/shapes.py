"""The outline, heading line and bounding box that `plot_frame` and `draw_overlay` draw."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robsim._core import Blob
from robsim.base.checks import Floats
from robsim.plotting.arguments import check_positions

HEADING_LINE = 80.0  # length of a heading's line (work-area px)


def heading_line(pose: Floats) -> Floats:
    """Return both ends (2, 2) of the line from a pose's position along its heading."""
    return np.array((pose[:2], pose[:2] + HEADING_LINE * _forward(pose)))


def placed_outline(outline: ArrayLike, pose: Floats) -> Floats:
    """Return the corners (N, 2) of a robot's outline at a pose.

    Parameters
    ----------
    outline : array_like (N, 2)
        Outline in the robot's own axes, x forward and y to the right (work-area px).
    pose : array (3,)
        x, y (work-area px), heading (rad).

    Raises
    ------
    ValueError
        If `outline` is not of shape (N, 2).
    """
    points = check_positions("outline", outline)
    # y to the right of the robot: forward rotated by +90 degrees, clockwise in the image.
    forward = _forward(pose)
    right = np.array((-forward[1], forward[0]))
    placed: Floats = pose[:2] + points[:, :1] * forward + points[:, 1:] * right
    return placed


def box_corners(blob: Blob) -> Floats:
    """Return the corners (4, 2) of the box around a blob (pixels), at its pixels' outer edges."""
    left, top, right, bottom = np.add(blob.bounding_box, (-0.5, -0.5, 0.5, 0.5))
    return np.array([(left, top), (right, top), (right, bottom), (left, bottom)])


def _forward(pose: Floats) -> Floats:
    return np.array((np.cos(pose[2]), np.sin(pose[2])), dtype=np.float64)
