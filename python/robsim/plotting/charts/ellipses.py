"""`plot_ellipses`: the covariance ellipses of the estimated positions along the path."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.ticker import LogLocator, MaxNLocator, NullLocator
from numpy.typing import NDArray

from robsim.base.checks import Floats, check_float, check_int
from robsim.base.report import percent
from robsim.base.text import quoted
from robsim.estimation.evaluation.consistency import ConsistencyReport
from robsim.plotting import style as style
from robsim.plotting.style import check_source, check_steps
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

    In 95 % of the steps, the true position should lie in the ellipse; an ellipse without the true
    position is red. Ellipses are often too small to be visible along a path, so they can be
    magnified: the paths stay unchanged, and the colour refers to the true size. Huge ellipses, such
    as those before the robot is first seen, are omitted.

    Parameters
    ----------
    trace : Trace
        A run with a state estimator.
    every : int, optional
        Draw every n-th ellipse. Default: about 25 ellipses.
    level : float
        Probability that the true position lies in its ellipse.
    magnify : float, optional
        Magnification of the ellipses. Default: a factor that makes the ellipses visible.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in. Default: a new figure of 7 x 7 inches.

    Returns
    -------
    matplotlib.axes.Axes
        The axes, y axis downwards, the same scale in x and y.

    Raises
    ------
    TypeError, ValueError
        If the trace has no estimates with a covariance, or an argument has the wrong type or is
        out of range.

    Examples
    --------
    >>> estimator = robsim.estimation.reference.ExtendedKalmanFilter()
    >>> sim = robsim.Simulation(seed=1, measure=True, estimate_state=estimator)
    >>> axes = robsim.plotting.plot_ellipses(sim.run(50))
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('x (px)', 'y (px)')
    """
    check_steps(trace)
    level = check_float("level", level, exclusive_minimum=0.0)
    if level >= 1.0:
        raise ValueError(f"level must lie between 0 and 1, got {quoted(level)}")
    rows = _drawn_rows(trace, every)
    positions, covariances = trace.pose_estimated[rows, :2], trace.covariance[rows, :2, :2]
    shapes = ellipses(covariances, level)
    default = _magnification(trace, shapes)
    times = default if magnify is None else check_float("magnify", magnify, exclusive_minimum=0.0)
    ax = style.panel(ax, (7, 7))
    fits = _fits(trace, times * shapes)
    is_missed = _squared_distances(trace, rows)[fits] > _squared_radius(level)
    corners = (positions[:, np.newaxis] + times * shapes)[fits]
    name = f"{100 * level:g} % ellipse"
    for chosen, color, label in (
        (~is_missed, style.ESTIMATED, name),
        (is_missed, style.WRONG, "it misses the truth"),
    ):
        if chosen.any():
            ax.add_collection(_polygons(corners[chosen], color, label), autolim=True)
    _draw_paths(ax, trace, rows)
    ax.set_title(_title(trace, is_missed, times), loc="left", wrap=True)
    _finish(ax, trace.info.unit)
    return ax


def ellipses(covariances: Floats, level: float) -> Floats:
    """Return corners (N, 48, 2) of ellipses around 0 that contain the fraction `level`.

    It is for normal distributions; `covariances` (N, 2, 2) with a negative eigenvalue raise
    ValueError.
    """
    eigenvalues, axes = np.linalg.eigh(covariances)
    if (eigenvalues[:, 0] < -1e-9 * eigenvalues[:, 1]).any():
        minimum = eigenvalues[:, 0].min()
        raise ValueError(f"covariance must be positive definite, got the eigenvalue {minimum:g}")
    radius = math.sqrt(_squared_radius(level))
    angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    circle = radius * np.column_stack((np.cos(angle), np.sin(angle)))
    # semi-axes: radius sqrt(eigenvalues)
    scaled = axes * np.sqrt(np.maximum(eigenvalues, 0.0))[:, np.newaxis, :]
    corners: Floats = circle @ np.swapaxes(scaled, 1, 2)
    return corners


def _squared_radius(level: float) -> float:
    """Return the quantile of the chi-square distribution with 2 degrees of freedom."""
    return -2.0 * math.log1p(-level)


def _squared_distances(trace: Trace, rows: NDArray[np.int64]) -> Floats:
    """Return e' P^-1 e of the positions (n,); NaN where the truth is not known."""
    error = trace.pose_estimated[rows, :2] - trace.pose_true[rows, :2]
    inverse = np.linalg.pinv(trace.covariance[rows, :2, :2], hermitian=True)
    distances: Floats = np.einsum("ki,kij,kj->k", error, inverse, error)
    return distances


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


def _polygons(corners: Floats, color: str, label: str) -> PolyCollection:
    return PolyCollection(
        list(corners), facecolor=(*to_rgb(color), 0.15), edgecolor=color, linewidth=0.9, label=label
    )


def _title(trace: Trace, is_missed: NDArray[np.bool_], times: float) -> str:
    count = f"{len(is_missed)} ellipse{'' if len(is_missed) == 1 else 's'}"
    parts = [count, "" if times == 1.0 else f"drawn {times:g} times as large"]
    if np.isfinite(trace.pose_true).any():
        missed = np.count_nonzero(is_missed)
        verb = "misses" if len(is_missed) == 1 else "miss"
        parts[0] = f"{missed} of {count} {verb} the true position"
    return ", ".join(part for part in parts if part)


def _draw_paths(ax: Axes, trace: Trace, rows: NDArray[np.int64]) -> None:
    estimated, true = trace.pose_estimated[:, :2], trace.pose_true[:, :2]
    dot: dict[str, Any] = {"marker": style.line_marker(len(trace)), "markersize": 8}
    if np.isfinite(true).any():
        ax.plot(*true.T, color=style.TRUE, linewidth=2.0, label="true path", **dot)
    ax.plot(*estimated.T, color=style.ESTIMATED, linewidth=0.8, label="estimated path")
    ax.plot(*estimated[rows].T, ".", color=style.ESTIMATED, markersize=4)


def _finish(ax: Axes, unit: str) -> None:
    x, y = style.position_labels(unit)
    ax.set(xlabel=x, ylabel=y)
    ax.autoscale_view()
    ax.set_aspect("equal", adjustable="datalim")
    if not ax.yaxis_inverted():
        ax.invert_yaxis()
    style.legend_below(ax, ncols=4)


@style.applied
def plot_consistency(report: ConsistencyReport, *, ax: Axes | None = None) -> Axes:
    """Draw the NEES or the NIS over the steps with its chi-square band.

    The axis is logarithmic, since the values of an inconsistent filter may be wrong by orders of
    magnitude. A filter with values above the band is optimistic, and a filter with values below the
    band is conservative.

    Parameters
    ----------
    report : ConsistencyReport
        From `pose_consistency`, `nees_consistency` or `nis_consistency`.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in. Default: a new figure of 8 x 3.2 inches.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    TypeError
        If `report` is not a ConsistencyReport.

    Examples
    --------
    >>> error = np.random.default_rng(1).normal(size=(50, 100, 3))
    >>> report = robsim.estimation.nees_consistency(error, np.eye(3))
    >>> axes = robsim.plotting.plot_consistency(report)
    >>> axes.get_xlabel()
    'step k'
    """
    check_source("report", report, ConsistencyReport)
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
    ax.set_title(report.headline, loc="left")
    style.enlarge_marks(ax.legend(loc="upper left", bbox_to_anchor=(1, 1)))
    style.rasterize_long_lines([ax])
    return ax
