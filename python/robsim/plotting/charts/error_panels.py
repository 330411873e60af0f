"""Panels of errors and their histograms, which `plot_traces` and `plot_errors` share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.markers import CARETDOWN, CARETUP
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.estimation.evaluation.histograms import number_of_bins, usual_limits
from robsim.plotting import style as style
from robsim.trace.units import length_format

# Of a long run each of so many parts is drawn as one column.
_COLUMNS = 250

# A band is drawn in full up to that multiple of the errors.
_WIDEST_BAND = 6.0

# Of fewer errors a bell curve says nothing.
_FEW_ERRORS = 8


def draw_errors(panel: Axes, k: NDArray[np.int64], errors: Floats, *, color: str) -> None:
    """Draw errors over the steps, so that they can be told apart.

    Dots with a line; above 300 steps dots alone, which are no solid ink; above 3000 steps the
    range of the errors, and within it that of their middle 68 %.

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        Where to draw.
    k, errors : array (N,)
        Steps and errors; NaN = not known.
    color : str
        Their colour.
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
    """Draw the band of the reported standard deviations; return half its usual width.

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        Errors over the steps.
    k, half_width : array (N,)
        Steps, and two standard deviations; NaN = not known: the band has a gap there.
    """
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

    Parameters
    ----------
    panel : matplotlib.axes.Axes
        Errors over the steps.
    k, errors : array (N,)
        The steps and errors drawn there; NaN = not known.
    unit : str
        The unit of the errors.
    band : float
        Half the width of a band around 0 that is to be seen, too, unless it is so wide that the
        errors would be a line.
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
