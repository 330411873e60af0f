"""The picture of a failed run: its path, and its error next to the reference's."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from robsim._core import wrap_angle
from robsim.base.checks import Floats
from robsim.base.values import runs_of
from robsim.plotting import style as style
from robsim.plotting.charts.traces import draw_plan
from robsim.trace import Trace
from robsim.trace.units import length_format

#: The kind of an error, which selects its colour.
ESTIMATE, MEASUREMENT, DRIVE = "estimate", "measurement", "drive"
_POSES = {ESTIMATE: "pose_estimated", MEASUREMENT: "pose_measured"}


@dataclass(frozen=True)
class RunError:
    """An error of a submission and of the reference."""

    title: str
    unit: str
    of: str  # `ESTIMATE`, `MEASUREMENT` or `DRIVE`
    yours: Floats  # (N,): the submission's; NaN = not known
    reference: Floats | None  # (M,): the reference's
    counts_at_end: bool = False  # whether it should become small, and is large at first
    unscored: int = 0  # number of rows at the start that do not count

    @property
    def worst(self) -> int | None:
        """The reported row: the last one, or the row of the largest error."""
        known = np.flatnonzero(np.isfinite(self.yours))
        scored = known[known >= self.unscored]
        known = scored if len(scored) else known
        if not len(known):
            return None
        return int(known[-1]) if self.counts_at_end else int(known[self.yours[known].argmax()])

    def sentence(self, first_step: int) -> str:
        """Return the error's size and place, and the reference's error there."""
        at = self.worst
        if at is None:
            return f"{self.title}: not known at any step"
        when = "at the end" if self.counts_at_end else "at most"
        text = f"{self.title}: {when} {self._value(self.yours[at])}, in step {first_step + at}"
        theirs = self.reference
        if theirs is None or at >= len(theirs) or not np.isfinite(theirs[at]):
            return text
        return f"{text}, where the reference has {self._value(theirs[at])}"

    def _value(self, value: float) -> str:
        decimals = length_format(self.unit, 1) if self.unit in ("px", "mm", "cm", "m") else ".1f"
        return f"{format(value, decimals)} {self.unit}"


def run_errors(
    trace: Trace,
    reference: Trace | None,
    slots: Sequence[str],
    goals: Floats | None,
    unscored: int = 0,
) -> list[RunError]:
    """Return the errors of a run, by the slots of the submission; see `draw_run`."""
    errors = _errors(trace, reference, slots, goals)
    return [replace(error, unscored=unscored) for error in errors]


def _errors(
    trace: Trace, reference: Trace | None, slots: Sequence[str], goals: Floats | None
) -> list[RunError]:
    if "estimate_state" in slots:
        return _of_poses(ESTIMATE, "estimated", trace, reference)
    if "measure" in slots:
        return _of_poses(MEASUREMENT, "measured", trace, reference)
    if {"init_parameter_estimator", "estimate_parameters"} & set(slots):
        theirs = None if reference is None else _relative_error(reference)
        title = "error of the parameters"
        return [RunError(title, "%", ESTIMATE, _relative_error(trace), theirs, counts_at_end=True)]
    return [] if goals is None else _of_drive(trace, reference, goals)


def _of_poses(of: str, word: str, trace: Trace, reference: Trace | None) -> list[RunError]:
    def errors(run: Trace) -> tuple[Floats, Floats]:
        poses: Floats = getattr(run, _POSES[of])
        off = poses - run.pose_true
        return np.hypot(off[:, 0], off[:, 1]), _degrees(off[:, 2])

    yours = errors(trace)
    theirs = (None, None) if reference is None else errors(reference)
    position, heading = f"error of the {word} position", f"error of the {word} heading"
    return [
        RunError(position, trace.info.unit, of, yours[0], theirs[0]),
        RunError(heading, "deg", of, yours[1], theirs[1]),
    ]


def _degrees(off: ArrayLike) -> Floats:
    turned: Floats = np.abs(np.rad2deg(wrap_angle(off)))
    return turned


def _relative_error(run: Trace) -> Floats:
    # 100 |theta - theta_true| / |theta_true| of each row of the model, and their mean
    true = np.asarray(run.info.theta_true, float)
    off = np.linalg.norm(run.parameters - true, axis=2) / np.linalg.norm(true, axis=1)
    relative: Floats = 100 * off.mean(axis=1)
    return relative


def _of_drive(trace: Trace, reference: Trace | None, goals: Floats) -> list[RunError]:
    is_goal = goals.ndim == 1

    def distances(run: Trace) -> Floats:
        return distance(run.pose_true[:, :2], goals)

    if not is_goal:  # the path begins where the robot stands
        goals = np.vstack((trace.pose_true[:1, :2], goals))
    theirs = None if reference is None else distances(reference)
    title = "distance from the goal" if is_goal else "distance from the path"
    unit = trace.info.unit
    errors = [RunError(title, unit, DRIVE, distances(trace), theirs, counts_at_end=is_goal)]
    if goals.shape == (3,):
        yours = _degrees(trace.pose_true[:, 2] - goals[2])
        theirs = None if reference is None else _degrees(reference.pose_true[:, 2] - goals[2])
        title = "heading error at the goal"
        errors.append(RunError(title, "deg", DRIVE, yours, theirs, counts_at_end=True))
    return errors


def distance(positions: Floats, goals: Floats) -> Floats:
    """Return distances of positions (N, 2) from a goal (2,), (3,) or a path's corners (M, 2)."""
    corners = np.atleast_2d(goals)[:, :2]
    if len(corners) == 1:
        corners = np.repeat(corners, 2, axis=0)
    starts, ways = corners[:-1], np.diff(corners, axis=0)
    off = positions[:, np.newaxis] - starts
    # The part of each line at which it is nearest, 0 to 1.
    part = (off * ways).sum(axis=2) / np.maximum((ways**2).sum(axis=1), 1e-12)
    nearest = starts + np.clip(part, 0, 1)[..., np.newaxis] * ways
    found: Floats = np.linalg.norm(positions[:, np.newaxis] - nearest, axis=2).min(axis=1)
    return found


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
    """Draw a run of a submission and the reference's; return the figure and a caption.

    The submission's slots select the errors: estimate, measurement, parameters, or a controller's
    distance from `goals`. Goals are a pose (3,), a position (2,) or a path's corners (N, 2), in
    work-area px. `asked` has by unit the mean error for full points, such as ``{"px": 0.8, "deg":
    1.2}``. The first `unscored` steps have no largest error.
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
    """Draw paths and goals from above, zoomed to them and to the relevant part of an estimate."""
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
    for start, end in runs_of(trace.hidden):
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
    """Return the upper limit of a drawn error, which may be large in steps that do not count."""
    lines = [error.yours] if error.reference is None else [error.yours, error.reference]
    scored = [line[error.unscored :][np.isfinite(line[error.unscored :])] for line in lines]
    if not error.unscored or not len(scored[0]):  # then the largest error told is one of these
        return None
    return 1.15 * float(np.concatenate(scored).max()) or None


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
