"""`plot_frame`: a camera frame with the detected blobs, the measured pose and the path."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import ArrayLike

from robsim._base.checks import Floats
from robsim._core import Blob, Frame, Measurement
from robsim.plotting import _style as style
from robsim.plotting._images.shapes import box_corners, heading_line, placed_outline
from robsim.trace import Trace

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
) -> Axes:
    """Draw a camera frame with the results of the vision on it.

    The axes are in work-area pixels; if the camera looks at the plane at an angle, so that the
    frame is not a rectangle there, they are in pixels of the frame.

    Parameters
    ----------
    frame : Frame
        The image with its plane map.
    ax : matplotlib.axes.Axes, optional
        Where to draw. Default: a new figure of 7 x 7 inches.
    blobs : dict of str to sequence of Blob, optional
        The blobs of each colour, as from `robsim.find_blobs`: each gets its bounding box and a
        cross.
    measurement : Measurement, optional
        The measured pose: a line from the centre along the heading. With `blobs`, but without it,
        the figure says "not seen".
    outline : array_like (N, 2), optional
        Outline of the robot in its own axes, x forward and y to the right (work-area px), drawn at
        the measured pose.
    trace : Trace, optional
        The run whose path is drawn.
    k : int, optional
        The last step of `trace` to draw. Default: the whole path.

    Returns
    -------
    matplotlib.axes.Axes
        The axes drawn in.

    Raises
    ------
    ValueError
        If `outline` is not of shape (N, 2), or `k` is not a step of `trace`.
    """
    if ax is None:
        ax = style.NotebookFigure(figsize=(7, 7)).add_subplot(axes_class=style.NotebookAxes)
    from_pixel, from_world = _show_image(ax, frame)
    if trace is not None or k is not None:
        _draw_path_until(ax, trace, k, from_world)
    for color, found in (blobs or {}).items():
        for blob in found:
            _draw_blob(ax, blob, style.drawn_color(color), from_pixel)
    if measurement is not None:
        _draw_measurement(ax, measurement, outline, from_world)
    elif blobs is not None:
        ax.text(0.02, 0.02, "not seen", transform=ax.transAxes, fontsize=11, bbox=style.BOX)
    time = "" if frame.t is None else f", t = {frame.t:.2f} s"
    ax.set_title(f"frame {frame.index}{time}", loc="left")
    return ax


def _show_image(axes: Axes, frame: Frame) -> tuple[_Map, _Map]:
    """Show the image; return the maps from pixels and from work-area positions to the axes."""
    height, width = frame.image.shape[:2]
    right, bottom = width - 0.5, height - 0.5
    corners = [(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)]
    x, y = frame.plane_map.to_world(corners).T
    if np.allclose((x[0], x[1], y[0], y[2]), (x[3], x[2], y[1], y[3]), rtol=0, atol=1e-3):
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


def _draw_path_until(axes: Axes, trace: Trace | None, k: int | None, from_world: _Map) -> None:
    if trace is None:
        raise ValueError(f"k needs a trace, got k = {k} and no trace")
    if k is not None:
        if k not in trace.k:
            raise ValueError(f"k must be a step of {trace!r}, got {k}")
        trace = trace[: k - int(trace.k[0]) + 1]
    measured = trace.pose_measured[trace.seen, :2]
    style.draw_path(axes, from_world(trace.pose_true[:, :2]), from_world(measured))
    style.rasterize_long_lines([axes])
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1, 1),
        borderaxespad=0,
        ncols=2,
        markerscale=8 / style.dot_size(len(trace)),
    )


def _draw_blob(axes: Axes, blob: Blob, color: str, from_pixel: _Map) -> None:
    _draw_polygon(axes, from_pixel(box_corners(blob)), color)
    axes.plot(
        *from_pixel(blob.centroid),
        "+",
        color="white",
        markersize=6,
        markeredgewidth=1,
    )


def _draw_polygon(axes: Axes, corners: Floats, color: str) -> None:
    halo = style.haloed(1)
    axes.add_patch(Polygon(corners, fill=False, edgecolor=color, linewidth=1, path_effects=halo))


def _draw_measurement(
    axes: Axes, measurement: Measurement, outline: ArrayLike | None, from_world: _Map
) -> None:
    line = from_world(heading_line(measurement.pose))
    axes.plot(*line.T, color=style.MEASURED, linewidth=2.2, path_effects=style.haloed(2.2))
    axes.plot(*line[0], "o", color=style.MEASURED, markersize=5, path_effects=style.haloed(0.5))
    if outline is not None:
        corners = placed_outline(outline, measurement.pose)
        _draw_polygon(axes, from_world(corners), style.MEASURED)
