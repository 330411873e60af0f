"""Points by provisional and by exact limits: `./run study provisional` prints how far these differ.

Each task is drawn as `robsim assignment new` draws it, and calibrated in both ways. Submissions are
tests of right solutions, of wrong ones, and of blends: geometric means of a right one's numbers and
a wrong one's, by a weight. With --keep it continues an ended one.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from robsim.base.checks import Floats
from robsim.teach import TASKS, Task
from robsim.teach.assignments.making import draw
from robsim.teach.tasks.marks import calibrate
from robsim.teach.tasks.marks.limits import (
    bound_rank,
    fewest_values,
    limits_from,
)
from robsim.teach.tasks.marks.sets import Runs, Sets, runs_of, sets_of, with_drawn
from robsim.teach.tasks.solutions import REFERENCE

FALSE_FAIL, CONFIDENCE = 0.01, 0.95
SUBMISSIONS = 200


def played(
    task: Task, seed: int, jobs: int | None, keep: Path | None
) -> dict[bool, dict[str, Runs]]:
    """Return the runs of the right, and of the wrong solutions, as calibrations have them."""
    tests = {True: calibrate.PILOT_TESTS + fewest_values(FALSE_FAIL, CONFIDENCE)}
    tests[False] = calibrate.WRONG_TESTS
    runs: dict[bool, dict[str, Runs]] = {}
    for is_right in (True, False):
        some = [one for one in task.solutions if one.is_right == is_right]
        file = keep and keep / f"{'right' if is_right else 'wrong'}.sqlite"
        runs[is_right] = runs_of(
            task, some, tests[is_right], seed=seed, executor=jobs, store=file, progress=True
        )
    return runs


def compared(task: Task, runs: dict[bool, dict[str, Runs]], seed: int) -> Floats:
    """Return the points of submissions, (N, 2), by exact and by provisional limits, of 100."""
    reference = runs[True][REFERENCE]
    right, wrong = (
        [sets_of(task, one, reference) for one in runs[kind].values()] for kind in (True, False)
    )
    first = reference.first(calibrate.RIGHT_TESTS * task.runs)
    count = calibrate.DRAWN // task.runs
    drawn = [
        with_drawn(task, one.first(len(first.failed)), first, count, seed)
        for one in runs[True].values()
    ]
    above = count * np.log(2) / fewest_values(FALSE_FAIL, CONFIDENCE)
    of_drawn = calibrate.RIGHT_TESTS, round(above)
    rank = bound_rank(fewest_values(FALSE_FAIL, CONFIDENCE), FALSE_FAIL, CONFIDENCE)
    exact = limits_from(task, right, wrong, calibrate.PILOT_TESTS, rank)
    (fewest, _), *stages = calibrate.STAGES
    few = [one[:fewest] for one in wrong]
    quick = limits_from(task, drawn, few, *of_drawn)
    for number, least in stages:
        few = [
            one[:number] if calibrate.is_needed(task, those, quick, least) else those
            for one, those in zip(wrong, few, strict=True)
        ]
        quick = limits_from(task, drawn, few, *of_drawn)
    tests = submissions(right, wrong, seed)
    return 100 * np.stack([tests.points(task.scores, one) for one in (exact, quick)], axis=1)


def submissions(right: list[Sets], wrong: list[Sets], seed: int) -> Sets:
    """Return tests of submissions: right, wrong, and two blends, in turn."""
    rng = np.random.default_rng(seed)
    statistics, through = [], []
    for number in range(SUBMISSIONS):
        good, bad = (some[rng.integers(len(some))] for some in (right, wrong))
        test = rng.integers(len(bad.through))
        weight = (0.0, 1.0, rng.uniform(), rng.uniform(0, 0.3))[number % 4]
        logs = [np.log(one.statistics[test]) for one in (good, bad)]
        statistics.append(np.exp(np.average(logs, axis=0, weights=(1 - weight, weight))))
        through.append(bad.through[test] if weight else 1.0)
    return Sets(np.array(statistics), np.array(through))


def main() -> int:
    """Print the differences; return 1 if one of a task is above 3 of 100."""
    parser = argparse.ArgumentParser(prog="./run study provisional", description=__doc__)
    parser.add_argument("--only", nargs="+", choices=list(TASKS), default=list(TASKS))
    parser.add_argument("--seed", type=int, default=1, help="of the drawn numbers and the runs")
    parser.add_argument("--jobs", type=int, help="processes")
    parser.add_argument("--keep", type=Path, help="folder for the runs, to go on later")
    given = parser.parse_args()
    worst = 0.0
    for name in given.only:
        task = draw(name, np.random.default_rng(given.seed))
        keep = given.keep and given.keep / name
        if keep:
            keep.mkdir(parents=True, exist_ok=True)
        points = compared(task, played(task, given.seed, given.jobs, keep), given.seed)
        off = np.abs(points[:, 1] - points[:, 0])
        is_between = (points[:, 0] > 0) & (points[:, 0] < 100)
        print(
            f"{name}: points of {SUBMISSIONS} submissions, {is_between.sum()} of them between 0 "
            f"and 100, differ by {off.max():.1f} of 100 at most, {np.mean(off > 3):.0%} by more "
            f"than 3; on average {off.mean():.2f}",
            flush=True,
        )
        worst = max(worst, off.max())
    return int(worst > 3)


if __name__ == "__main__":
    sys.exit(main())
