"""`plot_parameters`: the convergence of the online parameter estimates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullLocator
from matplotlib.transforms import Affine2D, ScaledTranslation
from numpy.typing import ArrayLike

from robsim.base.checks import Floats, as_float_array
from robsim.estimation.identification.determined import identifiability
from robsim.plotting import style as style
from robsim.plotting.style import Panels, check_axes, check_steps
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
_COLUMN_COLORS = {"true": style.TRUE, "last": style.ESTIMATED}
_D1 = 4


@style.applied
def plot_parameters(
    trace: Trace, *, standard_errors: ArrayLike | None = None, axes: Panels | None = None
) -> Figure:
    """Draw the errors of the 15 online parameter estimates over the steps, on a logarithmic axis.

    A falling curve shows that the estimate converges; a level curve shows a bias, or an estimate
    that follows the noise. The errors are relative to the true values; the errors of d1, which may
    be 0, are absolute. The true values and the last estimates stand next to the curves. A note from
    `robsim.identifiability` marks parameters that the run excites poorly or not at all. This note
    concerns the spread of the estimate due to noise, not its bias. If the truth is not known, the
    curves show the deviations from the last estimates, so they show when the estimates settle, not
    their accuracy.

    Parameters
    ----------
    trace : Trace
        A run with ``estimate_parameters=True``.
    standard_errors : array (N, 3, 5), optional
        Standard errors of the estimates in each step, such as ``trace.standard_errors_unscaled``
        times ``robsim.identifiability(trace).sigma[:, np.newaxis]``. A dashed line shows twice the
        standard error; 95 % of the errors should lie below this line. No line is drawn for inf.
    axes : array_like (3,) of matplotlib.axes.Axes, optional
        Axes to draw in: x, y, heading. Default: a new figure.

    Returns
    -------
    matplotlib.figure.Figure
        The figure of the axes; a new one has 9 x 7 inches.

    Raises
    ------
    TypeError, ValueError
        If `trace` is not a Trace or has no parameter estimates, or an array has the wrong shape.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, control=robsim.DriveAround(), estimate_parameters=True)
    >>> figure = robsim.plot_parameters(sim.run(100))
    >>> [axes.get_ylabel() for axes in figure.axes]
    ['x: error', 'y: error', 'heading: error']
    """
    check_steps(trace)
    trace.require("parameters")
    limits = None if standard_errors is None else _limits(standard_errors, trace.parameters.shape)
    if axes is None:
        figure = style.NotebookFigure(figsize=(9, 7))
        dashed = "" if limits is None else "; dashed: two standard errors"
        source = f"Online parameter estimates from {trace.info.identify_from}"
        dotted = f"dotted: d1, absolute, 100 % = 1 {trace.info.unit}, 1 rad"
        figure.suptitle(f"{source}; {dotted}{dashed}", wrap=True)
        axes = figure.subplots(3, sharex=True)
    axes = check_axes(axes, (3,))
    true, last = np.array(trace.info.theta_true), _last(trace.parameters)
    is_true = bool(np.isfinite(true).all())
    origin, quantity = (true, "error") if is_true else (last, "deviation\nfrom the last")
    has_errors = np.isfinite(trace.standard_errors_unscaled).any()
    verdicts = identifiability(trace).verdicts if has_errors else np.full((3, 5), "")
    for axis, panel in enumerate(axes):
        style.show_steps(panel, trace)
        scale = relative_scale(origin[axis])
        deviations = np.abs(trace.parameters[:, axis] - origin[axis]) / scale
        _draw_deviations(panel, trace, deviations)
        if limits is not None:
            _draw_limits(panel, trace, limits[:, axis] / scale)
        _finish_axes(panel, deviations, f"{_AXES[axis]}: {quantity}")
        columns = {"true": true[axis]} if is_true else {}
        names = style.parameter_labels(trace.info.unit)[5 * axis : 5 * axis + 5]
        _write_values(panel, names, columns | {"last": last[axis]}, verdicts[axis])
    for panel in axes[:-1]:
        panel.set_xlabel("")
    style.rasterize_long_lines(axes.ravel().tolist())
    first: Axes = axes[0]
    return first.figure.figure


def relative_scale(true: Floats) -> Floats:
    """Return the divisors of errors of a1, a2, b1, b2, d1: 1 for d1 and for a true 0."""
    scale = np.abs(true)
    scale[..., _D1] = 1.0
    scale[(scale == 0) | np.isnan(scale)] = 1.0
    return scale


def percent(fraction: float, _position: float) -> str:
    return f"{100 * fraction:g} %"


def _last(parameters: Floats) -> Floats:
    """Return the last estimates (3, 5) that are known."""
    known = parameters[np.isfinite(parameters).all(axis=(1, 2))]
    last: Floats = known[-1] if len(known) else parameters[-1]
    return last


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


def _write_values(
    panel: Axes, names: list[str], columns: Mapping[str, Floats], verdicts: Floats
) -> None:
    """Write the true values and the last estimates right of the panel, as its legend."""
    look: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points"}
    look |= {"va": "center", "size": 8}
    offsets = {name: 140 + 60 * i for i, name in enumerate(columns)}
    end = max(offsets.values())
    for name, offset in offsets.items():
        color = _COLUMN_COLORS[name]
        panel.annotate(name, (1, 0.97), (offset, 0), ha="right", weight="bold", color=color, **look)
    for i in range(5):
        height, color = 0.81 - 0.17 * i, _LOOKS[i]["color"]
        _draw_sample(panel, height, _LOOKS[i])
        panel.annotate(names[i], (1, height), (27, 0), color=color, weight="bold", **look)
        for column, values in columns.items():
            text = f"{values[i]:.5g}" if np.isfinite(values[i]) else "none"
            panel.annotate(text, (1, height), (offsets[column], 0), ha="right", **look)
        if verdicts[i] not in ("", "well"):
            text = "not excited" if verdicts[i] == "not excited" else "poorly excited"
            panel.annotate(text, (1, height), (end + 8, 0), color=style.BOUND, **look)


def _draw_sample(panel: Axes, height: float, look: dict[str, Any]) -> None:
    """Draw a short line of this look beside the panel: the same length beside every panel."""
    figure: Any = panel.figure.figure
    from_axes: Any = panel.transAxes
    points = Affine2D().scale(1 / 72) + figure.dpi_scale_trans
    place = points + ScaledTranslation(1, height, from_axes)
    panel.add_artist(Line2D([8, 23], [0, 0], transform=place, clip_on=False, linewidth=2, **look))
