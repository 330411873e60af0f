"""What statistical marks promise: ./run marks draws notebooks/site/marks.png, prints its numbers.

Runs of all solutions of a task, right and wrong ones, in tests as they are graded: what these come
to, how many points that gives, how well more runs tell them apart.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.stats
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import robsim
from robsim.plotting import _style as style
from robsim.tasks import Limit, Score, Solution, Task

FIGURE = Path(__file__).parents[1] / "notebooks/site/marks.png"
TASK, SETS, SEED = "estimate", 299, 1
FALSE_FAIL, CONFIDENCE = 0.01, 0.95
#: How many runs a test may have, of which the most is that of the task.
RUNS = (1, 2, 5, 10)

RIGHT, WRONG, LIMIT = style.ESTIMATED, style.WRONG, style.MEASURED
_JITTER = 0.28  # of a row


@dataclass(frozen=True)
class Sets:
    """Runs of the solutions of a task, put together in sets.

    Attributes
    ----------
    task : Task
        The task.
    numbers : mapping of str to mapping of str to array (runs,)
        Of each solution the numbers of its runs, by score.
    """

    task: Task
    numbers: Mapping[str, Mapping[str, Any]]

    def statistics(self, solution: str, score: Score, runs: int) -> Any:
        """Return what sets of so many runs come to, (sets,)."""
        values, reference = (
            self.numbers[name][score.name].reshape(-1, runs) for name in (solution, "reference")
        )
        sets = zip(values, reference, strict=False)
        return np.array([score.statistic(one, other) for one, other in sets])

    def limits(self, runs: int) -> dict[str, Limit]:
        """Return the limits of a test of so many runs, by score."""
        return {score.name: self._limit(score, runs) for score in self.task.scores}

    def _limit(self, score: Score, runs: int) -> Limit:
        sides = sum(2 if one.kind == "consistency" else 1 for one in self.task.scores)
        rights = [s.name for s in self.task.solutions if s.is_right]
        found = [np.sort(self.statistics(name, score, runs)) for name in rights]
        rank = largest_rank(len(found[0]), FALSE_FAIL / sides, CONFIDENCE)
        naive = float(np.median(self.statistics("naive", score, runs)))
        full = max(float(one[-rank]) for one in found)
        if score.kind != "consistency":
            return Limit(full=full, zero=max(naive, full * 1.01))
        low = min(float(one[rank - 1]) for one in found)
        return Limit(full=full, zero=max(naive, full**2), low=low, low_zero=low**2)

    def points(self, solution: str, limits: Mapping[str, Limit], runs: int) -> Any:
        """Return the share of the points that each set gets, (sets,)."""
        shares = [
            score.share
            * np.array(
                [limits[score.name].fraction(s) for s in self.statistics(solution, score, runs)]
            )
            for score in self.task.scores
        ]
        return np.sum(shares, axis=0)


def largest_rank(n: int, rate: float, confidence: float) -> int:
    """Return the largest r such that the r-th largest of n values is a limit that keeps a rate."""
    # P(true rate of the r-th largest of n > rate) = P(Binomial(n, rate) < r) <= 1 - confidence
    ranks = np.arange(1, n + 1)
    kept = ranks[scipy.stats.binom.cdf(ranks - 1, n, rate) <= 1 - confidence]
    if not len(kept):
        raise ValueError(f"{n} sets are too few for a rate of {rate:g}")
    return int(kept[-1])


def runs_of(
    task: Task, *, sets: int, executor: int | None = None, keep: Path | None = None
) -> Sets:
    """Run all solutions of a task, as many times as so many sets of its runs take."""
    runs = sets * task.runs
    result = robsim.campaign(
        task.scenario,
        vary={"folder": {one.name: one.choice(task) for one in task.solutions}},
        metrics={"task": task.score},
        runs=runs,
        steps=task.steps,
        seed=SEED,
        executor=executor,
        store=keep,
    )
    numbers = {
        one.name: {
            score.name: result[f"task_{score.name}"][result["folder"] == one.name]
            for score in task.scores
        }
        for one in task.solutions
    }
    return Sets(task, numbers)


@style.applied
def figure_of(found: Sets) -> Figure:
    """Return the figure."""
    figure = style.NotebookFigure(figsize=(11.0, 7.4))
    (statistics, points), (power, promise) = figure.subplots(2, 2)
    most = max(RUNS)
    limits = found.limits(most)
    _draw_statistics(statistics, found, limits, most)
    _draw_points(points, found, limits, most)
    _draw_power(power, found)
    _draw_promise(promise)
    return figure


def _rows(axes: Axes, solutions: Sequence[Solution]) -> None:
    axes.set_yticks(range(len(solutions)), [one.name.replace("_", " ") for one in solutions])
    axes.set_ylim(len(solutions) - 0.5, -0.5)
    for label, one in zip(axes.get_yticklabels(), solutions, strict=True):
        label.set_color(RIGHT if one.is_right else WRONG)


def _strip(axes: Axes, row: int, values: Any, solution: Solution) -> None:
    """Draw a row of values, each a dot."""
    spread = np.random.default_rng(row).uniform(-_JITTER, _JITTER, len(values))
    color = RIGHT if solution.is_right else WRONG
    axes.plot(values, row + spread, ".", markersize=2.5, color=color, alpha=0.5)


def _draw_statistics(axes: Axes, found: Sets, limits: Mapping[str, Limit], runs: int) -> None:
    score = found.task.scores[0]
    limit = limits[score.name]
    for row, solution in enumerate(found.task.solutions):
        _strip(axes, row, found.statistics(solution.name, score, runs), solution)
    axes.axvline(limit.full, color=LIMIT, linewidth=1.5)
    axes.axvline(limit.zero, color=style.GUIDE, linewidth=1.5)
    _rows(axes, found.task.solutions)
    axes.set(xscale="log", xlabel=f"{score.title}: times the reference, {runs} runs together")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_title("A  what sets of runs come to, and both limits", loc="left")


def _draw_points(axes: Axes, found: Sets, limits: Mapping[str, Limit], runs: int) -> None:
    for row, solution in enumerate(found.task.solutions):
        points = 100 * found.points(solution.name, limits, runs)
        _strip(axes, row, points, solution)
        below = np.mean(points < 100)
        axes.text(103, row, f"{100 * below:.3g} %", va="center", fontsize=7.5)
    _rows(axes, found.task.solutions)
    axes.set(xlim=(-3, 118), xlabel="points (%); at the right: sets below full points")
    axes.set_xticks(range(0, 101, 20))
    axes.set_title("B  points, all scores together", loc="left")


def _draw_power(axes: Axes, found: Sets) -> None:
    for solution in found.task.solutions:
        below = [np.mean(found.points(solution.name, found.limits(n), n) < 1) for n in RUNS]
        color = RIGHT if solution.is_right else WRONG
        axes.plot(RUNS, 100 * np.array(below), ".-", color=color, linewidth=1, markersize=5)
    axes.axhline(95, color=style.GUIDE, linewidth=1)
    axes.set(xscale="log", xlabel="runs of a test", ylabel="sets below full points (%)")
    axes.set_xticks(RUNS, [str(n) for n in RUNS])
    axes.minorticks_off()
    axes.set_title("C  more runs tell right (blue) and wrong (red) apart", loc="left")


def _draw_promise(axes: Axes) -> None:
    rates = np.linspace(0, 2.5, 400)
    for sets, color in ((SETS, style.ESTIMATED), (2 * SETS - 1, style.BATCH), (2000, style.TRUE)):
        rank = largest_rank(sets, FALSE_FAIL, CONFIDENCE)
        # the true rate of the r-th largest of n is distributed as Beta(r, n - r + 1)
        density = scipy.stats.beta(rank, sets - rank + 1).pdf(rates / 100) / 100
        axes.plot(rates, density, color=color, label=f"{sets} sets: the {_ordinal(rank)} largest")
    axes.axvline(100 * FALSE_FAIL, color=WRONG, linewidth=1)
    axes.set(xlabel="true rate at which a right solution fails (%)", ylabel="density (1 / %)")
    axes.set(xlim=(0, rates[-1]), ylim=(0, None))
    axes.legend()
    axes.set_title("D  95 of 100 calibrations lie below 1 %", loc="left")


def _ordinal(number: int) -> str:
    return {1: "1st", 2: "2nd", 3: "3rd"}.get(number, f"{number}th")


def table(found: Sets) -> str:
    """Return the numbers: limits, and for each solution how many sets are below full points."""
    limits = found.limits(max(RUNS))
    lines = [
        f"{name}: full up to {limit.full:.3g}, none from {limit.zero:.3g}"
        + (f", full from {limit.low:.3g}" if limit.low is not None else "")
        for name, limit in limits.items()
    ]
    lines.append(f"{'sets below full points (%), runs:':36}" + "".join(f"{n:>8}" for n in RUNS))
    for one in found.task.solutions:
        below = [np.mean(found.points(one.name, found.limits(n), n) < 1) for n in RUNS]
        kind = "right" if one.is_right else "wrong"
        lines.append(f"  {kind} {one.name:28}" + "".join(f"{100 * x:8.3g}" for x in below))
    return "\n".join(lines)


def main() -> int:
    """Run the solutions, draw the figure, print the numbers."""
    parser = argparse.ArgumentParser(prog="./run marks", description=__doc__.split("\n")[0])
    parser.add_argument("--task", default=TASK, choices=robsim.tasks.TASKS, help=f"default: {TASK}")
    parser.add_argument("--sets", type=int, default=SETS, help=f"default: {SETS}")
    parser.add_argument("--jobs", type=int, help="processes; default: this one")
    parser.add_argument("--keep", type=Path, help="keep the runs in this file, and go on")
    parser.add_argument("--out", type=Path, default=FIGURE, help="the figure; default: the page's")
    given = parser.parse_args()
    task = robsim.tasks.task(given.task)
    found = runs_of(task, sets=given.sets, executor=given.jobs, keep=given.keep)
    print(table(found))
    from draw_readme import picture

    picture(figure_of(found)).save(given.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
