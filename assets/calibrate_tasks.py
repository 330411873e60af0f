"""Calibrates the limits of the tasks that ship with robsim: python/robsim/teach/tasks/limits.json.

``./run study limits``. It takes some minutes a task; it says before how many.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from robsim.teach import TASKS, calibrate_task, task
from robsim.teach.tasks.marks.calibrate import calibration_seconds
from robsim.teach.tasks.marks.calibration import read_calibrations, write_calibrations

FILE = Path(__file__).parents[1] / "python/robsim/teach/tasks/limits.json"

#: Of the shipped limits: everybody knows them, as public tests have them.
SEED = 20261125
PROMISE = {"false_fail": 0.01, "confidence": 0.95, "provisional": False}


def main() -> int:
    """Calibrate, print what each solution comes to, and return 1 if a wrong one often passes."""
    parser = argparse.ArgumentParser(prog="./run study limits", description=__doc__)
    parser.add_argument("--only", nargs="+", choices=list(TASKS), default=list(TASKS))
    parser.add_argument("--jobs", type=int, help="processes; default: one for each core")
    parser.add_argument("--keep", type=Path, help="folder for the runs, to go on later")
    given = parser.parse_args()
    jobs = given.jobs or len(os.sched_getaffinity(0))
    known = read_calibrations(FILE) if FILE.exists() else {}
    passed = False
    for name in given.only:
        one = task(name)
        options = {"seed": SEED, "store": given.keep and given.keep / name}
        seconds = calibration_seconds(one, one.solutions, jobs, **PROMISE, **options)
        print(f"{name}: about {seconds / 60:.0f} min", file=sys.stderr, flush=True)
        calibration = calibrate_task(one, executor=jobs, **PROMISE, **options)
        print(calibration, end="\n\n", flush=True)
        known[name] = calibration
        write_calibrations(FILE, known)
        passed |= bool(calibration.missed)
    print(f"written: {FILE}", file=sys.stderr)
    return int(passed)


if __name__ == "__main__":
    sys.exit(main())
