"""`plot_accuracy`: the errors of measured poses against the noise, with their bound."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from robsim.plotting import style as style

if TYPE_CHECKING:
    from bench_accuracy.result import AccuracyCase, AccuracyResult

# Colour, marker, and where it lies above the others.
_LOOKS = {
    "apriltag": ("AprilTag of the same area", "#7b3fa0", "D", 3),
    "opencv": ("OpenCV, moments of contours", style.ESTIMATED, "v", 4),
    "counted": ("counted centroids", style.GUIDE, "s", 5),
    "weighted": ("weighted centroids", style.BATCH, "^", 6),
    "robsim": ("robsim", style.MEASURED, "o", 7),
}
_MANY_LOST, _NEARLY_ALL = 0.1, 0.9  # of the frames
_SIZE = 5.5  # of a mark (points)
_HOLLOW: dict[str, Any] = {
    "linestyle": "none",
    "marker": "o",
    "markersize": _SIZE,
    "markerfacecolor": "white",
    "markeredgewidth": 1.2,
}


@style.applied
def plot_accuracy(result: AccuracyResult) -> Figure:
    """Draw the errors in place of an accuracy benchmark against the noise, and the bound.

    A row of panels for each size of the frames, a column for each kind of noise. Hollow marks: more
    than a tenth of the frames was missed, or gave a false pose; no mark: more than nine tenths.

    Parameters
    ----------
    result : AccuracyResult
        The errors.

    Returns
    -------
    matplotlib.figure.Figure
        The figure.
    """
    sizes = list(dict.fromkeys(case.size for case in result.cases))
    kinds = [kind for kind in ("gaussian", "uniform") if _of(result.cases, sizes[0], kind)[1:]]
    kinds = kinds or ["clean"]
    figure = style.NotebookFigure(figsize=(4.4 * len(kinds), 0.9 + 2.9 * len(sizes)))
    axes = figure.subplots(len(sizes), len(kinds), squeeze=False, sharex="col", sharey="row")
    for row, size in zip(axes, sizes, strict=True):
        for panel, kind in zip(row, kinds, strict=True):
            _draw(panel, _of(result.cases, size, kind), result.frames)
        row[0].set_ylabel(f"camera of {size} px\nrms error in place (px)")
    for panel, kind in zip(axes[0], kinds, strict=True):
        panel.set_title("no noise" if kind == "clean" else f"{kind.capitalize()} noise")
    if kinds != ["clean"]:
        for panel in axes[-1]:
            panel.set_xlabel("noise (%)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    handles.append(Line2D([], [], color=style.FITTED, **_HOLLOW))
    labels.append(f"over {100 * _MANY_LOST:.0f} % missed or false")
    style.enlarge_marks(figure.legend(handles, labels, loc="outside lower center", ncols=3))
    figure.suptitle(f"How exact a measured position is, {result.frames} frames a mark")
    return figure


def _of(cases: Sequence[AccuracyCase], size: int, kind: str) -> list[AccuracyCase]:
    """Return the cases of a panel, without noise first."""
    chosen = [case for case in cases if case.size == size and case.kind in ("clean", kind)]
    return sorted(chosen, key=lambda case: case.percent)


def _draw(panel: Axes, cases: Sequence[AccuracyCase], frames: int) -> None:
    at = np.arange(len(cases))
    bounds = np.array([case.bound_xy for case in cases])
    panel.set_yscale("log")
    for name, (label, color, mark, order) in reversed(_LOOKS.items()):
        errors = [case.errors[name] for case in cases]
        line: dict[str, Any] = {"color": color, "zorder": order, "label": label}
        line["linewidth"] = 2.0 if name == "robsim" else 1.2
        values = [e.xy if e.lost <= _NEARLY_ALL * frames else np.nan for e in errors]
        panel.plot(at, values, marker=mark, markersize=_SIZE, **line)
        lossy = [i for i, error in enumerate(errors) if error.lost > _MANY_LOST * frames]
        look = _HOLLOW | {"marker": mark, "color": color, "zorder": order}
        panel.plot(at[lossy], [values[i] for i in lossy], **look)
    panel.plot(
        at,
        bounds,
        color=style.BOUND,
        linestyle="--",
        linewidth=1.4,
        label="bound of the two markers",
    )
    bottom = bounds.min() / 2
    panel.fill_between(at, bottom, bounds, color=style.BOUND, alpha=0.08, linewidth=0)
    panel.set_ylim(bottom=bottom)
    panel.set_xticks(at, ["clean" if not case.percent else f"{case.percent:g}" for case in cases])
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
