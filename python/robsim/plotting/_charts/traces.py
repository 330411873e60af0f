"""`plot_traces`: the poses of a run, the measurement errors and the path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim.plotting import _style as style
from robsim.plotting._charts.error_panels import draw_histogram, limit_panel
from robsim.trace import Trace
from robsim.trace._trace import check_trace, longest_run


@style.applied
def plot_traces(
    trace: Trace, *, show_blobs: bool = False, axes: Mapping[str, Axes] | None = None
) -> Figure:
    """Draw poses, measurement errors with their histograms, and the path.

    The histograms are those of the longest unbroken segment of measurements, whose steps have a
    shaded background. The bell curve is the normal distribution with the mean and the standard
    deviation of the segment. Outliers are drawn as triangles at the edge.

    Parameters
    ----------
    trace : Trace
        The recorded run. If it was not tracked, or the truth is not known, only the poses and the
        path are drawn.
    show_blobs : bool
        Also draw the centroids of the two largest blobs of each colour.
    axes : dict of str to matplotlib.axes.Axes, optional
        Where to draw, as `Figure.subplot_mosaic` returns it: x, y, heading, path; for the errors
        dx, dy, dheading and their histograms dx bins, dy bins, dheading bins. Default: a new
        figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one is 10 x 8 inches, or 10 x 4.6 if the run was not tracked
        or the truth is not known.

    Raises
    ------
    TypeError, ValueError
        If `trace` is not a Trace, or one of the axes is missing.
    """
    check_trace(trace)
    tracked = bool(np.isfinite(trace.pose_held).any())
    rows: list[list[Any]] = [["x", "path"], ["y", "path"], ["heading", "path"]]
    has_errors = tracked and bool(np.isfinite(trace.pose_true).any())
    if has_errors:
        rows += [["dx", "dx bins"], ["dy", "dy bins"], ["dheading", "dheading bins"]]
    is_new = axes is None
    if axes is None:
        figure = style.NotebookFigure(figsize=(10, 8 if has_errors else 4.6))
        axes = figure.subplot_mosaic(rows, width_ratios=(1.7, 1))
    elif missing := sorted({name for row in rows for name in row} - axes.keys()):
        raise ValueError(f"axes must have the panels {', '.join(missing)}, got {', '.join(axes)}")
    left, right = ([axes[name] for name in column] for column in zip(*rows, strict=True))
    for panel in left[:-1]:
        panel.sharex(left[-1])
        panel.tick_params(labelbottom=False)
    style.show_steps(left[-1], trace)
    _draw_all_poses(left[:3], trace, show_blobs)
    _draw_plan(axes["path"], trace)
    if has_errors:
        _draw_errors(left[3:], right[3:], trace)
    style.rasterize_long_lines(axes.values())
    look: dict[str, Any] = {"markerscale": 8 / style.dot_size(len(trace))}
    if is_new:
        figure.align_ylabels(left)
        figure.suptitle(trace.tracking().line if tracked else _untracked_title(trace))
        labels = left[0].get_legend_handles_labels()
        figure.legend(*labels, loc="outside lower center", ncols=8, **look)
    else:
        left[0].legend(ncols=4, **look)
    return left[0].figure.figure


def _untracked_title(trace: Trace) -> str:
    reason = "the robot was never seen" if trace.is_tracked else "not tracked"
    return f"{len(trace)} steps of {trace.info.dt:g} s, {reason}"


def _draw_all_poses(panels: Sequence[Axes], trace: Trace, show_blobs: bool) -> None:
    k, size = trace.k, style.dot_size(len(trace))
    held = np.where(trace.seen[:, np.newaxis], np.nan, trace.pose_held)
    near: dict[str, Any] = {"near": trace.pose_true[:, 2]}
    dots = {"linestyle": "none", "marker": ".", "markersize": size, **near}
    _draw_poses(panels, k, trace.pose_true, color=style.TRUE, linewidth=3.0, label="true")
    if show_blobs:
        _draw_blobs(panels[:2], trace)
    _draw_poses(panels, k, trace.pose_measured, color=style.MEASURED, label="measured", **dots)
    line = {"color": style.ESTIMATED, "linewidth": 0.8, **near}
    _draw_poses(panels, k, trace.pose_estimated, label="estimated", **line)
    _draw_poses(panels, k, held, color=style.HELD, label="not seen: last pose held", **dots)
    for panel, label in zip(panels, ("x (px)", "y (px)", "heading (deg)"), strict=True):
        panel.set_ylabel(label)
        panel.ticklabel_format(axis="y", useOffset=False)
    for panel in panels[:2]:
        low, high = panel.get_ylim()
        if high - low < 2:  # a robot that stands still: a line, not its rounding errors
            panel.set_ylim((low + high) / 2 - 1, (low + high) / 2 + 1)
    panels[2].set(ylim=(-8, 368), yticks=(0, 90, 180, 270, 360))


def _draw_poses(
    panels: Sequence[Axes],
    k: NDArray[np.int64],
    poses: Floats,
    *,
    near: Floats | None = None,
    **look: Any,
) -> None:
    """Draw x, y and the heading, `near` others if given, over the steps; nothing without a pose."""
    if not np.isfinite(poses).any():
        return
    panels[0].plot(k, poses[:, 0], **look)
    panels[1].plot(k, poses[:, 1], **look)
    degrees = np.rad2deg(poses[:, 2]) % 360.0
    if near is not None:  # a measurement of 359.9 degrees near a truth of 0 is drawn at -0.1
        truth = np.rad2deg(near) % 360.0
        unwrapped = truth + (degrees - truth + 180.0) % 360.0 - 180.0
        degrees = np.where(np.isfinite(truth), unwrapped, degrees)
    # No line from 360 down to 0 degrees.
    wraps = np.flatnonzero(np.abs(np.diff(degrees)) > 180.0) + 1
    panels[2].plot(
        np.insert(k.astype(float), wraps, np.nan), np.insert(degrees, wraps, np.nan), **look
    )


def _draw_blobs(panels: Sequence[Axes], trace: Trace) -> None:
    for color, centroids in trace.blobs.items():
        for axis, panel in enumerate(panels):
            panel.plot(
                np.repeat(trace.k, 2),
                centroids[:, :, axis].ravel(),
                ".",
                color=style.drawn_color(color),
                markersize=0.6 * style.dot_size(len(trace)),
                label=f"{color} blobs",
            )


def _draw_plan(axes: Axes, trace: Trace) -> None:
    path = trace.pose_true[:, :2]
    style.draw_path(axes, path, trace.pose_measured[:, :2])
    axes.plot(
        *path[:1].T,
        "o",
        color=style.TRUE,
        markersize=9,
        markerfacecolor="none",
        markeredgewidth=1.6,
        path_effects=style.haloed(1.6),
    )
    axes.set(xlabel="x (px)", ylabel="y (px)", title="path (circle: start)")
    if trace.info.boundary == "unlimited":
        axes.set_aspect("equal", adjustable="datalim")
        axes.invert_yaxis()
    else:
        width, height = trace.info.area
        axes.set_aspect("equal")
        axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
        axes.spines[["top", "right"]].set_visible(True)


def _draw_errors(panels: Sequence[Axes], histograms: Sequence[Axes], trace: Trace) -> None:
    errors = trace.error * (1.0, 1.0, np.rad2deg(1.0))
    segment = longest_run(trace.seen)
    for axis, (name, unit) in enumerate((("dx", "px"), ("dy", "px"), ("d heading", "deg"))):
        _draw_error(panels[axis], trace.k, errors[:, axis], segment)
        panels[axis].set_ylabel(f"{name} ({unit})")
        histograms[axis].sharey(panels[axis])
        draw_histogram(histograms[axis], errors[segment, axis], unit)
    k = trace.k[segment]
    histograms[0].set_title(
        f"longest segment: {k[0]}..{k[-1]}, n = {len(k)}" if len(k) else "no measurement"
    )
    histograms[-1].set_xlabel("steps per bin")


def _draw_error(panel: Axes, k: NDArray[np.int64], errors: Floats, segment: slice) -> None:
    first, last = k[0] + segment.start - 0.5, k[0] + segment.stop - 0.5
    panel.axvspan(first, last, color=style.SEGMENT, linewidth=0, zorder=0)
    panel.axhline(0.0, color=style.GUIDE, linewidth=0.8)
    size = 0.8 * style.dot_size(len(k))
    panel.plot(k, errors, color=style.MEASURED, linewidth=0.6, marker=".", markersize=size)
    limit_panel(panel, k, errors)
