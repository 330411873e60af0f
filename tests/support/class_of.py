"""A class of so many, graded: how long it takes, in how much memory, and what came of whom.

    python tests/support/class_of.py --students 300 --jobs 2
    python tests/support/class_of.py --students 1 --small

Four tests of ten runs, all hidden: to park, identify, estimate and measure, with the limits that
ship. Each student has handed in one of the solutions of each, drawn by a seed; one in fifty is
hostile. What is right may have less than all points as rarely as the calibration says.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path

from scipy.stats import binomtest

from robsim.assignments import Assignment, ClassResult
from robsim.assignments._checking.hostile import hostile_submissions
from robsim.grading import Key
from robsim.grading._isolation._processes.zygotes import close_zygotes
from robsim.tasks import Task, task
from robsim.tasks._marks.files import shipped_calibrations
from small_machine import small_machine

KINDS = ("park", "identify", "estimate", "measure")
_HOSTILE = 0.02  # of a class
_RIGHT = 0.5  # of what the others hand in
_SAMPLE = 2.0  # s


def assignment(folder: Path, tasks: Mapping[str, Task]) -> Assignment:
    """Write an assignment with a hidden test of each task, and the limits that ship."""
    folder.mkdir()
    slots = sorted({slot for one in tasks.values() for slot in one.slots})
    lines = ['name = "class"', 'title = "All at once"', f"slots = {json.dumps(slots)}"]
    lines += ['given = "frames"', "masked = []"]
    for kind in tasks:
        lines += ["[[tests]]", f'name = "{kind}"', f'task = "{kind}"', "points = 5"]
        lines += ["public = false"]
    (folder / "assignment.toml").write_text("\n".join(lines) + "\n")
    shipped = shipped_calibrations()
    limits = {kind: shipped[kind].to_dict() for kind in tasks}
    (folder / "limits.json").write_text(json.dumps({"format": 1, "tests": limits}))
    Key(b"one for all of these classes, not secret").write(folder / "key")
    return Assignment.load(folder)


def hand_in(
    folder: Path, students: int, tasks: Mapping[str, Task], slots: tuple[str, ...], seed: int
) -> dict[str, dict[str, str]]:
    """Write what a class hands in; return what each one has for each task."""
    rng = random.Random(seed)
    hostile = [*hostile_submissions(slots)]
    names = {}
    for number in range(students):
        place = folder / f"student{number:03}"
        place.mkdir(parents=True)
        if number and rng.random() < _HOSTILE:
            name, files = hostile[rng.randrange(len(hostile))]
            names[place.name] = dict.fromkeys(tasks, f"hostile: {name}")
            for file, text in files.items():
                (place / file).write_text(text)
            continue
        names[place.name] = {}
        for kind, one in tasks.items():
            is_right = rng.random() < _RIGHT
            chosen = rng.choice([each for each in one.solutions if each.is_right == is_right])
            names[place.name][kind] = f"{'right' if is_right else 'wrong'}: {chosen.name}"
            for module, content in chosen.files.items():
                if (place / f"{module}.py").exists():
                    raise ValueError(f"two solutions have a file {module}.py")
                (place / f"{module}.py").write_bytes(content)
    return names


class Memory:
    """What this process and all that it has started take, sampled while a class is graded."""

    def __init__(self) -> None:
        self.samples: list[int] = []
        self._is_over = threading.Event()

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Sample it now and then."""
        thread = threading.Thread(target=self._watch)
        thread.start()
        try:
            yield
        finally:
            self._is_over.set()
            thread.join()

    def _watch(self) -> None:
        while not self._is_over.wait(_SAMPLE):
            self.samples.append(sum(map(_share, _family(os.getpid()))))

    def __str__(self) -> str:
        if len(self.samples) < 4:
            return "too short to sample the memory"
        quarter = len(self.samples) // 4
        early, late = sorted(self.samples[quarter : 2 * quarter]), sorted(self.samples[-quarter:])
        middle = [half[len(half) // 2] / 2**20 for half in (early, late)]
        return (
            f"memory of all processes: {max(self.samples) / 2**20:.0f} MiB at most; median of the "
            f"second quarter {middle[0]:.0f} MiB, of the last {middle[1]:.0f} MiB"
        )


def _family(pid: int) -> Iterator[int]:
    """Yield a process, its children, and theirs."""
    yield pid
    try:
        for thread in Path(f"/proc/{pid}/task").iterdir():
            for child in (thread / "children").read_text().split():
                yield from _family(int(child))
    except OSError:
        return  # it has ended


def _share(pid: int) -> int:
    """Return the memory of a process, and its share of what it has with others (bytes)."""
    try:
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return 1024 * int(line.split()[1])
    except OSError:
        pass
    return 0


def show(result: ClassResult, names: Mapping[str, Mapping[str, str]]) -> bool:
    """Print what came of whom, by kind; return whether it is what should come."""
    most, full = Counter(), Counter()
    errors = 0
    for one in result.results:
        for test in one.tests:
            if test.name not in names[one.student]:
                continue
            kind = names[one.student][test.name].partition(":")[0]
            errors += test.status == "error"
            most[kind] += 1
            full[kind] += test.points >= test.most
    holds = not errors
    for kind in most:
        print(f"{kind}: all points in {full[kind]} of {most[kind]} tests")
    lost = most["right"] - full["right"]
    if lost:
        chance = binomtest(lost, most["right"], 0.01, alternative="greater").pvalue
        share = lost / most["right"]
        print(f"right, without all points: {share:.2%} (1 % is promised; p {chance:.2g})")
        holds &= chance > 1e-3
    if most["wrong"]:
        holds &= full["wrong"] <= 0.05 * most["wrong"]
    holds &= not full["hostile"]
    print(f"tests that could not be graded: {errors}")
    return bool(holds)


def processor_time() -> float:
    """Return what this process and its children that have ended have used (s)."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def main() -> int:
    """Grade the class, and print the figures; return 1 if something is not as it should be."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--students", type=int, default=300, help="default: 300")
    parser.add_argument("--jobs", type=int, default=2, help="processes; default: 2")
    parser.add_argument("--small", action="store_true", help="on half a core with 768 MB")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for all files, to look at")
    given = parser.parse_args()
    tasks = {kind: task(kind) for kind in KINDS}
    memory = Memory()
    with (
        small_machine() if given.small else nullcontext("the whole machine") as machine,
        tempfile.TemporaryDirectory() if given.keep is None else nullcontext(given.keep) as place,
    ):
        folder = Path(place)
        folder.mkdir(exist_ok=True)
        graded = assignment(folder / "class", tasks)
        names = hand_in(folder / "handed", given.students, tasks, graded.slots, given.seed)
        jobs = given.jobs if given.jobs > 1 else None
        start, before = time.monotonic(), processor_time()
        with memory.watched():
            result = graded.grade_class(folder / "handed", folder / "graded", executor=jobs)
            close_zygotes()
        seconds, used = time.monotonic() - start, processor_time() - before
    print(f"{given.students} submissions x {len(tasks)} tests x 10 runs, {given.jobs} jobs")
    print(machine)
    print(f"{seconds / 60:.1f} minutes, {used / 60:.1f} of processor time")
    print(memory)
    return int(not show(result, names))


if __name__ == "__main__":
    sys.exit(main())
