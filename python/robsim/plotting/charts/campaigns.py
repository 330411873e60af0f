"""`plot_campaign`: a number of a campaign over a swept option, or its spread in each case."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.axes import Axes

from robsim.base.checks import check_choice
from robsim.base.report import percent
from robsim.base.text import listed, no_formula, quoted
from robsim.campaigns import CampaignResult
from robsim.plotting import style as style
from robsim.plotting.style import check_source

_COLORS = (
    *(style.ESTIMATED, style.BATCH, style.MEASURED, style.TRUE),
    *(style.WRONG, style.BOUND, style.FITTED),
)
_MARKS = "os^Dv<>"
_MOST_PAIRS = 100  # runs whose pairs are drawn
_MOST_LETTERS = 70  # of labels that stand side by side
_LEVEL = 0.95


@style.applied
def plot_campaign(
    result: CampaignResult, metric: str, *, over: str | None = None, ax: Axes | None = None
) -> Axes:
    """Draw a number of a campaign.

    With `over`, the chart shows the mean of the number against the values of an option, with a band
    for the 95 % confidence interval. Each combination of the other options has a line. Without
    `over`, each case has a box with the median and the quartiles; grey lines join the runs with the
    same seed.

    Parameters
    ----------
    result : CampaignResult
        From `robsim.campaign`.
    metric : str
        One of ``result.metrics``.
    over : str, optional
        An option with numbers as labels.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in. Default: a new figure of 6 x 3.6 inches.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    TypeError, ValueError
        If `result` is not a CampaignResult, has no such metric or option, or has only failed runs.
        If the labels of the option are no numbers.

    Examples
    --------
    >>> result = robsim.campaign(
    ...     robsim.Scenario(area=(300, 300), start="random", measure=True),
    ...     vary={"noise": {0: None, 10: robsim.GaussianNoise(10)}},
    ...     metrics="tracking", runs=3, steps=10, seed=1, executor=1, progress=False,
    ... )
    >>> axes = robsim.plotting.plot_campaign(result, "tracking_rmse_xy", over="noise")
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('noise', 'tracking_rmse_xy')
    """
    check_source("result", result, CampaignResult)
    if not result.metrics:
        raise ValueError("result has no numbers to draw: all runs failed; see print(result)")
    check_choice("metric", metric, result.metrics)
    if over is not None:
        check_choice("over", over, tuple(result.spec.vary))
        if result[over].dtype.kind not in "iuf":
            raise ValueError(
                f"`over` must be an option with numbers as labels, got {quoted(over)} with the "
                f"labels {listed(map(str, result.spec.vary[over]))}; to give labels, use a dict in "
                "vary, such as {10: robsim.GaussianNoise(10), 20: ...}"
            )
    ax = style.panel(ax, (6, 3.6))
    if over is None:
        _draw_boxes(ax, result, metric)
    else:
        _draw_bands(ax, result, metric, over)
    ax.set_ylabel(no_formula(metric))
    ax.set_title(f"{len(result.spec.cases)} x {result.spec.runs} runs", loc="left")
    return ax


def _draw_bands(ax: Axes, result: CampaignResult, metric: str, over: str) -> None:
    vary = result.spec.vary
    others = [name for name in vary if name != over and len(vary[name]) > 1]
    summary = result.summary((*others, over), metrics=metric, level=_LEVEL)
    at = {group: place for place, group in enumerate(summary.groups)}
    x = sorted(vary[over])
    looks = itertools.cycle(zip(_COLORS, _MARKS, strict=True))
    for labels, (color, mark) in zip(
        itertools.product(*(vary[name] for name in others)), looks, strict=False
    ):
        rows = [at[", ".join(map(str, (*labels, value)))] for value in x]
        mean, half = summary.mean[rows, 0], summary.half_width[rows, 0]
        name = ", ".join(map(str, labels)) or "mean"
        ax.plot(x, mean, f"{mark}-", color=color, markersize=4, label=no_formula(name))
        ax.fill_between(x, mean - half, mean + half, color=color, alpha=0.2, linewidth=0)
    ax.set_xlabel(no_formula(over))
    title = "\n".join(filter(None, (", ".join(others), f"mean, {percent(_LEVEL, 0)} band")))
    ax.legend(loc="upper left", bbox_to_anchor=(1, 1), title=title)


def _draw_boxes(ax: Axes, result: CampaignResult, metric: str) -> None:
    cases, runs = len(result.spec.cases), result.spec.runs
    numbers = result[metric].reshape(cases, runs)
    places = np.arange(cases)
    if runs <= _MOST_PAIRS:
        ax.plot(places, numbers, color=style.GUIDE, linewidth=0.4, alpha=0.6, zorder=1)
    ax.boxplot(
        [case[np.isfinite(case)] for case in numbers],
        positions=places,
        widths=0.4,
        medianprops={"color": style.ESTIMATED, "linewidth": 1.5},
        flierprops={"marker": ".", "markersize": 4, "markerfacecolor": style.FITTED},
    )
    labels = ["\n".join(map(no_formula, case.labels.values())) for case in result.spec.cases]
    widest = max(len(line) for label in labels for line in label.split("\n"))
    if widest * cases <= _MOST_LETTERS:
        ax.set_xticks(places, labels)
    else:
        labels = [label.replace("\n", ", ") for label in labels]
        ax.set_xticks(places, labels, rotation=30, ha="right", rotation_mode="anchor")
    ax.set_xlabel(no_formula(", ".join(result.spec.vary)))
