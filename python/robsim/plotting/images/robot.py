"""`plot_robot`: a robot definition with its outline, markers, centre and heading."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from robsim.base.checks import Floats
from robsim.base.text import no_formula
from robsim.plotting import style as style
from robsim.plotting.style import check_source
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.polygons import area_and_centroid

_FLOOR = (0.86, 0.86, 0.86)  # behind the transparent parts
_OUTLINE = "#ffd400"
_DARK = "#202020"


@style.applied
def plot_robot(robot: RobotDefinition, *, ax: Axes | None = None) -> Axes:
    """Draw the image of a robot with the geometry of its definition.

    The geometry is the outline, both marker polygons with the distance of their centroids, the
    centre, and an arrow. The arrow is the driving direction at equal wheel speeds. The axes are in
    pixels of the image; the displayed lengths are in work-area px.

    Parameters
    ----------
    robot : RobotDefinition
        The robot.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in. Default: a new figure, 7 inches wide.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    TypeError
        If `robot` is not a RobotDefinition.

    Examples
    --------
    >>> axes = robsim.plotting.plot_robot(robsim.load_robot("lab"))
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('right (px of the image)', 'down (px of the image)')
    """
    check_source("robot", robot, RobotDefinition)
    is_new = ax is None
    ax = style.panel(ax, (7, 7))
    _show_image(ax, robot)
    if is_new:
        style.fit_figure(ax)
    _draw_polygon(ax, robot.outline, _OUTLINE, "outline")
    for role, marker in robot.markers.items():
        label = no_formula(f"{role} marker ({marker.color})")
        _draw_polygon(ax, marker.polygon, style.drawn_color(marker.color), label)
    _draw_distance(ax, robot)
    _draw_heading(ax, robot)
    _draw_scale(ax, robot)
    ax.set_title(
        f"{robot.name}: {robot.size:g} px wide on the work area, alignment {robot.alignment:g}°",
        loc="left",
        parse_math=False,
        wrap=True,
    )
    style.legend_below(ax, ncols=3, columnspacing=1.2, handlelength=1.5)
    return ax


def _show_image(axes: Axes, robot: RobotDefinition) -> None:
    height, width = robot.image.shape[:2]
    axes.set_facecolor(_FLOOR)
    axes.imshow(robot.image)
    # The outline may extend a little beyond the image.
    axes.set(xlim=(-0.02 * width - 0.5, 1.02 * width - 0.5))
    axes.set(ylim=(1.02 * height - 0.5, -0.02 * height - 0.5))
    axes.set(xlabel="right (px of the image)", ylabel="down (px of the image)")
    axes.set_autoscale_on(False)
    axes.grid(False)


def _draw_polygon(axes: Axes, corners: Floats, color: str, label: str) -> None:
    halo = style.haloed(1.6)
    axes.add_patch(
        Polygon(corners, fill=False, edgecolor=color, linewidth=1.6, path_effects=halo, label=label)
    )
    axes.plot(
        *corners.T, "o", color=color, markersize=2.5, markeredgecolor="white", markeredgewidth=0.4
    )


def _draw_distance(axes: Axes, robot: RobotDefinition) -> None:
    """Draw the line between the markers' centroids, with its length."""
    centroids = np.array([area_and_centroid(m.polygon)[1] for m in robot.markers.values()])
    axes.plot(
        *centroids.T,
        color=_DARK,
        linewidth=1.2,
        marker="+",
        markersize=11,
        markeredgewidth=1.6,
        path_effects=style.haloed(1.4),
        label="marker centroids",
    )
    first, last = centroids
    (along_x, along_y), forward = (last - first) / np.linalg.norm(last - first), _forward(robot)
    beside = np.array((along_y, -along_x))
    beside *= -1 if beside @ forward > 0 else 1  # where the arrow is not
    away = 5 + np.abs(beside) @ (20, 6)  # points: half the text's width and height, and a gap
    axes.annotate(
        f"{robot.marker_layout().distance:.1f} px",
        centroids.mean(axis=0),
        away * beside * (1, -1),
        textcoords="offset points",
        ha="center",
        va="center",
        bbox=style.BOX,
    )


def _draw_heading(axes: Axes, robot: RobotDefinition) -> None:
    """Draw the centre, and the arrow to the side that faces right after the alignment."""
    assert robot.centre is not None
    forward = _forward(robot)
    outline = robot.radius / robot.size * robot.image.shape[1]  # its reach (image px)
    length = min(0.8 * outline, 0.95 * _reach(axes, robot.centre, forward))
    tip = robot.centre + length * forward
    axes.annotate(
        "",
        tuple(tip),
        tuple(robot.centre),
        arrowprops={
            "arrowstyle": "-|>,head_length=0.8,head_width=0.4",
            "color": style.MEASURED,
            "linewidth": 2.6,
            "shrinkA": 0,
            "shrinkB": 0,
            "path_effects": style.haloed(2.6),
        },
    )
    axes.plot(
        *robot.centre,
        "o",
        color=style.MEASURED,
        markersize=7,
        path_effects=style.haloed(0.5),
        label="centre, heading",
    )


def _forward(robot: RobotDefinition) -> Floats:
    """Return the direction in the image that the robot faces, (right, down)."""
    # The alignment rotates the image clockwise, so its front lies anticlockwise by that angle.
    angle = -np.deg2rad(robot.alignment)
    return np.array((np.cos(angle), np.sin(angle)))


def _reach(axes: Axes, start: Floats, direction: Floats) -> float:
    """Return the distance from a point in a direction to the edge of the axes."""
    limits = np.sort((axes.get_xlim(), axes.get_ylim()), axis=1)
    edges = np.where(direction > 0, limits[:, 1], limits[:, 0])
    moves = np.abs(direction) > 1e-9
    return float(np.min((edges - start)[moves] / direction[moves]))


def _draw_scale(axes: Axes, robot: RobotDefinition) -> None:
    """Draw a bar of a round number of work-area px, about a sixth of the image."""
    height = robot.image.shape[0]
    step = 10.0 ** np.floor(np.log10(robot.size / 6))
    length = step * max(n for n in (1, 2, 5) if n * step <= robot.size / 6)
    left, down = 0.03 * robot.image.shape[1], 0.965 * height
    right = left + length / robot.size * robot.image.shape[1]
    halo = style.haloed(2.5)
    axes.plot([left, right], [down, down], color=_DARK, linewidth=2.5, path_effects=halo)
    axes.annotate(
        f"{length:g} px",
        ((left + right) / 2, down),
        (0, 5),
        textcoords="offset points",
        ha="center",
        path_effects=halo,
    )
