"""Each template made into an assignment of its own, with its limits, and checked: a table.

    python tests/support/template_checks.py --jobs 2

It takes some ten minutes a template: limits of 299 tests of each right solution, and a class of all
solutions and what is hostile.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from contextlib import nullcontext
from pathlib import Path

from robsim.assignments import calibrate_assignment, check_assignment, new_assignment
from robsim.assignments._making.template import TEMPLATES

HEAD = "| template | made in | checked in | checked | problems |\n| --- | --- | --- | --- | --- |"


def main() -> int:
    """Print a row for each template, and what is wrong; return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=list(TEMPLATES), default=list(TEMPLATES))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--false-fail", type=float, default=0.01, help="default: 0.01")
    parser.add_argument("--jobs", type=int, default=2, help="processes; default: 2")
    parser.add_argument("--keep", type=Path, help="folder for the assignments, to look at")
    given = parser.parse_args()
    jobs = given.jobs if given.jobs > 1 else None
    print(HEAD, flush=True)
    problems = []
    with tempfile.TemporaryDirectory() if given.keep is None else nullcontext(given.keep) as place:
        for template in given.only:
            folder = Path(place) / template
            start = time.monotonic()
            new_assignment(template, folder, seed=given.seed)
            calibrate_assignment(folder, false_fail=given.false_fail, executor=jobs, progress=False)
            made = time.monotonic()
            found = check_assignment(folder, executor=jobs, progress=False)
            checked = time.monotonic()
            print(
                f"| {template} | {(made - start) / 60:.1f} min | {(checked - made) / 60:.1f} min "
                f"| {len(found.tables[0].rows)} | {len(found.problems)} |",
                flush=True,
            )
            problems += [f"{template}: {one.sentence}" for one in found.problems]
    print(*problems, sep="\n")
    return bool(problems)


if __name__ == "__main__":
    sys.exit(main())
