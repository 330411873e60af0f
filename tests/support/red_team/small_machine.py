"""Half a core and 768 MB, as on a rented grader: for this process and all that it starts."""

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_MEMORY = 768 << 20  # bytes
_ROOT = Path("/sys/fs/cgroup")


@contextmanager
def small_machine() -> Iterator[str]:
    """Take what this machine lets one take; give, in a sentence, what that is."""
    group, files = _group()
    said = []
    try:
        group.mkdir()
        for name, value in files.items():
            (group / name).write_text(value)
        (group / "cgroup.procs").write_text(str(os.getpid()))
        said.append(f"half a core ({group})")
    except OSError as error:
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        said.append(f"one core (no control group: {error.strerror})")
    if "memory.max" in files and said[0].startswith("half"):
        said.append("768 MiB in all")
    else:
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, hard))
        said.append("768 MiB of data for each process")
    try:
        yield ", ".join(said)
    finally:
        if group.is_dir():
            (group.parent / "cgroup.procs").write_text(str(os.getpid()))
            group.rmdir()


def _group() -> tuple[Path, dict[str, str]]:
    """Return the control group to be made, and what is written in it: version 2, else 1."""
    name = f"robsim-red-team-{os.getpid()}"
    if (_ROOT / "cgroup.controllers").exists():
        memory = {"memory.max": str(_MEMORY), "memory.swap.max": "0"}
        return _ROOT / name, {"cpu.max": "50000 100000", **memory}
    return _ROOT / "cpu" / name, {"cpu.cfs_period_us": "100000", "cpu.cfs_quota_us": "50000"}
