"""`plot_parameters`: how the online parameter estimates converge."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from numpy.typing import ArrayLike

from robsim._base.checks import Floats, as_float_array
from robsim.identification._identifiability import identifiability
from robsim.plotting import _style as style
from robsim.plotting._arguments import check_axes, check_steps
from robsim.trace import Trace

# One look for each of a1, a2, b1, b2, d1.
_LOOKS: list[dict[str, Any]] = [
    {"color": "#1f5fe0", "linestyle": "-"},
    {"color": "#7aa5f5", "linestyle": "-"},
    {"color": "#00796b", "linestyle": "-"},
    {"color": "#5fc2b5", "linestyle": "-"},
    {"color": "#6b6f76", "linestyle": ":"},
]
_AXES = ("x", "y", "heading")
_D1 = 4


@style.applied
def plot_parameters(
    trace: Trace, *, standard_errors: ArrayLike | None = None, axes: Any = None
) -> Figure:
    """Draw the errors of the 15 online parameter estimates over the steps, on a logarithmic axis.

    A curve that falls converges; one that levels off is biased, or follows the noise. The errors
    are relative to the true values, those of d1, which may be 0, absolute. The true values and
    the last estimates stand beside the curves, with a note where the run excites a parameter
    poorly or not at all, from `robsim.identifiability`: this is about the spread of the estimate by
    noise, not about its bias.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    standard_errors : array (N, 3, 5), optional
        Standard errors of the estimates in each step, such as ``trace.standard_errors_unscaled``
        times ``robsim.identifiability(trace).sigma[:, np.newaxis]``: two of them are drawn as a
        dashed line, below which 95 % of the errors should lie; inf = no line.
    axes : array_like (3,) of matplotlib.axes.Axes, optional
        Where to draw: x, y, heading. Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one has 9 x 7 inches.

    Raises
    ------
    TypeError, ValueError
        If `trace` is not a Trace or has no parameter estimates, or an array has the wrong shape.
    """
    check_steps(trace)
    trace.require("parameters")
    limits = None if standard_errors is None else _limits(standard_errors, trace.parameters.shape)
    if axes is None:
        figure = style.NotebookFigure(figsize=(9, 7))
        dashed = "" if limits is None else "; dashed: two standard errors"
        source = f"Online parameter estimates from {trace.info.identify_from}"
        figure.suptitle(f"{source}; dotted: d1, absolute, 100 % = 1 px, 1 rad{dashed}")
        axes = figure.subplots(3, sharex=True)
    axes = check_axes(axes, (3,))
    true = np.array(trace.info.theta_true)
    has_errors = np.isfinite(trace.standard_errors_unscaled).any()
    verdicts = identifiability(trace).verdicts if has_errors else np.full((3, 5), "")
    for axis, panel in enumerate(axes):
        style.show_steps(panel, trace)
        scale = relative_scale(true[axis])
        deviations = np.abs(trace.parameters[:, axis] - true[axis]) / scale
        _draw_deviations(panel, trace, deviations)
        if limits is not None:
            _draw_limits(panel, trace, limits[:, axis] / scale)
        _finish_axes(panel, deviations, f"{_AXES[axis]}: error")
        _write_values(panel, axis, true[axis], trace.parameters[-1, axis], verdicts[axis])
    for panel in axes[:-1]:
        panel.set_xlabel("")
    style.rasterize_long_lines(axes.flat)
    first: Axes = axes[0]
    return first.figure.figure


def relative_scale(true: Floats) -> Floats:
    """Return what errors of a1, a2, b1, b2, d1 are divided by: 1 for d1 and for a true 0."""
    scale = np.abs(true)
    scale[..., _D1] = 1.0
    scale[(scale == 0) | np.isnan(scale)] = 1.0
    return scale


def percent(fraction: float, _position: float) -> str:
    """Return a fraction as a tick label in percent."""
    return f"{100 * fraction:g} %"


def _limits(standard_errors: ArrayLike, shape: tuple[int, ...]) -> Floats:
    errors = as_float_array("standard_errors", standard_errors)
    if errors.shape != shape:
        raise ValueError(f"standard_errors must be of shape {shape}, got {errors.shape}")
    return 2.0 * np.where(np.isfinite(errors), errors, np.nan)


def _draw_deviations(panel: Axes, trace: Trace, deviations: Floats) -> None:
    # A logarithmic axis has no 0.
    shown = np.where(deviations > 0, deviations, np.nan)
    for values, look in zip(shown.T, _LOOKS, strict=True):
        panel.plot(trace.k, values, linewidth=1.3, **look)


def _draw_limits(panel: Axes, trace: Trace, limits: Floats) -> None:
    for values, look in zip(limits.T, _LOOKS, strict=True):
        panel.plot(trace.k, values, linewidth=0.6, color=look["color"], linestyle="--")


def _finish_axes(panel: Axes, deviations: Floats, label: str) -> None:
    panel.set_yscale("log")
    known = deviations[np.isfinite(deviations) & (deviations > 0)]
    # The first estimates may be off by any factor, and a curve that crosses the truth dips deep.
    low, high = (np.quantile(known, 0.01), min(known.max(), 100.0)) if len(known) else (1e-3, 1.0)
    panel.set_ylim(low / 3, max(high, 10 * low) * 3)
    panel.yaxis.set_major_locator(LogLocator(numticks=7))
    panel.yaxis.set_major_formatter(percent)
    panel.yaxis.set_minor_locator(NullLocator())
    panel.set_ylabel(label)


def _write_values(panel: Axes, axis: int, true: Floats, last: Floats, verdicts: Floats) -> None:
    """Write the true values and the last estimates right of the panel, as its legend."""
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    look |= {"va": "center", "size": 8}
    for offset, text, color in ((132, "true", style.TRUE), (192, "last", style.ESTIMATED)):
        panel.annotate(text, (1, 0.97), (offset, 0), ha="right", weight="bold", color=color, **look)
    for i in range(5):
        height, color = 0.81 - 0.17 * i, _LOOKS[i]["color"]
        line: dict[str, Any] = {"transform": panel.transAxes, "clip_on": False, "linewidth": 2}
        panel.plot([1.02, 1.05], [height] * 2, **line, **_LOOKS[i])
        name = style.PARAMETER_LABELS[5 * axis + i]
        panel.annotate(name, (1.05, height), (4, 0), color=color, weight="bold", **look)
        for offset, value in ((132, true[i]), (192, last[i])):
            text = f"{value:.5g}" if np.isfinite(value) else "none"
            panel.annotate(text, (1, height), (offset, 0), ha="right", **look)
        if verdicts[i] not in ("", "well"):
            text = "not excited" if verdicts[i] == "not excited" else "poorly excited"
            panel.annotate(text, (1, height), (200, 0), color=style.BOUND, **look)
