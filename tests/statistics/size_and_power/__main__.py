"""``python -m size_and_power``: prints the table, and writes it."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from size_and_power.table import as_json, as_markdown, family_names, measured


def main() -> int:
    """Return 1 if a promise does not hold, 0 otherwise."""
    parser = argparse.ArgumentParser(prog="./run study statistics", description=__doc__)
    parser.add_argument(
        "--trials", type=int, default=1000, help="default: 1000; fewer of what takes long"
    )
    parser.add_argument("--seed", type=int, default=0, help="what all seeds come from; default: 0")
    parser.add_argument("--only", nargs="+", choices=family_names(), default=family_names())
    parser.add_argument("--out", type=Path, help="write table.md and table.json to this folder")
    parser.add_argument(
        "--keep", type=Path, help="keep the trials in this folder, as SQLite files, and go on"
    )
    parser.add_argument("--jobs", type=int, help="processes; default: one for each core")
    given = parser.parse_args()
    rows = measured(
        given.trials,
        given.only,
        seed=given.seed,
        executor=given.jobs or len(os.sched_getaffinity(0)),
        keep=given.keep,
    )
    print(as_markdown(rows), end="")
    if given.out:
        given.out.mkdir(parents=True, exist_ok=True)
        (given.out / "table.md").write_text(as_markdown(rows))
        (given.out / "table.json").write_text(as_json(rows))
    return 0 if all(row.holds for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
