"""Which faults are put in: some by name, the others drawn from all places in both languages."""

from __future__ import annotations

import json
import random
from collections.abc import Iterable, Iterator
from pathlib import Path

from mutants import in_cpp, in_python
from mutants.fault import Fault
from mutants.named import named_faults

#: Not drawn from: templates are for students, what is written for JavaScript is not
#: Python, and what is read by another compiler than ours is not compiled here.
_LEFT_OUT = ("/start/", "/templates/", "/bench", "windows", "_neon")
_LANGUAGES = {"python": ("*.py", in_python.faults_in), "cpp": ("*.cpp", in_cpp.faults_in)}


def ran_lines(reports: Iterable[Path]) -> dict[str, set[int]]:
    """Return the lines that ran, by file, of JSON reports of coverage.py and of gcovr."""
    ran: dict[str, set[int]] = {}
    for report in reports:
        files = json.loads(report.read_text())["files"]
        if isinstance(files, dict):  # of coverage.py
            for file, one in files.items():
                within = f"python/robsim/{file.rpartition('/robsim/')[2]}"
                ran.setdefault(within, set()).update(one["executed_lines"])
        else:
            for one in files:
                lines = (line["line_number"] for line in one["lines"] if line["count"])
                ran.setdefault(one["file"], set()).update(lines)
    return ran


def drawn(
    root: Path, seed: int, count: int, reports: Iterable[Path]
) -> Iterator[tuple[str, Fault]]:
    """Yield the faults by name, then drawn ones without end, each with the group that it is of.

    Parameters
    ----------
    root : path
        The tree.
    seed : int
        What the draw comes from.
    count : int
        How many places each group gets at most.
    reports : iterable of path
        What some tests ran, as for `ran_lines`: half of the faults lie there.
    """
    for fault in named_faults(root):
        yield "by name", fault
    ran = ran_lines(reports)
    draw = random.Random(seed)
    for language, (pattern, faults_in) in _LANGUAGES.items():
        folder = root / ("python/robsim" if language == "python" else "cpp")
        files = sorted(str(path.relative_to(root)) for path in folder.rglob(pattern))
        files = [file for file in files if not any(part in file for part in _LEFT_OUT)]
        everywhere = [fault for file in files for fault in faults_in(root, file)]
        there = [one for one in everywhere if one.line in ran.get(one.file, ())]
        for group, places in (("ran by deleted tests", there), ("anywhere", everywhere)):
            for fault in draw.sample(places, min(count, len(places))):
                yield f"{language}, {group}", fault
