"""Panels of errors and their histograms, which `plot_traces` and `plot_errors` share."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.markers import CARETDOWN, CARETUP
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim.plotting import _style as style


def limit_panel(panel: Axes, k: NDArray[np.int64], errors: Floats) -> None:
    """Set limits that contain all errors but outliers, which become triangles at the edge.

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        Errors over the steps.
    k, errors : array (N,)
        The steps and errors drawn there; NaN = not known.
    """
    low, high = _usual_limits(errors[np.isfinite(errors)])
    above, below = errors > high, errors < low
    for beyond, edge, marker in ((above, high, CARETUP), (below, low, CARETDOWN)):
        edges = np.where(beyond, edge, np.nan)
        panel.plot(k, edges, linestyle="none", marker=marker, color=style.HELD)
    if count := np.count_nonzero(above | below):
        panel.text(
            0.01, 0.95, f"{count} beyond", transform=panel.transAxes, va="top", bbox=style.BOX
        )
    panel.set_ylim(low, high)


def _usual_limits(values: Floats) -> tuple[float, float]:
    """Return limits that contain all values except those far outside the middle 90 %."""
    if not len(values):
        return -1.0, 1.0
    low, high = np.quantile(values, (0.05, 0.95))
    tolerance = 3.0 * (high - low)
    usual = values[(values >= low - tolerance) & (values <= high + tolerance)]
    low, high = float(usual.min()), float(usual.max())
    # A minimum range: rounding errors must not look like measurement errors.
    margin = max(0.3 * (high - low), 1e-3 * abs(low), 1e-3)
    return low - margin, high + margin


def draw_histogram(axes: Axes, errors: Floats, unit: str, *, color: str = style.MEASURED) -> None:
    """Draw a histogram, with the normal distribution of the same mean and standard deviation.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        The axes beside the panel of the errors, whose y axis they share.
    errors : array (n,)
        The known errors.
    unit : str
        Their unit.
    color : str
        Colour of the bars.
    """
    axes.tick_params(labelleft=False)
    axes.xaxis.set_major_locator(MaxNLocator(4, integer=True, min_n_ticks=1))
    if not len(errors):
        return
    low, high = axes.get_ylim()
    # Rice's rule, 2 n^(1/3), over the 5/8 of the panel's height with errors. An odd number, so
    # that one bin is centred in the middle.
    bins = 2 * int(np.clip(1.6 * len(errors) ** (1 / 3), 5, 32)) + 1
    axes.hist(errors, bins, range=(low, high), orientation="horizontal", color=color, alpha=0.55)
    mean, sd, width = float(errors.mean()), float(errors.std()), (high - low) / bins
    # A curve much narrower than a bin would only be a spike.
    if sd > 0.1 * width:
        values = np.linspace(low, high, 400)
        density = np.exp(-0.5 * ((values - mean) / sd) ** 2) / (sd * math.sqrt(2.0 * math.pi))
        axes.plot(len(errors) * width * density, values, color=style.FITTED, linewidth=1.0)
    axes.margins(x=0.12)
    text = f"mean {mean:.3f}, sd {sd:.3f} {unit}"
    axes.text(0.99, 0.98, text, transform=axes.transAxes, ha="right", va="top")
