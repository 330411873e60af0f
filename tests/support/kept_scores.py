"""Scores of all solutions that ship, on fixed seeds.

``PYTHONPATH=tests/support python -m kept_scores tests/data/solutions.json`` compares them with
those of a file, bit by bit, or writes the file if it is not there.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from robsim.teach import TASKS, task, try_solution

SEED, RUNS = 7, 2


def scores_of(name: str) -> dict[str, Any]:
    """Return whether each solution of a task is right, its points, and its scores in each run."""
    one = task(name, runs=RUNS)
    found = {}
    for solution in one.solutions:
        trial = try_solution(one, solution, runs=RUNS, seed=SEED, progress=False)
        found[solution.name] = {
            "is_right": solution.is_right,
            "points": trial.points.hex(),
            "scores": {
                key: [value.hex() for value in values] for key, values in trial.values.items()
            },
        }
    return found


def main(path: Path) -> int:
    found = {name: scores_of(name) for name in TASKS}
    if not path.exists():
        path.write_text(json.dumps(found, indent=1, sort_keys=True) + "\n")
    kept = json.loads(path.read_text())
    other = [
        f"{name}/{solution}"
        for name in kept
        for solution in kept[name]
        if kept[name][solution] != found.get(name, {}).get(solution)
    ]
    count = sum(map(len, kept.values()))
    print(f"{count - len(other)} of {count} solutions have the same scores, bit by bit", *other)
    return bool(other)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
