"""What marks promise: `./run study marks` draws notebooks/site/marks.png and prints its numbers.

All solutions of a task, right and wrong ones, are run in tests as they are graded: what these come
to, how many points that gives, and how well more runs tell right from wrong.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import scipy.stats
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

import robsim
from robsim.plotting import style as style
from robsim.teach import ScoreLimit, Task
from robsim.teach.tasks.marks.calibrate import PILOT_TESTS, WRONG_TESTS
from robsim.teach.tasks.marks.limits import bound_rank, fewest_values, limits_from
from robsim.teach.tasks.marks.sets import Runs, Sets, runs_of, sets_of
from robsim.teach.tasks.solutions import REFERENCE

FIGURE = Path(__file__).parents[1] / "notebooks/site/marks.png"
TASK, SEED = "estimate", 1
FALSE_FAIL, CONFIDENCE = 0.01, 0.95
#: How many runs a test may have.
RUNS = (1, 2, 5, 10)

RIGHT, WRONG, LIMIT = style.ESTIMATED, style.WRONG, style.MEASURED
_JITTER = 0.28  # of a row


@dataclass(frozen=True)
class Tests:
    """Tests of so many runs of all solutions of a task.

    Attributes
    ----------
    task : Task
        The task, with that many runs.
    runs : mapping of str to Runs
        The runs of each solution.
    rate : float
        How often a right solution may fail.
    """

    task: Task
    runs: Mapping[str, Runs]
    rate: float

    @cached_property
    def sets(self) -> dict[str, Sets]:
        """Of each solution what its tests come to."""
        reference = self.runs[REFERENCE]
        return {
            name: sets_of(self.task, own, reference.first(len(own.failed)))
            for name, own in self.runs.items()
        }

    @cached_property
    def limits(self) -> dict[str, ScoreLimit]:
        """The limits, from as many tests as there are."""
        right, wrong = (
            [self.sets[one.name] for one in self.task.solutions if one.is_right == is_right]
            for is_right in (True, False)
        )
        rank = bound_rank(len(right[0].through) - PILOT_TESTS, self.rate, CONFIDENCE)
        return limits_from(self.task, right, wrong, PILOT_TESTS, rank)

    def points(self, solution: str) -> Any:
        """Return the share of the points of each test."""
        return self.sets[solution].points(self.task.scores, self.limits)

    def failing(self, solution: str) -> float:
        """Return the share of the tests with less than full points (%)."""
        return 100 * float(np.mean(self.points(solution) < 1 - 1e-9))


def graded(
    task: Task, *, rate: float, executor: int | None = None, keep: Path | None = None
) -> dict[int, Tests]:
    """Run all solutions of a task, and return the tests by their number of runs."""
    count = PILOT_TESTS + fewest_values(rate, CONFIDENCE)
    runs: dict[str, Runs] = {}
    for is_right, tests in ((False, WRONG_TESTS), (True, count)):
        runs |= runs_of(
            task,
            [one for one in task.solutions if one.is_right == is_right],
            tests,
            seed=SEED,
            executor=executor,
            store=keep and keep / f"{'right' if is_right else 'wrong'}.sqlite",
        )
    counts = [n for n in RUNS if n <= task.runs]
    return {n: Tests(replace(task, runs=n), runs, rate) for n in counts}


@style.applied
def figure_of(found: Mapping[int, Tests]) -> Figure:
    """Return the figure."""
    figure = style.NotebookFigure(figsize=(8.6, 7.6))
    (statistics, points), (power, promise) = figure.subplots(2, 2)
    most = found[max(found)]
    _draw_statistics(statistics, most)
    _draw_points(points, most)
    _draw_power(power, found)
    _draw_promise(promise, most.rate)
    return figure


def _draw_statistics(axes: Axes, tests: Tests) -> None:
    score = tests.task.scores[0]
    limit = tests.limits[score.name]
    for row, one in enumerate(tests.task.solutions):
        _strip(axes, row, tests.sets[one.name].statistics[:, 0], is_right=one.is_right)
    axes.axvline(limit.full, color=LIMIT, linewidth=1.5, label="full points up to here")
    axes.axvline(limit.zero, color=style.GUIDE, linewidth=1.5, label="none from here")
    _name_rows(axes, tests.task)
    axes.set(xscale="log", xlabel=f"{score.title}, times the reference's")
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(LogFormatter(labelOnlyBase=False, minor_thresholds=(2, 0.5)))
    axes.legend(loc="upper right", facecolor="white", framealpha=0.9, frameon=True)
    axes.set_title(f"A  one score, in tests of {tests.task.runs} runs", loc="left")


def _draw_points(axes: Axes, tests: Tests) -> None:
    for row, one in enumerate(tests.task.solutions):
        _strip(axes, row, 100 * tests.points(one.name), is_right=one.is_right)
        axes.text(103, row, f"{tests.failing(one.name):.3g} %", va="center", fontsize=8.5)
    _name_rows(axes, tests.task)
    axes.set(xlim=(-3, 122), xlabel="points of a test (%); at the right: tests below 100")
    axes.set_xticks(range(0, 101, 20))
    axes.set_title("B  points, all scores together", loc="left")


def _strip(axes: Axes, row: int, values: Any, *, is_right: bool) -> None:
    """Draw a row of values, each a dot."""
    spread = np.random.default_rng(row).uniform(-_JITTER, _JITTER, len(values))
    color = RIGHT if is_right else WRONG
    axes.plot(values, row + spread, ".", markersize=2.5, color=color, alpha=0.5)


def _name_rows(axes: Axes, task: Task) -> None:
    names = [one.name.replace("_", " ") for one in task.solutions]
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    for label, one in zip(axes.get_yticklabels(), task.solutions, strict=True):
        label.set_color(RIGHT if one.is_right else WRONG)


def _draw_power(axes: Axes, found: Mapping[int, Tests]) -> None:
    counts = list(found)
    for one in found[counts[0]].task.solutions:
        failing = [found[n].failing(one.name) for n in counts]
        color = RIGHT if one.is_right else WRONG
        axes.plot(counts, failing, ".-", color=color, linewidth=1, markersize=5)
    axes.axhline(95, color=style.GUIDE, linewidth=1)
    axes.set(xscale="log", xlabel="runs of a test", ylabel="tests with less than all points (%)")
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    axes.set_title("C  more runs tell right (blue) from wrong (red)", loc="left")


def _draw_promise(axes: Axes, rate: float) -> None:
    rates = np.linspace(0, 2.5 * rate, 400)
    fewest = fewest_values(rate, CONFIDENCE)
    for tests, color in ((fewest, RIGHT), (2 * fewest, style.BATCH), (7 * fewest, style.TRUE)):
        rank = bound_rank(tests, rate, CONFIDENCE)
        # the true rate of the r-th largest of n is distributed as Beta(r, n - r + 1)
        density = scipy.stats.beta(rank, tests - rank + 1).pdf(rates) / 100
        which = "the largest" if rank == 1 else f"number {rank} from above"
        axes.plot(100 * rates, density, color=color, label=f"{tests} tests: {which}")
    axes.axvline(100 * rate, color=WRONG, linewidth=1)
    axes.set(xlabel="true rate at which a right solution fails (%)", ylabel="density (1 / %)")
    axes.set(xlim=(0, 250 * rate), ylim=(0, None))
    axes.set_ylim(0, 1.3 * axes.get_ylim()[1])  # room for the legend
    axes.legend(facecolor="white", framealpha=0.9, frameon=True)
    axes.set_title("D  true rates, and the promised one", loc="left")


def table(found: Mapping[int, Tests]) -> str:
    """Return the numbers: limits, and for each solution how many tests are below full points."""
    most = found[max(found)]
    lines = [
        f"{name}: full up to {limit.full:.3g}, none from {limit.zero:.3g}"
        + ("" if limit.low is None else f", full from {limit.low:.3g}")
        for name, limit in most.limits.items()
    ]
    lines.append(
        f"{'tests below full points (%), of runs:':40}" + "".join(f"{n:>8}" for n in found)
    )
    for one in most.task.solutions:
        kind = "right" if one.is_right else "wrong"
        cells = "".join(f"{tests.failing(one.name):8.3g}" for tests in found.values())
        lines.append(f"  {kind} {one.name:32}{cells}")
    return "\n".join(lines)


def main() -> int:
    """Run the solutions, draw the figure, print the numbers."""
    parser = argparse.ArgumentParser(prog="./run study marks", description=__doc__.split("\n")[0])
    parser.add_argument("--task", default=TASK, choices=robsim.teach.TASKS, help=f"default: {TASK}")
    parser.add_argument("--false-fail", type=float, default=FALSE_FAIL, help="default: 0.01")
    parser.add_argument("--jobs", type=int, help="processes; default: this one")
    parser.add_argument("--keep", type=Path, help="keep what is done in this folder, and go on")
    parser.add_argument("--out", type=Path, default=FIGURE, help="the figure; default: the page's")
    given = parser.parse_args()
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
    task = robsim.teach.task(given.task)
    found = graded(task, rate=given.false_fail, executor=given.jobs, keep=given.keep)
    print(table(found))
    from draw_readme import picture

    picture(figure_of(found)).save(given.out, optimize=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
