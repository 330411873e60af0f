"""`plot_parameters`: the history of the online parameter estimates."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from robsim._base.checks import Floats
from robsim.identification._identifiability import identifiability
from robsim.plotting import _style as style
from robsim.trace import Trace


@style.applied
def plot_parameters(
    trace: Trace, *, standard_errors: ArrayLike | None = None, axes: Any = None
) -> Figure:
    """Draw the history of the 15 online parameter estimates beside their true values.

    The true value is a dotted line that ends in a cross. The limits of each panel contain it and
    the estimates of the second half of the run; earlier ones may lie outside. A note says how well
    the run excites the parameter, from `robsim.identifiability`: this is about the spread of the
    estimate by noise, not about its bias.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    standard_errors : array (N, 3, 5), optional
        Standard errors of the estimates in each step, such as ``trace.standard_errors_unscaled``
        times ``robsim.identifiability(trace).sigma[:, np.newaxis]``: drawn as a band of +- two of
        them around the true value, in which 95 % of the estimates should lie; inf = no band.
    axes : array_like (5, 3) of matplotlib.axes.Axes, optional
        Where to draw: rows a1, a2, b1, b2, d1, columns X, Y, P (heading). Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one has 9 x 7 inches.

    Raises
    ------
    ValueError
        If the trace has no parameter estimates, or an array has the wrong shape.
    """
    trace.require("parameters")
    if axes is None:
        figure = style.NotebookFigure(figsize=(9, 7))
        shaded = "" if standard_errors is None else "; shaded: true value +- 2 standard errors"
        figure.suptitle(f"Online parameter estimation from {trace.info.identify_from}{shaded}")
        axes = figure.subplots(5, 3, sharex=True)
    axes = np.asarray(axes, dtype=object)
    if axes.shape != (5, 3):
        raise ValueError(f"axes: expected an array of 5 x 3 axes, got the shape {axes.shape}")
    bands = None if standard_errors is None else _bands(standard_errors, trace.parameters.shape)
    has_errors = np.isfinite(trace.standard_errors_unscaled).any()
    verdicts = identifiability(trace).verdicts if has_errors else np.full((3, 5), "")
    for i, true in enumerate(np.ravel(trace.info.theta_true)):
        axis, parameter = divmod(i, 5)
        panel = axes[parameter, axis]
        style.show_steps(panel, trace)
        panel.set_ylabel(style.PARAMETER_LABELS[i])
        _draw_parameter(panel, trace.k, trace.parameters[:, axis, parameter], float(true))
        _add_verdict(panel, str(verdicts[axis, parameter]))
        if bands is not None:
            _draw_band(panel, trace.k, float(true), bands[:, axis, parameter])
    for panel, name in zip(axes[0], ("X", "Y", "P (heading)"), strict=True):
        panel.text(0.5, 1.24, name, transform=panel.transAxes, ha="center", size=9.5, weight="bold")
    for panel in axes[:-1].flat:
        panel.set_xlabel("")
    style.rasterize_long_lines(axes.flat)
    first: Axes = axes[0, 0]
    return first.figure.figure


def _draw_parameter(axes: Axes, k: NDArray[np.int64], history: Floats, true: float) -> None:
    axes.plot(k, history, color=style.ESTIMATED, linewidth=1.1)
    axes.axhline(true, color=style.TRUE, linewidth=1.0, linestyle=":")
    axes.plot(
        k[-1:], [true], "x", color=style.TRUE, markersize=7, markeredgewidth=1.8, clip_on=False
    )
    axes.set_ylim(_limits(history, true))
    axes.locator_params(axis="y", nbins=4)
    axes.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
    last = f"{history[-1]:.5g}" if np.isfinite(history[-1]) else "none"
    axes.set_title(f"true {true:.5g}, last {last}", loc="right", fontsize=7.5, pad=3)


def _add_verdict(axes: Axes, verdict: str) -> None:
    color = style.GUIDE if verdict == "well" else style.BOUND
    look: dict[str, Any] = {"transform": axes.transAxes, "ha": "right", "va": "center"}
    text = verdict if verdict in ("", "not excited") else f"{verdict} excited"
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8}
    axes.text(0.97, 0.33, text, fontsize=7.5, color=color, bbox=box, **look)


def _bands(standard_errors: ArrayLike, shape: tuple[int, ...]) -> Floats:
    errors = np.asarray(standard_errors, dtype=np.float64)
    if errors.shape != shape:
        raise ValueError(f"standard_errors must be of shape {shape}, got {errors.shape}")
    return 2.0 * errors


def _draw_band(axes: Axes, k: NDArray[np.int64], true: float, half_width: Floats) -> None:
    half_width = np.where(np.isfinite(half_width), half_width, np.nan)
    look: dict[str, Any] = {"color": style.REPORTED, "linewidth": 0, "zorder": 0.5}
    axes.fill_between(k, true - half_width, true + half_width, **look)


def _limits(history: Floats, true: float) -> tuple[float, float]:
    """Return limits that contain the true value and the second half of the history."""
    later = history[len(history) // 2 :]
    later = later[np.isfinite(later)]
    low, high = np.quantile(later, (0.02, 0.98)) if len(later) else (true, true)
    low, high = min(float(low), true), max(float(high), true)
    # A minimum range: rounding errors must not look like a drift of the estimate.
    margin = max(0.25 * (high - low), 0.02 * abs(true), 1e-6)
    return low - margin, high + margin
