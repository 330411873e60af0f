"""Puts deliberate faults into robsim, one at a time, and prints which tests catch them.

Some are named; as many again, for each language, are drawn by a seed from the syntax trees, half of
them in lines of --lines. What was done is kept in --out: the same command goes on. --before tries
faults that are not caught by the tests of another tree, too.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from pathlib import Path

from mutants.draw import drawn
from mutants.fault import Fault
from mutants.trial import Bench

ROOT = Path(__file__).parents[3]


def main() -> None:
    parser = argparse.ArgumentParser(prog="./run study mutants", description=__doc__)
    parser.add_argument("--seed", type=int, default=36, help="of the draw")
    parser.add_argument("--faults", type=int, default=15, help="drawn of each of four groups")
    parser.add_argument(
        "--lines", type=Path, nargs="+", default=[], help="JSON reports of coverage.py and gcovr"
    )
    parser.add_argument("--before", type=Path, help="another tree, whose tests are tried as well")
    parser.add_argument("--tests", type=Path, default=ROOT, help="the tree of the tests")
    parser.add_argument("--out", type=Path, default=ROOT / "build/mutants/faults.json")
    given = parser.parse_args()
    bench = Bench(ROOT, ROOT / "build/mutants")
    bench.prepare()
    done = json.loads(given.out.read_text()) if given.out.exists() else []
    known = {(one["file"], one["start"], one["new"]): one for one in done}
    groups: Counter[str] = Counter()
    for group, fault in drawn(ROOT, given.seed, 10 * given.faults, given.lines):
        if group != "by name" and groups[group] == given.faults:
            continue
        one = known.get((fault.file, fault.start, fault.new))
        if one is None:
            one = tried(bench, group, fault, given.tests)
            done.append(one)
        if given.before and one["built"] and not one["caught"] and one["before"] is None:
            one["before"] = tried(bench, group, fault, given.before)["caught"]
        given.out.write_text(json.dumps(done, indent=1))
        if one["built"]:
            groups[group] += 1
            print(f"{one['caught'] or 'NOT CAUGHT'} | {fault.about}", flush=True)
            if one["before"] is not None:
                print(f"    before: {one['before'] or 'NOT CAUGHT'}", flush=True)
    show([one for one in done if one["built"]])


def tried(bench: Bench, group: str, fault: Fault, tests: Path) -> dict:
    """Put a fault in, try it, take it out; return what came of it as plain data."""
    begin = time.monotonic()
    caught = None
    fault.put_into(bench.tree)
    try:
        built = bench.build() is None
        if built:
            caught = bench.caught_by(tests, fault)
    finally:
        bench.restore(fault.file)
    seconds = round(time.monotonic() - begin)
    return {
        **fault.record(),
        **{"group": group, "built": built, "caught": caught or "", "before": None},
        "seconds": seconds,
    }


def show(done: list[dict]) -> None:
    """Print how many were caught, by group."""
    for group in dict.fromkeys(one["group"] for one in done):
        of_it = [one for one in done if one["group"] == group]
        caught = sum(bool(one["caught"]) for one in of_it)
        lost = sum(bool(one["before"]) for one in of_it)
        print(f"{group:<32}{caught:>4} of {len(of_it)} caught, {lost} only by the tests before")


if __name__ == "__main__":
    main()
