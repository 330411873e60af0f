"""`plot_camera_check`: a camera's view of the robot, and the findings."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robsim.base.text import quoted
from robsim.plotting import style as style
from robsim.plotting.images.frame import plot_frame

if TYPE_CHECKING:
    from robsim.lab.rehearsal.camera_check import CameraCheck

_COLORS = {"good": style.MEASURED, "poor": style.GOAL, "bad": style.WRONG}
_NEAR = 0.75  # of the robot's size, around its centre


@style.applied
def plot_camera_check(check: CameraCheck) -> Figure:
    """Draw the frame of a camera check, a close-up of the robot, and the findings.

    Parameters
    ----------
    check : robsim.lab.CameraCheck
        The check, from `robsim.lab.check_camera`.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.

    Raises
    ------
    TypeError
        If `check` has another type.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     check = robsim.lab.check_camera(camera, robot="lab", seconds=0.5)
    >>> len(robsim.plotting.plot_camera_check(check).axes)
    3
    """
    if not hasattr(check, "findings"):
        raise TypeError(
            "check must be a CameraCheck, the result of robsim.lab.check_camera(camera), got "
            f"{quoted(check)}"
        )
    figure = style.NotebookFigure(figsize=(11, 7))
    grid = figure.add_gridspec(2, 2, width_ratios=(1.6, 1), height_ratios=(1, 1.35))
    whole = figure.add_subplot(grid[:, 0])
    _draw(whole, check)
    whole.set_title(check.headline, loc="left", color=_COLORS[check.verdict], weight="bold")
    near = figure.add_subplot(grid[0, 1])
    if check.measurement is None:
        near.set_axis_off()
        near.text(0.5, 0.5, "the robot was not detected", ha="center", va="center")
    else:
        _draw(near, check)
        _zoom(near, check)
    _list_findings(figure.add_subplot(grid[1, 1]), check)
    return figure


def _draw(axes: Axes, check: CameraCheck) -> None:
    robot = check.robot
    plot_frame(
        check.frame,
        ax=axes,
        blobs=check.blobs,
        measurement=check.measurement,
        outline=robot.to_robot_frame(robot.outline),
    )


def _zoom(axes: Axes, check: CameraCheck) -> None:
    """Show only the robot; the axes are in work-area px, or in pixels of an oblique frame."""
    assert check.measurement is not None
    centre = check.measurement.pose[:2]
    corners = centre + _NEAR * check.robot.size * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    if axes.get_xlabel().startswith("u"):
        corners = check.frame.plane_map.to_pixel(corners)
    if np.isfinite(corners).all():  # the lens shows all of them
        left, top = corners.min(axis=0)
        right, bottom = corners.max(axis=0)
        axes.set(xlim=(left, right), ylim=(bottom, top))
    axes.set(xlabel="", ylabel="")
    axes.set_title("", loc="left")
    if legend := axes.get_legend():
        legend.remove()


def _list_findings(axes: Axes, check: CameraCheck) -> None:
    axes.set_axis_off()
    lines = len(check.findings)
    for row, finding in enumerate(check.findings):
        y = 1 - (row + 0.5) / lines
        color = _COLORS.get(finding.verdict, style.GUIDE)
        axes.plot(0.02, y, "o", color=color, markersize=5, clip_on=False)
        axes.text(0.07, y, finding.name, va="center", parse_math=False)
        axes.text(0.74, y, finding.amount, va="center", ha="right", parse_math=False)
        axes.text(1, y, finding.verdict, va="center", ha="right", color=color)
    axes.set(xlim=(0, 1), ylim=(0, 1))
