"""`plot_errors`: estimation errors with the reported standard deviations and a bound."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import CARETDOWN, CARETUP
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from robsim.base.checks import Floats, as_float_array
from robsim.base.text import no_formula
from robsim.estimation.evaluation.errors import (
    ErrorReport,
    mean_of_known,
    number_of_bins,
    usual_limits,
)
from robsim.plotting import style as style
from robsim.plotting.style import Panels, check_axes, check_source
from robsim.trace.units import length_format

# Of a long run each of so many parts is drawn as one column.
_COLUMNS = 250
# A band is drawn in full up to that multiple of the errors.
_WIDEST_BAND = 6.0
# Of fewer errors a bell curve says nothing.
_FEW_ERRORS = 8


def draw_errors(panel: Axes, k: NDArray[np.int64], errors: Floats, *, color: str) -> None:
    """Draw errors (N,) over the steps k (N,), so that they can be distinguished; NaN = not known.

    Dots with a line; above 300 steps only dots, so that they do not merge. Above 3000 steps the
    range of the errors, and within it the range of their middle 68 %.
    """
    if len(k) > style.MANY_STEPS:
        _draw_ranges(panel, k, errors, color)
        return
    size = style.dot_size(len(k))
    width = 0.6 if len(k) <= style.SOME_STEPS else 0.0
    panel.plot(k, errors, color=color, linewidth=width, marker=".", markersize=size, label="error")


def _draw_ranges(panel: Axes, k: NDArray[np.int64], errors: Floats, color: str) -> None:
    parts = [part[np.isfinite(part)] for part in np.array_split(errors, _COLUMNS)]
    levels = (0.0, 0.16, 0.84, 1.0)
    low, inner_low, inner_high, high = np.array(
        [np.quantile(part, levels) if len(part) else [np.nan] * 4 for part in parts]
    ).T
    starts = np.array([part[0] for part in np.array_split(k, _COLUMNS)])
    look: dict[str, Any] = {"color": color, "linewidth": 0, "step": "post"}
    panel.fill_between(starts, low, high, alpha=0.25, label="all errors", **look)
    panel.fill_between(starts, inner_low, inner_high, alpha=0.6, label="68 % of them", **look)


def draw_reported(panel: Axes, k: NDArray[np.int64], half_width: Floats) -> float:
    """Draw the band of two reported sigmas (N,), NaN = a gap; return half its usual width."""
    look: dict[str, Any] = {"color": style.REPORTED, "linewidth": 0}
    # The value of a step holds from half a step before it to half a step after it.
    steps = np.column_stack((k - 0.5, k + 0.5)).ravel()
    edges = np.repeat(half_width, 2)
    panel.fill_between(steps, -edges, edges, label="reported (2 sd)", **look)
    return float(np.nanmedian(half_width))


def limit_panel(
    panel: Axes, k: NDArray[np.int64], errors: Floats, *, unit: str, band: float = 0.0
) -> None:
    """Set limits that contain 0 and all errors but outliers, which become triangles at the edge.

    A band around 0, of half that width, stays visible, too, unless it is so wide that the errors
    would be a line. NaN = not known.
    """
    low, high = usual_limits(errors[np.isfinite(errors)], unit)
    seen = min(1.1 * band, _WIDEST_BAND * max(-low, high))
    low, high = min(low, -seen), max(high, seen)
    above, below = errors > high, errors < low
    for beyond, edge, marker in ((above, high, CARETUP), (below, low, CARETDOWN)):
        edges = np.where(beyond, edge, np.nan)
        panel.plot(k, edges, linestyle="none", marker=marker, markersize=4, color=style.HELD)
    if count := np.count_nonzero(above | below):
        is_one = count == 1
        text = (
            f"{count} error{'' if is_one else 's'} beyond the edge: triangle{'' if is_one else 's'}"
        )
        panel.set_title(text, loc="right", fontsize=8, pad=3)
    panel.set_ylim(low, high)


def draw_histogram(axes: Axes, errors: Floats, unit: str, *, color: str = style.MEASURED) -> None:
    """Draw a histogram next to the errors' panel, with the normal of the same mean and sigma."""
    axes.tick_params(labelleft=False)
    axes.xaxis.set_major_locator(MaxNLocator(4, integer=True, min_n_ticks=1))
    if not len(errors):
        return
    low, high = axes.get_ylim()
    bins = number_of_bins(len(errors))
    axes.hist(errors, bins, range=(low, high), orientation="horizontal", color=color, alpha=0.55)
    mean, sd, width = float(errors.mean()), float(errors.std()), (high - low) / bins
    # A curve much narrower than a bin would only be a spike.
    if len(errors) >= _FEW_ERRORS and sd > 0.1 * width:
        values = np.linspace(low, high, 400)
        density = np.exp(-0.5 * ((values - mean) / sd) ** 2) / (sd * math.sqrt(2.0 * math.pi))
        axes.plot(len(errors) * width * density, values, color=style.FITTED, linewidth=1.0)
    axes.margins(x=0.06)
    spec = length_format(unit, 3)
    axes.set_title(f"mean {mean:{spec}}, sd {sd:{spec}} {unit}", loc="left", fontsize=8, pad=3)


