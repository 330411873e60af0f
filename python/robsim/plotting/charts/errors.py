"""`plot_errors`: estimation errors with the reported standard deviations and a bound."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from robsim.base.checks import Floats, as_float_array
from robsim.base.text import no_formula
from robsim.estimation.evaluation.errors import ErrorReport, mean_of_known
from robsim.plotting import style as style
from robsim.plotting.arguments import Panels, check_axes, check_kind
from robsim.plotting.charts.error_panels import (
    draw_errors,
    draw_histogram,
    draw_reported,
    limit_panel,
)


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
        From `robsim.pose_errors` or `robsim.estimation.estimation_errors`; of several runs all
        errors are drawn.
    bound : array (N, n, n), optional
        Minimum covariance in each step, from `robsim.estimation.pose_bounds`; for several runs
        their mean.
    axes : array_like (n, 2) of matplotlib.axes.Axes, optional
        Where to draw: errors on the left, histograms on the right. Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one is 9 inches wide.

    Raises
    ------
    TypeError, ValueError
        If `report` is not an ErrorReport, or if `bound` or `axes` has the wrong shape.
    """
    check_kind("report", report, ErrorReport)
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
