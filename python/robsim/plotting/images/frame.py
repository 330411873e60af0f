"""`plot_frame`: a camera frame with the detected blobs, the measured pose and the path."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import ArrayLike

from robsim._core import Blob, Frame, Measurement
from robsim.base.checks import Floats
from robsim.control.path_following import as_goals
from robsim.plotting import style as style
from robsim.plotting.images.overlay import box_corners, heading_line, placed_outline
from robsim.plotting.style import check_blobs, check_optional, check_positions, check_source
from robsim.trace import Trace
from robsim.vision.robots.lookup import load_robot

_Map = Callable[[ArrayLike], Floats]  # positions (N, 2) to positions (N, 2)


@style.applied
def plot_frame(
    frame: Frame,
    *,
    ax: Axes | None = None,
    blobs: Mapping[str, Sequence[Blob]] | None = None,
    measurement: Measurement | None = None,
    outline: ArrayLike | None = None,
    trace: Trace | None = None,
    k: int | None = None,
    goals: ArrayLike | None = None,
) -> Axes:
    """Draw a camera frame with the vision results on it.

    The axes are in work-area pixels. If the camera views the plane obliquely, the frame is not a
    rectangle on the plane, so the axes are in pixels of the frame.

    Parameters
    ----------
    frame : Frame
        The image with its plane map.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in. Default: a new figure, 7 inches wide.
    blobs : dict of str to sequence of Blob, optional
        The blobs of each colour, as from `robsim.find_blobs`: each gets its bounding box and a
        cross.
    measurement : Measurement, optional
        The measured pose: a line from the centre along the heading. With `blobs` and no
        measurement, the figure shows "not seen".
    outline : array_like (N, 2), optional
        Outline of the robot in its own axes, x forward and y to the right (work-area px). The
        outline is drawn at the measured pose, or otherwise at the end of the path. Default: the
        outline of the robot of `trace`, if given.
    trace : Trace, optional
        The run whose path is drawn, up to the robot with its heading at the end.
    k : int, optional
        The last step of `trace` to draw. Default: the whole path.
    goals : array_like (2,), (3,) or (N, 2), optional
        The position, the pose or the positions that the robot should reach (work-area px), drawn as
        rings; an arrow is the heading of a pose.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn in.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or shape, or `k` is not a step of `trace`.

    Examples
    --------
    >>> step = robsim.Simulation(seed=1, measure=True).step()
    >>> axes = robsim.plot_frame(step.frame, blobs=step.blobs, measurement=step.measurement)
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('x (px)', 'y (px)')
    """
    check_source("frame", frame, Frame)
    check_blobs(blobs)
    check_optional("measurement", measurement, Measurement)
    outline = None if outline is None else check_positions("outline", outline)
    shown = _part(trace, k)
    is_new = ax is None
    ax = style.panel(ax, (7, 7))
    from_pixel, from_world = _show_image(ax, frame)
    if is_new:
        style.fit_figure(ax)
    if shown is not None and len(shown):
        _draw_path(ax, shown, from_world)
        outline = _outline_of(shown) if outline is None else outline
    for color, found in (blobs or {}).items():
        for blob in found:
            _draw_blob(ax, blob, style.drawn_color(color), from_pixel)
    if measurement is not None:
        _draw_pose(ax, measurement.pose, outline, from_world, style.MEASURED)
    elif shown is not None and len(shown):
        _draw_end(ax, shown, outline, from_world)
    if goals is not None:
        draw_goals(ax, as_goals(goals), from_world)
    time = "" if frame.t is None else f", t = {frame.t:.2f} s"
    seen = ", not seen" if blobs is not None and measurement is None else ""
    ax.set_title(f"frame {frame.index}{time}{seen}", loc="left")
    style.legend_below(ax, ncols=3)
    return ax


def _show_image(axes: Axes, frame: Frame) -> tuple[_Map, _Map]:
    """Show the image; return the maps from pixels and from work-area positions to the axes."""
    height, width = frame.image.shape[:2]
    right, bottom = width - 0.5, height - 0.5
    corners = [(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)]
    x, y = frame.plane_map.to_world(corners).T
    is_straight = frame.plane_map.intrinsics is None
    if is_straight and np.allclose(
        (x[0], x[1], y[0], y[2]), (x[3], x[2], y[1], y[3]), rtol=0, atol=1e-3
    ):
        extent, labels = (x[0], x[1], y[2], y[0]), ("x (px)", "y (px)")
        maps: tuple[_Map, _Map] = frame.plane_map.to_world, np.asarray
    else:
        extent, labels = (-0.5, right, bottom, -0.5), ("u (pixels)", "v (pixels)")
        maps = np.asarray, frame.plane_map.to_pixel
    axes.imshow(frame.image, extent=extent)
    axes.set(xlim=extent[:2], ylim=extent[2:], xlabel=labels[0], ylabel=labels[1])
    axes.set_autoscale_on(False)
    axes.grid(False)
    return maps


def _part(trace: Trace | None, k: int | None) -> Trace | None:
    """Return the trace up to step k."""
    if trace is None:
        if k is not None:
            raise ValueError(f"k requires a trace, got k = {k} and no trace")
        return None
    check_source("trace", trace, Trace)
    trace = trace.in_unit("px")
    if k is None:
        return trace
    if k not in trace.k:
        raise ValueError(f"k must be a step of {trace!r}, got {k}")
    part: Trace = trace[: k - int(trace.k[0]) + 1]
    return part


def _draw_path(axes: Axes, trace: Trace, from_world: _Map) -> None:
    measured = trace.pose_measured[trace.seen, :2]
    true = trace.pose_true[:, :2]
    true = true[np.isfinite(true).all(axis=1)]  # of frames from elsewhere it is not known
    style.draw_path(axes, from_world(true), from_world(measured))
    style.rasterize_long_lines([axes])


def _outline_of(trace: Trace) -> Floats | None:
    """Return the outline of the robot of a run, if a robot of that name still exists."""
    try:
        robot = load_robot(trace.info.robot)
    except (OSError, ValueError):
        return None
    return robot.to_robot_frame(robot.outline)


def _draw_end(axes: Axes, trace: Trace, outline: Floats | None, from_world: _Map) -> None:
    """Draw the robot at its last measured pose, or at the true pose if that is missing."""
    if trace.seen[-1]:
        _draw_pose(axes, trace.pose_measured[-1], outline, from_world, style.MEASURED)
    elif np.isfinite(trace.pose_true[-1]).all():
        _draw_pose(axes, trace.pose_true[-1], outline, from_world, style.TRUE)


def draw_goals(axes: Axes, goals: Floats, from_world: _Map) -> None:
    """Draw a goal, a position (2,) or a pose (3,), or positions (N, 2), in work-area px and rad."""
    positions = from_world(np.atleast_2d(goals)[:, :2])
    look: dict[str, Any] = {
        "color": style.GOAL,
        "linestyle": "none",
        "path_effects": style.haloed(2),
    }
    look |= {"zorder": 5, "markeredgewidth": 2.0}
    axes.plot(*positions.T, marker="o", markersize=14, markerfacecolor="none", **look)
    axes.plot(*positions.T, marker=".", markersize=5, **look)
    if goals.shape == (3,):
        begin, tip = from_world(heading_line(goals))
        arrow = {
            "arrowstyle": "->",
            "color": style.GOAL,
            "linewidth": 2,
            "shrinkA": 7,
            "shrinkB": 0,
        }
        pointer = axes.annotate("", tip, begin, arrowprops=arrow | {"mutation_scale": 14}, zorder=5)
        assert pointer.arrow_patch is not None
        pointer.arrow_patch.set_path_effects(style.haloed(2))
    axes.plot(
        [], [], "o", color=style.GOAL, markerfacecolor="none", markeredgewidth=2, label="goal"
    )


def _draw_blob(axes: Axes, blob: Blob, color: str, from_pixel: _Map) -> None:
    _draw_polygon(axes, from_pixel(box_corners(blob)), color)
    axes.plot(*from_pixel(blob.centroid), "+", color="white", markersize=6, markeredgewidth=1)


def _draw_polygon(axes: Axes, corners: Floats, color: str) -> None:
    halo = style.haloed(1)
    axes.add_patch(Polygon(corners, fill=False, edgecolor=color, linewidth=1, path_effects=halo))


def _draw_pose(
    axes: Axes, pose: Floats, outline: Floats | None, from_world: _Map, color: str
) -> None:
    line = from_world(heading_line(pose))
    axes.plot(*line.T, color=color, linewidth=2.2, path_effects=style.haloed(2.2))
    axes.plot(*line[0], "o", color=color, markersize=5, path_effects=style.haloed(0.5))
    if outline is not None:
        _draw_polygon(axes, from_world(placed_outline(outline, pose)), color)