@style.applied
def plot_errors(
    report: ErrorReport, *, bound: ArrayLike | None = None, axes: Panels | None = None
) -> Figure:
    """Draw errors over the steps, the reported standard deviations, and histograms of the errors.

    The band is +- two reported standard deviations: 95 % of the errors of a consistent estimator
    lie in it. The dashed lines are +- two standard deviations of the bound: no estimator has
    smaller errors on average. The bell curve is the normal distribution with the errors' mean and
    standard deviation. Outliers are drawn as triangles at the edge.

    Parameters
    ----------
    report : ErrorReport
        From `robsim.pose_errors` or `robsim.estimation.estimation_errors`; all errors of several
        runs are drawn.
    bound : array (N, n, n), optional
        Minimum covariance in each step, from `robsim.estimation.pose_bounds`; for several runs
        their mean.
    axes : array_like (n, 2) of matplotlib.axes.Axes, optional
        Axes to draw in: errors on the left, histograms on the right. Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one is 9 inches wide.

    Raises
    ------
    TypeError, ValueError
        If `report` is not an ErrorReport, or if `bound` or `axes` has the wrong shape.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, measure=True, noise=robsim.GaussianNoise(20))
    >>> figure = robsim.plot_errors(robsim.pose_errors(sim.run(50), of="measurement"))
    >>> len(figure.axes)
    6
    """
    check_source("report", report, ErrorReport)
    size = len(report.names)
    minimum_sd = _minimum_sd(bound, (len(report.k), size))
    is_new = axes is None
    axes = _new_axes(report, size) if is_new else check_axes(axes, (size, 2))
    color = style.MEASURED if report.source == "measurement" else style.ESTIMATED
    for i, (panel, histogram) in enumerate(axes):
        factor, unit = style.shown_unit(report.units[i])
        errors = report.error[:, :, i] * factor
        band = _draw_reported_sd(panel, report, i, factor)
        _draw_errors(panel, report, errors, unit, color, band)
        if minimum_sd is not None:
            _draw_bound(panel, report, 2.0 * factor * minimum_sd[:, i])
        name = no_formula(f"{report.names[i]} error")
        panel.set_ylabel(f"{name}\n({unit})" if unit else name)
        histogram.sharey(panel)
        draw_histogram(histogram, errors[~np.isnan(errors)], unit, color=color)
    _finish(axes, is_new=is_new)
    first: Axes = axes[0, 0]
    return first.figure.figure


def _new_axes(report: ErrorReport, size: int) -> Any:
    figure = style.NotebookFigure(figsize=(9, 1.3 + 1.6 * size))
    axes = figure.subplots(size, 2, squeeze=False, width_ratios=(2.4, 1))
    for panel in axes[:-1, 0]:
        panel.sharex(axes[-1, 0])
        panel.tick_params(labelbottom=False)
    known, total = int(report.known.min()), report.total
    steps = style.n_steps(total)
    steps = f"{steps}, all known" if known == total else f"known in {known} of {steps}"
    figure.suptitle(f"{report.title}: {steps}")
    return axes


def _draw_reported_sd(panel: Axes, report: ErrorReport, i: int, factor: float) -> float:
    """Draw the band of the reported standard deviations; return half its usual width."""
    if report.reported_sd is None or np.isnan(report.reported_sd[:, :, i]).all():
        return 0.0
    variance = mean_of_known(np.square(report.reported_sd[:, :, i]), axis=0)
    half_width = 2.0 * np.sqrt(variance)
    if report.units[i] == "rad":  # errors of angles are wrapped
        half_width = np.minimum(half_width, np.pi)
    return draw_reported(panel, report.k, factor * half_width)


def _minimum_sd(bound: ArrayLike | None, shape: tuple[int, int]) -> Floats | None:
    if bound is None:
        return None
    covariances = as_float_array("bound", bound)
    if covariances.shape != (*shape, shape[1]):
        raise ValueError(f"bound must be of shape {(*shape, shape[1])}, got {covariances.shape}")
    return np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))


def _draw_errors(
    panel: Axes, report: ErrorReport, errors: Floats, unit: str, color: str, band: float
) -> None:
    runs = len(errors)
    panel.axhline(0.0, color=style.GUIDE, linewidth=0.8)
    if runs == 1:
        draw_errors(panel, report.k, errors[0], color=color)
    else:
        for i, run in enumerate(errors):
            look: dict[str, Any] = {"linewidth": 0.4, "alpha": max(0.25, 1.0 / runs)}
            panel.plot(report.k, run, color=color, label="error" if i == 0 else None, **look)
        rmse = np.sqrt(mean_of_known(np.square(errors), axis=0))
        line: dict[str, Any] = {"color": style.FITTED, "linewidth": 1.2}
        panel.plot(report.k, 2.0 * rmse, label="2 rmse of the runs", **line)
        panel.plot(report.k, -2.0 * rmse, **line)
    limit_panel(panel, np.tile(report.k, runs), errors.ravel(), unit=unit, band=band)
    panel.set_xlim(report.k[0] - 0.5, report.k[-1] + 0.5)


def _draw_bound(panel: Axes, report: ErrorReport, half_width: Floats) -> None:
    look: dict[str, Any] = {"color": style.BOUND, "linewidth": 1.2, "linestyle": "--"}
    panel.plot(report.k, half_width, label="Cramér-Rao bound (2 sd)", **look)
    panel.plot(report.k, -half_width, **look)


def _finish(axes: Any, *, is_new: bool) -> None:
    figure = axes[0, 0].figure.figure
    axes[-1, 0].set_xlabel("step k")
    axes[-1, 1].set_xlabel("steps per bin")
    axes[-1, 0].xaxis.set_major_locator(MaxNLocator("auto", integer=True, min_n_ticks=1))
    style.rasterize_long_lines(axes[:, 0])
    parent: Any = figure if is_new else axes[0, 0]
    handles, labels = axes[0, 0].get_legend_handles_labels()
    look: dict[str, Any] = {"loc": "outside lower center", "ncols": 4}
    if not is_new:
        look = {"loc": "lower left", "bbox_to_anchor": (0, 1.1), "borderaxespad": 0.2, "ncols": 2}
    style.enlarge_marks(parent.legend(handles, labels, **look))
