"""`plot_runs`: several runs in one figure, for comparison."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from robsim.base.checks import Floats, check_name
from robsim.base.text import no_formula, quoted
from robsim.control.path_following import as_goals
from robsim.plotting import style as style
from robsim.plotting.beside import RunError, add_legend, draw_goals, run_errors, zoom
from robsim.plotting.style import check_steps
from robsim.simulation.slots import checked_slots
from robsim.trace import Trace

#: One for each run, different from the colour of the truth, which all runs share.
_COLORS = (style.ESTIMATED, style.BATCH, "#00897b", "#8e24aa", "#6d4c41", "#546e7a", "#c0ca33")
#: Slots whose poses are drawn instead of the true ones.
_GROUPS = {"estimate_state": "pose_estimated", "measure": "pose_measured"}
_WIDTH, _HEIGHT, _ROW = 9.0, 3.7, 1.7  # inches


@style.applied
def plot_runs(
    runs: Mapping[str, Trace],
    *,
    goals: ArrayLike | None = None,
    slots: str | Iterable[str] | None = None,
) -> Figure:
    """Draw the true paths of several runs, and their error at each step.

    Parameters
    ----------
    runs : dict of str to Trace
        The runs by their names in the legend, at most 7.
    goals : array_like (3,), (2,) or (N, 2), optional
        The pose or the position that the robot should reach, or its waypoints from the start
        (work-area px).
    slots : str or sequence of str, optional
        The slots in which the runs differ, which select the error: ``"estimate_state"`` the
        estimated poses, ``"measure"`` the measured ones, ``"estimate_parameters"`` the parameters,
        ``"control"`` the distance from `goals`. Default: ``"control"`` if `goals` is given,
        otherwise the first of the slots above that has values in all runs.

    Returns
    -------
    matplotlib.figure.Figure
        The paths on the left, and a panel for each error on the right.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; the message names the argument.

    Examples
    --------
    >>> import robsim
    >>> options = dict(measure=True, start=(300, 300, 0), seed=1)
    >>> near = robsim.Simulation(control=robsim.GoToPoint(500, 400), **options).run(60)
    >>> slow = robsim.GoToPoint(500, 400, maximum_speed=15)
    >>> runs = {"default": near, "slow": robsim.Simulation(control=slow, **options).run(60)}
    >>> figure = robsim.plotting.plot_runs(runs, goals=(500, 400))
    >>> distances = figure.axes[1].lines  # px from the goal
    >>> {line.get_label(): round(line.get_ydata()[-1]) for line in distances}
    {'default': 15, 'slow': 98}
    """
    traces = _checked(runs)
    points = None if goals is None else as_goals(goals)
    differ = _slots_of(traces.values(), points) if slots is None else checked_slots(slots)
    errors = {name: run_errors(trace, None, differ, points) for name, trace in traces.items()}
    rows = max(len(errors[name]) for name in traces)
    figure = style.NotebookFigure(figsize=(_WIDTH, max(_HEIGHT, _ROW * rows)))
    panels: list[list[Any]] = [["plan", str(row)] for row in range(rows)] or [["plan"]]
    axes = figure.subplot_mosaic(panels, width_ratios=(1, 1.45) if rows else (1,))
    _draw_paths(axes["plan"], traces, points, _GROUPS.get("".join(differ[:1]), "pose_true"))
    longest = max(traces.values(), key=len)
    for row in range(rows):
        _draw_errors(axes[str(row)], traces, {name: own[row] for name, own in errors.items()})
        style.show_steps(axes[str(row)], longest)
        if row < rows - 1:
            axes[str(row)].set_xlabel("")
            axes[str(row)].tick_params(labelbottom=False)
    add_legend(figure)
    return figure


def _checked(runs: Any) -> dict[str, Trace]:
    if not isinstance(runs, Mapping) or not 0 < len(runs) <= len(_COLORS):
        raise TypeError(
            f"runs must be a dict of name to Trace, with 1 to {len(_COLORS)} runs, such as "
            f"{{'mine': sim.trace}}, got {quoted(runs)}"
        )
    for name, trace in runs.items():
        check_name("runs: a name", name)
        check_steps(trace)
    return {no_formula(name): trace.in_unit("px") for name, trace in runs.items()}


def _slots_of(traces: Iterable[Trace], goals: Floats | None) -> tuple[str, ...]:
    """Return the first slot with errors in all runs."""
    if goals is not None:
        return ("control",)
    for slot, group in {**_GROUPS, "estimate_parameters": "parameters"}.items():
        if all(np.isfinite(getattr(trace, group)).any() for trace in traces):
            return (slot,)
    return ()


def _draw_paths(plan: Axes, traces: Mapping[str, Trace], goals: Floats | None, group: str) -> None:
    """Draw the poses of a group of all runs; also the true path, if it differs."""
    shown = []
    if goals is not None:
        shown.append(draw_goals(plan, goals))
    for color, (name, trace) in zip(_COLORS, traces.items(), strict=False):
        path = trace.pose_true[:, :2]
        drawn = getattr(trace, group)[:, :2]
        shown += [path, drawn]
        if group != "pose_true":
            plan.plot(*path.T, color=style.TRUE, linewidth=1.0, label="true path")
        plan.plot(*drawn.T, color=color, marker=".", markersize=3, linewidth=1.6, label=name)
        look: dict[str, Any] = {"markersize": 7, "markerfacecolor": "none", "markeredgewidth": 1.4}
        plan.plot(*path[:1].T, "o", color=color, **look)
    x, y = style.position_labels("px")
    plan.set(xlabel=x, ylabel=y, title="paths (circle: start)", aspect="equal")
    zoom(plan, np.vstack(shown))


def _draw_errors(axes: Axes, traces: Mapping[str, Trace], errors: Mapping[str, RunError]) -> None:
    for color, (name, error) in zip(_COLORS, errors.items(), strict=False):
        k = traces[name].k
        axes.plot(k, error.yours, marker=".", markersize=3, linewidth=1.2, color=color, label=name)
    axes.set_title(f"{error.title} ({error.unit})", loc="left", fontsize=8.5)
    if error.unit == "%":  # it falls by powers of ten
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0)
