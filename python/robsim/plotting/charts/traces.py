"""`plot_traces`: the poses of a run, the measurement errors and the path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from robsim.base.checks import Floats, check_bool
from robsim.base.text import no_formula
from robsim.plotting import style as style
from robsim.plotting.charts.errors import draw_errors, draw_histogram, draw_reported, limit_panel
from robsim.plotting.style import check_panels, check_steps
from robsim.trace import Trace
from robsim.trace.units import length_format


@style.applied
def plot_traces(
    trace: Trace, *, show_blobs: bool = False, axes: Mapping[str, Axes] | None = None
) -> Figure:
    """Draw poses, measurement errors with their histograms, and the path.

    The x axes are in steps, and in a new figure also in seconds. The line of the true pose covers
    the dots of the measured pose. Errors are measured minus true poses. The histograms include all
    steps with a seen robot, and the bell curve is the normal distribution with the same mean and
    standard deviation. Outliers are drawn as triangles at the edge.

    Parameters
    ----------
    trace : Trace
        The recorded run. If the pose was not measured, or the truth is not known, only the poses
        and the path are drawn.
    show_blobs : bool
        Also draw the centroids of the two largest blobs of each colour.
    axes : dict of str to matplotlib.axes.Axes, optional
        Axes to draw in, from `Figure.subplot_mosaic`: x, y, heading, path; for the errors dx, dy,
        dheading and their histograms dx bins, dy bins, dheading bins. Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one is 10 x 8 inches, or 10 x 4.6 if the pose was not measured
        or the truth is not known.

    Raises
    ------
    TypeError, ValueError
        If `trace` is not a Trace or has no steps, or a required axes is missing.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, control=robsim.DriveAround(), measure=True)
    >>> figure = robsim.plot_traces(sim.run(100))
    >>> [axes.get_ylabel() for axes in figure.axes][:4]
    ['x (px)', 'y (px)', 'y (px)', 'heading (deg)']
    """
    check_steps(trace)
    check_bool("show_blobs", show_blobs)
    has_errors = bool(np.isfinite(trace.error[:, 0]).any())
    rows = [list(row) for row in (*_POSE_ROWS, *(_ERROR_ROWS if has_errors else ()))]
    is_new = axes is None
    if axes is None:
        figure = style.NotebookFigure(figsize=(10, 8 if has_errors else 4.6))
        axes = figure.subplot_mosaic(rows, width_ratios=(1.7, 1))
    else:
        check_panels(axes, rows)
    left, right = ([axes[name] for name in column] for column in zip(*rows, strict=True))
    for panel in left[:-1]:
        panel.sharex(left[-1])
        panel.tick_params(labelbottom=False)
    style.show_steps(left[-1], trace)
    draw_all_poses(left[:3], trace, show_blobs)
    draw_plan(axes["path"], trace)
    if has_errors:
        _draw_errors(left[3:], right[3:], trace)
    if is_new:
        style.show_time(left[0], trace)
    style.rasterize_long_lines(axes.values())
    _add_legend(left, trace, is_new=is_new)
    return left[0].figure.figure


# How far the panel of the heading extends (deg).
_HEADING_EDGE = 188.0

_POSE_ROWS = [("x", "path"), ("y", "path"), ("heading", "path")]
_ERROR_ROWS = [("dx", "dx bins"), ("dy", "dy bins"), ("dheading", "dheading bins")]


def _add_legend(left: Sequence[Axes], trace: Trace, *, is_new: bool) -> None:
    handles, labels = left[0].get_legend_handles_labels()
    if not is_new:
        look: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0, 1), "borderaxespad": 0.2}
        style.enlarge_marks(left[0].legend(handles, labels, ncols=4, **look))
        return
    if len(left) > 3:
        for handle, label in zip(*left[3].get_legend_handles_labels(), strict=True):
            if label != "error":  # dots of the measurement, which are there already
                handles, labels = [*handles, handle], [*labels, label]
    figure = left[0].figure.figure
    figure.align_ylabels(list(left))
    figure.suptitle(_title(trace))
    legend = figure.legend(handles, labels, loc="outside lower center", ncols=8)
    style.enlarge_marks(legend)


def _title(trace: Trace) -> str:
    steps = f"{style.n_steps(len(trace))} of {trace.info.dt:g} s"
    if not trace.is_tracked:
        return f"{steps}, not measured"
    seen = trace.tracking()
    if not seen.seen:
        return f"{steps}, the robot was never seen"
    parts = [steps, f"robot seen in {'all' if seen.seen == len(trace) else seen.seen}"]
    if seen.false_poses:
        parts.append(f"{seen.false_poses} poses false")
    if seen.rmse_xy == seen.rmse_xy:
        length = format(seen.rmse_xy, length_format(seen.unit, 3))
        parts.append(f"rmse {length} {seen.unit} and {seen.rmse_heading_deg:.3f} deg")
    return ", ".join(parts)


def draw_all_poses(panels: Sequence[Axes], trace: Trace, show_blobs: bool) -> None:
    """Draw x, y and heading, true, measured, held and estimated, over the steps."""
    k, size = trace.k, style.pose_dot_size(len(trace))
    held = np.where(trace.seen[:, np.newaxis], np.nan, trace.pose_held)
    near: dict[str, Any] = {"near": trace.pose_true[:, 2]}
    dots = {"linestyle": "none", "marker": ".", "markersize": size, **near}
    _draw_poses(panels, k, trace.pose_measured, color=style.MEASURED, label="measured", **dots)
    if show_blobs:
        _draw_blobs(panels[:2], trace)
    # Below the lines, and smaller in a long run, because they would hide the path.
    dots["markersize"] = size if len(trace) <= style.SOME_STEPS else 0.6 * size
    _draw_poses(panels, k, held, color=style.HELD, label="not seen: last pose held", **dots)
    line: dict[str, Any] = {"marker": style.line_marker(len(trace))}
    line |= {"color": style.TRUE, "linewidth": style.true_width(len(trace))}
    _draw_poses(panels, k, trace.pose_true, label="true", **line)
    line |= {"color": style.ESTIMATED, "linewidth": 0.7, **near}
    _draw_poses(panels, k, trace.pose_estimated, label="estimated", **line)
    labels = style.position_labels(trace.info.unit)
    for panel, label in zip(panels, (*labels, "heading (deg)"), strict=True):
        panel.set_ylabel(label)
        panel.ticklabel_format(axis="y", useOffset=False)
    for panel in panels[:2]:
        low, high = panel.get_ylim()
        if high - low < 2:  # a robot that stands still: a line, not its rounding errors
            panel.set_ylim((low + high) / 2 - 1, (low + high) / 2 + 1)
    panels[2].set(ylim=(-_HEADING_EDGE, _HEADING_EDGE), yticks=(-180, -90, 0, 90, 180))


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
    heading = style.degrees(poses[:, 2])
    if near is not None:  # a measurement of -179.9 degrees near a truth of 180 is drawn at 180.1
        close = style.degrees(near) + style.degrees(poses[:, 2] - near)
        heading = np.where(np.abs(close) <= _HEADING_EDGE, close, heading)
    if len(k) > style.MANY_STEPS:  # a line that turns so often would be solid ink
        look |= {"linestyle": "none", "marker": "."}
        look["markersize"] = min(look.get("markersize", 3.0), 2.0 * look.get("linewidth", 1.0))
    # No line from 180 down to -180 degrees.
    wraps = np.flatnonzero(np.abs(np.diff(heading)) > 180.0) + 1
    panels[2].plot(
        np.insert(k.astype(float), wraps, np.nan), np.insert(heading, wraps, np.nan), **look
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
                label=no_formula(f"{color} blobs"),
            )


def draw_plan(axes: Axes, trace: Trace) -> None:
    """Draw the work area from above: the path, true and measured, and its start."""
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
    x, y = style.position_labels(trace.info.unit)
    axes.set(xlabel=x, ylabel=y, title="path (circle: start)")
    if trace.info.boundary == "unlimited":
        axes.set_aspect("equal", adjustable="datalim")
        axes.invert_yaxis()
    else:
        # The edges of the outer pixels, whose centres are 0 and width - 1.
        right, bottom = (np.array(trace.info.area) - 0.5) * trace.info.px_length
        left = top = -0.5 * trace.info.px_length
        axes.set_aspect("equal")
        axes.set(xlim=(left, right), ylim=(bottom, top))
        axes.spines[["top", "right"]].set_visible(True)


def _draw_errors(panels: Sequence[Axes], histograms: Sequence[Axes], trace: Trace) -> None:
    errors = trace.error
    errors[:, 2] = np.rad2deg(errors[:, 2])
    reported = 2.0 * np.sqrt(np.diagonal(trace.covariance_measured, axis1=1, axis2=2))
    reported[:, 2] = np.minimum(np.rad2deg(reported[:, 2]), 180.0)  # no error is larger
    length = trace.info.unit
    for axis, (name, unit) in enumerate((("x", length), ("y", length), ("heading", "deg"))):
        panel, known = panels[axis], errors[trace.seen, axis]
        panel.axhline(0.0, color=style.GUIDE, linewidth=0.8)
        is_reported = bool(np.isfinite(reported[:, axis]).any())
        band = draw_reported(panel, trace.k, reported[:, axis]) if is_reported else 0.0
        draw_errors(panel, trace.k, errors[:, axis], color=style.MEASURED)
        limit_panel(panel, trace.k, errors[:, axis], unit=unit, band=band)
        panel.set_ylabel(f"{name} error\n({unit})")
        histograms[axis].sharey(panel)
        draw_histogram(histograms[axis], known[np.isfinite(known)], unit)
    panels[0].set_title("measured minus true", loc="left")
    histograms[-1].set_xlabel("steps per bin")
