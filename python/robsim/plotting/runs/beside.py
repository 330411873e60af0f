"""The picture of a run that went wrong: its path, and its error beside that of the reference."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from robsim.base.checks import Floats
from robsim.plotting import style as style
from robsim.plotting.charts.traces import draw_plan
from robsim.plotting.runs.errors import DRIVE, ESTIMATE, MEASUREMENT, RunError, run_errors
from robsim.trace import Trace

_COLORS = {ESTIMATE: style.ESTIMATED, MEASUREMENT: style.MEASURED, DRIVE: style.TRUE}
_REFERENCE = style.BATCH
_SIZE, _DPI = (9.0, 3.7), 100  # inches; some 60 kB
_LEAST_VIEW, _ARROW = 120.0, 40.0  # px of the work area
_UNSCORED: dict[str, Any] = {"facecolor": "none", "edgecolor": "#c3c8d0", "hatch": "///"}
_RING: dict[str, Any] = {"markersize": 12, "markerfacecolor": "none", "markeredgewidth": 1.6}


def draw_run(
    trace: Trace,
    reference: Trace | None,
    *,
    slots: Sequence[str],
    goals: ArrayLike | None = None,
    asked: Mapping[str, float] | None = None,
    unscored: int = 0,
) -> tuple[Figure, str]:
    """Draw a run of a submission beside that of the reference in the same world.

    Parameters
    ----------
    trace, reference : Trace
        Both runs; that of the submission may have ended early.
    slots : sequence of str
        What the submission fills, which says what its error is: of the estimate, of the
        measurement, of the parameters; for a controller the distance from the goal or the path.
    goals : array_like (3,), (2,) or (N, 2), optional
        A pose or a position to drive to, or the corners of a path; in work-area px.
    asked : mapping of str to float, optional
        By the unit of an error: how large it may be in this run, by and large, for all points, such
        as ``{"px": 0.8, "deg": 1.2}``.
    unscored : int
        Number of steps at the start that do not count: no largest error is told of them.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    caption : str
        What it shows, in a sentence or two.

    Raises
    ------
    ValueError
        If the run has no steps.
    """
    if not len(trace):
        raise ValueError("trace must have steps")
    points = None if goals is None else np.asarray(goals, float)
    errors = run_errors(trace, reference, slots, points, unscored)
    figure = _drawn(trace, reference, errors, "control" in slots, points)
    for error, panel in zip(errors, figure.axes[1:], strict=False):
        if (level := (asked or {}).get(error.unit)) is not None:
            _draw_asked(panel, level)
    add_legend(figure)
    return figure, _caption(trace, reference, errors)


def as_png(figure: Figure) -> bytes:
    """Return a figure as the bytes of a PNG file."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=_DPI, metadata={"Software": None})
    return content.getvalue()


def _caption(trace: Trace, reference: Trace | None, errors: Sequence[RunError]) -> str:
    text = "; ".join(error.sentence(int(trace.k[0])) for error in errors) or "The path"
    text = f"{text[0].upper()}{text[1:]}."
    if reference is not None and len(trace) < len(reference):
        text += f" The run ended at step {int(trace.k[-1])} of {int(reference.k[-1])}."
    return text


@style.applied
def _drawn(
    trace: Trace,
    reference: Trace | None,
    errors: Sequence[RunError],
    is_driven: bool,
    goals: Floats | None,
) -> Figure:
    figure = style.NotebookFigure(figsize=_SIZE)
    rows: list[list[Any]] = [["plan", str(row)] for row in range(max(len(errors), 1))]
    axes = figure.subplot_mosaic(rows, width_ratios=(1, 1.45))
    first = errors[0].unscored if errors else 0
    _draw_plan(axes["plan"], trace, reference if is_driven else None, goals, first)
    _mark_worst(axes["plan"], trace, errors)
    longest = trace if reference is None or len(trace) >= len(reference) else reference
    for row, error in enumerate(errors):
        panel = axes[str(row)]
        _draw_error(panel, trace, error)
        style.show_steps(panel, longest)
        if row < len(errors) - 1:
            panel.set_xlabel("")
            panel.tick_params(labelbottom=False)
    if not errors:
        axes["0"].set_axis_off()
    return figure


