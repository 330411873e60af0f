"""`plot_ellipses`: the covariance ellipses of the estimated positions along the path."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from robsim._base.checks import Floats, check_float, check_int
from robsim.plotting import _style as style
from robsim.trace import Trace

# Corners of the polygon that stands for an ellipse.
_CORNERS = 48


@style.applied
def plot_ellipses(
    trace: Trace,
    *,
    every: int | None = None,
    level: float = 0.95,
    magnify: float | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the covariance of the estimated position as ellipses along the path.

    The true position should lie in its ellipse in 95 % of the steps. Since ellipses are often too
    small to be seen beside a path, they can be magnified; the error of the estimate is then
    magnified by the same factor, so that the true position stays inside or outside of the ellipse.
    An ellipse much larger than the path and the others, such as that of a robot not seen yet, is
    omitted.

    Parameters
    ----------
    trace : Trace
        A run with a state estimator.
    every : int, optional
        Draw every n-th ellipse. Default: about 25 of them.
    level : float
        Probability that the true position lies in its ellipse.
    magnify : float, optional
        Factor by which ellipses and errors are magnified. Default: one that makes them visible.
    ax : matplotlib.axes.Axes, optional
        Where to draw. Default: a new figure of 7 x 7 inches.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, y axis downwards, the same scale in x and y.

    Raises
    ------
    TypeError, ValueError
        If the trace has no estimates with a covariance, or an argument has the wrong type or is
        out of range.
    """
    if not isinstance(trace, Trace):
        raise TypeError(f"trace must be a Trace, got {trace!r}")
    level = check_float("level", level, exclusive_minimum=0.0)
    if level >= 1.0:
        raise ValueError(f"level must lie between 0 and 1, got {level!r}")
    rows = _drawn_rows(trace, every)
    positions, covariances = trace.pose_estimated[rows, :2], trace.covariance[rows, :2, :2]
    shapes = ellipses(covariances, level)
    default = _magnification(trace, shapes)
    times = default if magnify is None else check_float("magnify", magnify, exclusive_minimum=0.0)
    if ax is None:
        figure = style.NotebookFigure(figsize=(7, 7))
        ax = figure.add_subplot(axes_class=style.NotebookAxes)
    ax.plot(
        *trace.pose_estimated[:, :2].T, color=style.ESTIMATED, linewidth=1.0, label="estimated path"
    )
    label = f"{100 * level:g} % ellipse"
    corners = (positions[:, np.newaxis] + times * shapes)[_fits(trace, times * shapes)]
    ax.add_collection(_polygons(corners, label), autolim=True)
    _draw_truth(ax, positions, times * (trace.pose_true[rows, :2] - positions))
    _finish(ax, times)
    return ax


def ellipses(covariances: Floats, level: float) -> Floats:
    """Return the corners of ellipses around 0 that contain a fraction of a normal distribution.

    Parameters
    ----------
    covariances : array (N, 2, 2)
        Covariances of positions.
    level : float
        The fraction.

    Returns
    -------
    array (N, 48, 2)
        The corners.

    Raises
    ------
    ValueError
        If a covariance has a negative eigenvalue.
    """
    eigenvalues, axes = np.linalg.eigh(covariances)
    if (eigenvalues[:, 0] < -1e-9 * eigenvalues[:, 1]).any():
        minimum = eigenvalues[:, 0].min()
        raise ValueError(f"covariance must be positive definite, got the eigenvalue {minimum:g}")
    # With 2 degrees of freedom the chi-square quantile has a closed form: -2 ln(1 - level).
    radius = math.sqrt(-2.0 * math.log1p(-level))
    angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    circle = radius * np.column_stack((np.cos(angle), np.sin(angle)))
    # semi-axes: radius sqrt(eigenvalues)
    scaled = axes * np.sqrt(np.maximum(eigenvalues, 0.0))[:, np.newaxis, :]
    corners: Floats = circle @ np.swapaxes(scaled, 1, 2)
    return corners


def _drawn_rows(trace: Trace, every: int | None) -> NDArray[np.int64]:
    is_known = np.isfinite(trace.covariance[:, :2, :2]).all(axis=(1, 2))
    known = np.flatnonzero(is_known & np.isfinite(trace.pose_estimated[:, :2]).all(axis=1))
    if not len(known):
        trace.require("pose_estimated", "covariance")
    if every is None:
        every = max(1, round(len(trace) / 25))
    every = check_int("every", every, minimum=1, maximum=10**9)
    rows: NDArray[np.int64] = known[known % every == known[0] % every]
    return rows


def _extent(trace: Trace) -> float:
    """Return the extent of the estimated path, the larger of x and y (px)."""
    return float(
        np.ptp(trace.pose_estimated[np.isfinite(trace.pose_estimated[:, 0]), :2], axis=0).max()
    )


def _fits(trace: Trace, shapes: Floats) -> NDArray[np.bool_]:
    """Return which ellipses are not much larger than the path and the other ellipses."""
    sizes = np.abs(shapes).max(axis=(1, 2))
    fits: NDArray[np.bool_] = sizes <= max(_extent(trace), 10.0 * float(np.median(sizes)))
    return fits


def _magnification(trace: Trace, shapes: Floats) -> float:
    """Return 1, 2, 5, 10, ..., so that the median ellipse is about 1/20 of the path's extent."""
    extent = _extent(trace)
    length = 2.0 * np.median(np.abs(shapes).max(axis=(1, 2)))
    if not (extent > 0.0 and length > 0.0):
        return 1.0
    wanted = max(1.0, 0.05 * extent / length)
    decade = 10.0 ** math.floor(math.log10(wanted))
    return float(max(step * decade for step in (1, 2, 5) if step * decade <= wanted))


def _polygons(corners: Floats, label: str) -> PolyCollection:
    return PolyCollection(
        list(corners),
        facecolor=(*to_rgb(style.ESTIMATED), 0.15),
        edgecolor=style.ESTIMATED,
        linewidth=0.9,
        label=label,
    )


def _draw_truth(ax: Axes, positions: Floats, errors: Floats) -> None:
    true = positions + errors
    ax.plot(*positions.T, ".", color=style.ESTIMATED, markersize=3)
    if np.isfinite(true).any():
        ends = np.stack((positions, true, np.full_like(true, np.nan)), axis=1).reshape(-1, 2)
        ax.plot(*ends.T, color=style.TRUE, linewidth=0.7)
        ax.plot(*true.T, ".", color=style.TRUE, markersize=5, label="true position")


def _finish(ax: Axes, times: float) -> None:
    ax.set(xlabel="x (px)", ylabel="y (px)")
    if times != 1.0:
        ax.set_title(f"ellipses and errors {times:g} times as large", loc="left")
    ax.autoscale_view()
    ax.set_aspect("equal", adjustable="datalim")
    if not ax.yaxis_inverted():
        ax.invert_yaxis()
    ax.legend(loc="upper left", bbox_to_anchor=(1, 1))
