"""What the limits of the shipped tasks promise, by tests on fresh runs: a table.

    python tests/support/grading_promises.py --graded 1000 --jobs 2

Each right solution of each task is graded so many times: it may have less than full points as
rarely as its calibration says. Each wrong one is to have less in at least 95 % of 200 tests.
"""

import argparse
import os
import sys
from dataclasses import dataclass
from pathlib import Path

from scipy.stats import binomtest

from robsim.teach import TASKS, SolutionMarks, task
from robsim.teach.tasks.marks import calibrate, calibration, sets
from robsim.teach.tasks.marks import calibration as files
from robsim.teach.tasks.marks import limits as tolerance

__all__ = ["calibration", "files", "promises", "tolerance"]

#: So improbable a number of failures does not come about by chance.
IMPROBABLE = 1e-3


@dataclass(frozen=True)
class Promise:
    """What was promised of a solution, and what came."""

    task: str
    marks: SolutionMarks
    false_fail: float

    @property
    def holds(self):
        """Whether what came is compatible with what was promised."""
        failing, tests = self.marks.failing, self.marks.tests
        if self.marks.is_right:
            promised, side = self.false_fail, "greater"
        else:
            promised, side = calibration.POWER, "less"
        return bool(binomtest(failing, tests, promised, alternative=side).pvalue > IMPROBABLE)

    @property
    def row(self):
        """A row of the table."""
        marks = self.marks
        low, high = (100 * share for share in marks.rate_interval)
        kind = "right" if marks.is_right else "wrong"
        promised = f"<= {self.false_fail:.1%}" if marks.is_right else f">= {calibration.POWER:.0%}"
        return (
            f"| {self.task} | {marks.name} | {kind} | {promised} | {marks.failing} of {marks.tests}"
            f" | {low:.1f} to {high:.1f} % | {marks.points:.0%} | {'yes' if self.holds else 'NO'} |"
        )


HEAD = (
    "| task | solution | is | fails, promised | fails | 95 % | median points | holds |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- |"
)


def promises(shipped, *, graded, graded_wrong, keep=None, **options):
    """Grade the solutions of a task anew, and return what came of each."""
    one = task(shipped.task, **shipped.parameters)
    reference = one.solutions[0]
    promised = []
    for is_right, tests in ((True, graded), (False, graded_wrong)):
        chosen = [solution for solution in one.solutions if solution.is_right == is_right]
        store = keep and keep / f"{one.name}-{'right' if is_right else 'wrong'}.sqlite"
        asked = chosen if is_right else [reference, *chosen]
        runs = sets.runs_of(one, asked, tests, store=store, **options)
        for solution in chosen:
            found = sets.sets_of(one, runs[solution.name], runs[reference.name])
            marks = calibrate.marks_of(one, solution, found, dict(shipped.limits))
            promised.append(Promise(one.name, marks, shipped.false_fail))
    return promised


def main():
    """Print the table; return 1 if a promise does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--graded", type=int, default=1000, help="of each right one; default: 1000")
    parser.add_argument("--graded-wrong", type=int, default=200, help="default: 200")
    parser.add_argument("--only", nargs="+", choices=list(TASKS), default=list(TASKS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, help="processes; default: one for each core")
    parser.add_argument("--keep", type=Path, help="folder for the runs, to go on later")
    given = parser.parse_args()
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
    print(HEAD)
    broken = False
    options = {
        **{"graded": given.graded, "graded_wrong": given.graded_wrong, "seed": given.seed},
        **{"executor": given.jobs or len(os.sched_getaffinity(0)), "keep": given.keep},
    }
    for name in given.only:
        shipped = files.shipped_calibrations()[name]
        found = promises(shipped, **options, progress=sys.stderr.isatty())
        print(*(promise.row for promise in found), sep="\n", flush=True)
        broken |= not all(promise.holds for promise in found)
    return int(broken)


if __name__ == "__main__":
    sys.exit(main())
