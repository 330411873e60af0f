"""`plot_batch`: the errors of a batch estimate of the 15 parameters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.markers import CARETLEFT
from matplotlib.ticker import LogLocator

from robsim.base.checks import Floats
from robsim.estimation.identification.batch import BatchEstimate
from robsim.plotting import style as style
from robsim.plotting.charts.parameters import percent, relative_scale
from robsim.plotting.style import check_source

# The online estimate often equals the batch estimate: a small diamond in a large circle.
_MARKERS = {"batch": ("o", 9.0), "online": ("D", 4.5)}
_COLORS = {"true": style.TRUE, "model": style.TRUE, "batch": style.BATCH, "online": style.ESTIMATED}

_LABELS = {
    "true": "error: deviation from the true value\n(of d1, hollow, absolute: 100 % = 1 {}, 1 rad)",
    "model": "error: deviation from the model's value\n"
    "(of d1, hollow, absolute: 100 % = 1 {}, 1 rad)",
    "none": "standard errors, relative to the estimates\n(of d1, absolute: 100 % = 1 {}, 1 rad)",
}

# The rows of the 15 parameters, with some room between the axes of the model.
_ROWS = np.arange(15) + 0.6 * (np.arange(15) // 5)
_IS_D1 = np.arange(15) % 5 == 4


@style.applied
def plot_batch(report: BatchEstimate, *, ax: Axes | None = None) -> Axes:
    """Draw the errors of the batch and the online estimates of the 15 parameters.

    The axis is logarithmic, so that 1e-12 and 50 % are both readable. The error is relative to the
    true value. Since d1 may be 0, its error is absolute and has hollow markers. A triangle at the
    left edge marks an error of exactly 0. The values are listed on the right. A pale bar ends at
    two standard errors of the batch estimate: with equation noise, 95 % of the errors lie within
    the bar. If the truth is not known, only these bars are drawn, relative to the estimates.

    Parameters
    ----------
    report : BatchEstimate
        From `robsim.batch_estimate`. The column of the online estimate is omitted if all its values
        are NaN.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in. Default: a new figure of 9 x 7 inches.

    Returns
    -------
    matplotlib.axes.Axes
        The axes; a notebook displays them.

    Raises
    ------
    TypeError
        If `report` is not a BatchEstimate.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, control=robsim.DriveAround())
    >>> axes = robsim.plot_batch(robsim.batch_estimate(sim.run(200)))
    >>> [label.get_text() for label in axes.get_yticklabels()][:3]
    ['a1X', 'a2X', 'b1X (px/V)']
    """
    check_source("report", report, BatchEstimate)
    ax = style.panel(ax, (9, 7))
    true = report.theta_true.ravel()
    is_known = bool(np.isfinite(true).all())
    scale = relative_scale(report.theta_true if is_known else report.batch).ravel()
    estimates = {"batch": report.batch.ravel()}
    if np.isfinite(report.online).any():
        estimates["online"] = report.online.ravel()
    deviations = {name: np.abs(theta - true) / scale for name, theta in estimates.items()}
    bars = 2 * report.standard_errors.ravel() / scale
    low, high = _decades(np.concatenate([*deviations.values(), bars]))
    origin = "true" if report.knows_truth else "model"
    label = _LABELS[origin if is_known else "none"].format(report.unit)
    _finish_axes(ax, low, high, label, style.parameter_labels(report.unit))
    _draw_standard_errors(ax, bars, low)
    if is_known:
        for name, values in deviations.items():
            _draw_deviations(ax, values, low, name)
    columns = {origin: true, **estimates} if is_known else estimates
    for i, (name, values) in enumerate(columns.items()):
        _write_column(ax, name, values, offset=72.0 + 80.0 * i)
    ax.set_title(report.title, loc="left", pad=24)
    ax.legend(loc="upper left", bbox_to_anchor=(1, 0), borderaxespad=0.6, ncols=2)
    return ax


def _decades(deviations: Floats) -> tuple[float, float]:
    """Return axis limits around all errors; the lower one also marks an error of 0."""
    seen = deviations[np.isfinite(deviations) & (deviations > 0)]
    low, high = (seen.min(), seen.max()) if len(seen) else (1e-3, 1e-1)
    return 10.0 ** (math.floor(math.log10(low)) - 0.5), 10.0 ** (math.ceil(math.log10(high)) + 0.2)


def _finish_axes(axes: Axes, low: float, high: float, label: str, names: list[str]) -> None:
    axes.set_xscale("log")
    axes.set(xlim=(low, high), ylim=(_ROWS[-1] + 0.6, -0.6))
    axes.xaxis.set_major_locator(LogLocator(numticks=6))
    axes.xaxis.set_major_formatter(percent)
    axes.minorticks_off()
    axes.set_yticks(_ROWS, names)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(label)


def _draw_standard_errors(axes: Axes, bars: Floats, low: float) -> None:
    """Draw bars from the left edge to two standard errors."""
    is_known = np.isfinite(bars) & (bars > low)
    if is_known.any():
        axes.barh(
            _ROWS[is_known],
            bars[is_known] - low,
            left=low,
            height=0.62,
            color=style.BATCH,
            alpha=0.22,
            linewidth=0,
            label="2 standard errors of the batch",
        )


def _draw_deviations(axes: Axes, values: Floats, exact: float, name: str) -> None:
    look: dict[str, Any] = {
        "color": _COLORS[name],
        "linestyle": "none",
        "markersize": _MARKERS[name][1],
        "markeredgewidth": 1.4,
        "zorder": 3,
    }
    is_exact = values == 0
    shown = np.where(is_exact, exact, values)
    for at, marker, face, label in (
        (~_IS_D1 & ~is_exact, _MARKERS[name][0], _COLORS[name], name),
        (_IS_D1 & ~is_exact, _MARKERS[name][0], "white", None),
        (is_exact, CARETLEFT, _COLORS[name], None),
    ):
        axes.plot(shown[at], _ROWS[at], marker=marker, markerfacecolor=face, label=label, **look)


def _write_column(axes: Axes, name: str, values: Floats, *, offset: float) -> None:
    """Write the values of the rows, right-aligned `offset` points right of the axes."""
    look: dict[str, Any] = {
        "xycoords": axes.get_yaxis_transform(),
        "textcoords": "offset points",
        "ha": "right",
        "va": "center",
    }
    color = _COLORS[name]
    axes.annotate(name, (1, -1.1), (offset, 0), color=color, size=9, weight="bold", **look)
    for row, value in zip(_ROWS, values, strict=True):
        known = np.isfinite(value)
        text, color = (f"{value:.6g}", "#202020") if known else ("not determined", style.GUIDE)
        axes.annotate(text, (1, row), (offset, 0), color=color, **look)
