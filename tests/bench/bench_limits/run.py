"""`run_limits_bench`: separate processes make and read each file."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robsim.base.report import Column, Report, Row, Table
from robsim.teach import SubmissionError

MB = 2**20


@dataclass(frozen=True)
class Taken:
    """Cost of a reading: size of the file and memory (MB), CPU time (s), and the end."""

    file: float
    memory: float
    seconds: float
    end: str

    @property
    def within(self) -> bool:
        """Whether SECURITY.md promises as much."""
        return self.memory <= 256 + 10 * self.file and self.seconds <= 2 * max(self.file, 1)


@dataclass(frozen=True, kw_only=True)
class LimitsBench(Report):
    """Cost of reading the worst file of each kind.

    Attributes
    ----------
    files : dict of str to Taken
        By the fault of the file.
    """

    files: Mapping[str, Taken]

    @property
    def title(self) -> str:
        """Return the title of the report."""
        return "Hostile files: the cost of reading each in a separate process"

    @property
    def tables(self) -> tuple[Table, ...]:
        """A row for each file."""
        columns = (
            Column("file", "file", "MB", ".2f"),
            Column("memory", "memory", "MB", ".0f"),
            Column("seconds", "CPU", "s", ".1f"),
            Column("within", "promise", "", str),
            Column("end", "end", "", str),
        )
        rows = [
            Row(name, [one.file, one.memory, one.seconds, _kept(one), one.end])
            for name, one in self.files.items()
        ]
        return (Table(key="files", columns=columns, rows=rows, row_title="a file"),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Return notes on the columns."""
        return (
            "memory: the peak beside Python and its packages",
            "promise: 256 MB and ten times the "
            "file, 2 s for each MB, at least 2 s (SECURITY.md says which pictures take more)",
        )


def _kept(one: Taken) -> str:
    return "kept" if one.within else "MORE"


def run_limits_bench(*, seed: int = 1, names: Iterable[str] | None = None) -> LimitsBench:
    """Make and read the files of these names, all by default."""
    from bench_limits.files import WORST

    taken = {}
    for name in WORST if names is None else names:
        with tempfile.TemporaryDirectory() as folder:
            _own_process("make", name, folder, str(seed))
            taken[name] = Taken(**json.loads(_own_process("read", name, folder)))
    return LimitsBench(files=taken)


def _own_process(*arguments: str) -> str:
    command = [sys.executable, "-m", "bench_limits.run", *arguments]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(
        command, env=environment, stdout=subprocess.PIPE, text=True, check=True, timeout=600
    )
    return done.stdout


def _read(path: Path, read: Callable[[Path], object]) -> Taken:
    memory, seconds = _usage()
    try:
        read(path)
        end = "read"
    except (ValueError, SubmissionError):
        end = "refused"
    used, spent = _usage()
    files = path.rglob("*") if path.is_dir() else [path]
    size = sum(file.stat().st_size for file in files) / MB
    return Taken(size, used - memory, spent - seconds, end)


def _usage() -> tuple[float, float]:
    """Return the peak of this process (MB) and the time of its CPUs (s)."""
    import resource

    used = resource.getrusage(resource.RUSAGE_SELF)
    unit = MB if sys.platform == "darwin" else 1024
    return used.ru_maxrss / unit, used.ru_utime + used.ru_stime


def _main(what: str, name: str, folder: str, seed: int = 0) -> None:
    from bench_limits.files import WORST

    file, make, read = WORST[name]
    if what == "make":
        make(Path(folder, file), np.random.default_rng(seed))
    else:
        print(json.dumps(vars(_read(Path(folder, file), read))))


if __name__ == "__main__":
    _main(*sys.argv[1:4], *map(int, sys.argv[4:]))
