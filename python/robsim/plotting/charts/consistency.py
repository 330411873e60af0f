"""`plot_consistency`: the NEES or NIS of a filter with its chi-square band."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator

from robsim.base.report import percent
from robsim.estimation.evaluation.consistency import ConsistencyReport
from robsim.plotting import style as style
from robsim.plotting.arguments import check_kind


@style.applied
def plot_consistency(report: ConsistencyReport, *, ax: Axes | None = None) -> Axes:
    """Draw the NEES or the NIS over the steps with its chi-square band.

    The axis is logarithmic, since the values of an inconsistent filter may be off by orders of
    magnitude. Above the band the filter is optimistic, below it conservative.

    Parameters
    ----------
    report : ConsistencyReport
        From `pose_consistency`, `nees_consistency` or `nis_consistency`.
    ax : matplotlib.axes.Axes, optional
        Where to draw. Default: a new figure of 8 x 3.2 inches.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    TypeError
        If `report` is not a ConsistencyReport.
    """
    check_kind("report", report, ConsistencyReport)
    ax = style.panel(ax, (8, 3.2))
    k, values, (low, high) = report.k, report.values, report.band.T
    is_inside = (values >= low) & (values <= high)
    band = f"{100 * report.level:g} % band"
    edges = np.append(k - 0.5, k[-1] + 0.5)
    look: dict[str, Any] = {"color": style.REPORTED, "linewidth": 0, "step": "post"}
    ax.fill_between(edges, np.append(low, low[-1]), np.append(high, high[-1]), label=band, **look)
    ax.axhline(report.n, color=style.GUIDE, linewidth=0.8)
    if len(k) <= style.SOME_STEPS:
        ax.plot(k, values, color=style.GUIDE, linewidth=0.5)
    size = 1.3 * style.dot_size(len(k)) if len(k) <= style.MANY_STEPS else 1.5
    for where, color, fraction, name in (
        (is_inside, style.ESTIMATED, report.inside, "in"),
        (values > high, style.WRONG, report.above, "above"),
        (values < low, style.BATCH, report.below, "below"),
    ):
        label = f"{percent(fraction)} {name}" if np.isfinite(fraction) else None
        ax.plot(k[where], values[where], ".", color=color, markersize=size, label=label)
    ax.set_yscale("log")
    low, high = ax.get_ylim()
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 2000 * low else (1,)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_locator(NullLocator())
    ax.set_xlim(k[0] - 0.5, k[-1] + 0.5)
    ax.xaxis.set_major_locator(MaxNLocator("auto", integer=True, min_n_ticks=1))
    mean = f", mean of {report.runs} runs" if report.runs > 1 else ""
    ax.set(xlabel="step k", ylabel=f"{report.kind}{mean}\n({report.n} expected)")
    ax.set_title(report.heading, loc="left")
    style.enlarge_marks(ax.legend(loc="upper left", bbox_to_anchor=(1, 1)))
    style.rasterize_long_lines([ax])
    return ax
