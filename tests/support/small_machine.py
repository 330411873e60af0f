"""Half a core and 768 MB, as on a rented grader: for this process and all that it starts."""

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_MEMORY = 768 << 20  # bytes
_CPU = {"cpu.cfs_period_us": "100000", "cpu.cfs_quota_us": "50000"}
_ROOT = Path("/sys/fs/cgroup")


@contextmanager
def small_machine() -> Iterator[str]:
    """Take what this machine lets one take; give, in a sentence, what that is."""
    said, groups = [], []
    try:
        for what, group, values in _groups():
            try:
                _enter(group, values)
            except OSError as error:
                said.append(_less(what, error))
            else:
                groups.append(group)
                said.append(what)
        yield ", ".join(said)
    finally:
        for group in groups:
            _leave(group)


def _groups() -> Iterator[tuple[str, Path, dict[str, str]]]:
    """Yield what is limited, the control group for it, and what is written there."""
    name = f"robsim-small-{os.getpid()}"
    if (_ROOT / "cgroup.controllers").exists():  # version 2
        memory = {"memory.max": str(_MEMORY), "memory.swap.max": "0"}
        yield "half a core, 768 MiB in all", _ROOT / name, {"cpu.max": "50000 100000", **memory}
        return
    yield "half a core", _ROOT / "cpu" / name, _CPU
    own = _own_memory_group()
    yield "768 MiB in all", own / name, {"memory.limit_in_bytes": str(_MEMORY)}


def _own_memory_group() -> Path:
    """Return the group of version 1 in which this process is."""
    for line in Path("/proc/self/cgroup").read_text().splitlines():
        _, controllers, path = line.split(":", 2)
        if controllers == "memory":
            return _ROOT / "memory" / path.lstrip("/")
    return _ROOT / "memory"


def _enter(group: Path, values: dict[str, str]) -> None:
    group.mkdir()
    try:
        for name, value in values.items():
            (group / name).write_text(value)
        (group / "cgroup.procs").write_text(str(os.getpid()))
    except OSError:
        group.rmdir()
        raise


def _leave(group: Path) -> None:
    """Take all that is still in a group out of it, and remove it."""
    for pid in (group / "cgroup.procs").read_text().split():
        (group.parent / "cgroup.procs").write_text(pid)
    group.rmdir()


def _less(what: str, error: OSError) -> str:
    """Limit what can be limited without control groups, and say what that is."""
    said = []
    if "core" in what:
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        said.append("one core")
    if "MiB" in what:
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, hard))
        said.append("768 MiB of data for each process")
    return f"{', '.join(said)} (no control group: {error.strerror})"