def _draw_plan(
    plan: Axes, trace: Trace, reference: Trace | None, goals: Floats | None, first: int
) -> None:
    """Draw paths and goals from above, as near as they and what counts of an estimate allow."""
    draw_plan(plan, trace)
    estimated = trace.pose_estimated[:, :2]
    shown = [trace.pose_true[:, :2], estimated[first:]]
    if reference is not None:
        line: dict[str, Any] = {"color": _REFERENCE, "linestyle": "--", "linewidth": 1.4}
        shown.append(reference.pose_true[:, :2])
        plan.plot(*shown[-1].T, label="reference", **line)
    if np.isfinite(trace.pose_estimated).any():
        plan.plot(*estimated.T, color=style.ESTIMATED, linewidth=1.2, label="estimated path")
    if goals is not None:
        shown.append(draw_goals(plan, goals))
    zoom(plan, np.vstack(shown), trace.info.px_length)


def draw_goals(plan: Axes, goals: Floats) -> Floats:
    """Draw a goal, or waypoints, and return their positions (N, 2)."""
    positions: Floats = np.atleast_2d(goals)[:, :2]
    look: dict[str, Any] = {"color": style.GOAL, "markersize": 9, "markeredgewidth": 2.4}
    if goals.ndim > 1:
        plan.plot(*positions.T, "x-", linewidth=4, zorder=1.5, label="waypoints", **look)
        return positions
    plan.plot(*positions.T, "x", zorder=1.5, label="goal", **look)
    if len(goals) == 3:
        # a line along the heading that it is to have
        ahead = _ARROW * np.array([math.cos(goals[2]), math.sin(goals[2])])
        plan.plot(*np.array([goals[:2], goals[:2] + ahead]).T, color=style.GOAL, linewidth=2.4)
    return positions


def zoom(plan: Axes, points: Floats, px: float = 1.0) -> None:
    """Show a square around points, with y downwards; `px` is the length of a px."""
    least = _LEAST_VIEW * px
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    half = 0.6 * max(*(high - low), least)
    x, y = (low + high) / 2
    plan.set_aspect("equal", adjustable="box")
    plan.set(xlim=(x - half, x + half), ylim=(y + half, y - half))


def _mark_worst(plan: Axes, trace: Trace, errors: Sequence[RunError]) -> None:
    if errors and (at := errors[0].worst) is not None:
        label = "end" if errors[0].counts_at_end else "largest error"
        plan.plot(*trace.pose_true[at, :2], "o", color=style.WRONG, label=label, **_RING)


def _draw_error(axes: Axes, trace: Trace, error: RunError) -> None:
    for start, end in _segments(trace.hidden.astype(int)):
        low, high = trace.k[start] - 0.5, trace.k[end - 1] + 0.5
        axes.axvspan(low, high, color=style.SEGMENT, zorder=0, label="robot hidden")
    if error.unscored:
        low, high = trace.k[0] - 0.5, trace.k[0] + error.unscored - 0.5
        axes.axvspan(low, high, label="not scored", **_UNSCORED)
    if error.reference is not None:
        k = int(trace.k[0]) + np.arange(len(error.reference))
        axes.plot(k, error.reference, color=_REFERENCE, linewidth=1.4, label="reference")
    color = _COLORS[error.of]
    axes.plot(trace.k, error.yours, marker=".", markersize=4, color=color, label="this run")
    if (at := error.worst) is not None:
        axes.plot(trace.k[at], error.yours[at], "o", color=style.WRONG, clip_on=False, **_RING)
    axes.set_title(f"{error.title} ({error.unit})", loc="left", fontsize=8.5)
    if error.unit == "%":  # it falls by powers of ten
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0, top=_top(error))


def _top(error: RunError) -> float | None:
    """Return up to where an error is drawn, where it may be large in steps that do not count."""
    lines = [error.yours] if error.reference is None else [error.yours, error.reference]
    scored = [line[error.unscored :][np.isfinite(line[error.unscored :])] for line in lines]
    if not error.unscored or not len(scored[0]):  # then the largest error told is one of these
        return None
    return 1.15 * float(np.concatenate(scored).max()) or None


def _segments(mask: Any) -> list[tuple[int, int]]:
    """Return start and end of each segment of steps in which a mask is 1."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask, [0]))))
    return [(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _draw_asked(axes: Axes, level: float) -> None:
    axes.axhline(level, color=style.WRONG, linewidth=1, linestyle=":", label="asked on average")
    if axes.get_yscale() == "linear":
        axes.set_ylim(top=max(axes.get_ylim()[1], 1.1 * level))


@style.applied
def add_legend(figure: Figure) -> None:
    """Put one legend for all panels below a figure."""
    entries: dict[str, Any] = {}
    for panel in figure.axes:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    look: dict[str, Any] = {"fontsize": 8, "columnspacing": 1.1, "handlelength": 1.4}
    legend = figure.legend(entries.values(), entries, loc="outside lower center", ncols=8, **look)
    style.enlarge_marks(legend)
