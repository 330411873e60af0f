"""Half a core and 768 MB, as on a rented grader: for this process and all that it starts."""

import os
import resource
from pathlib import Path

_MEMORY = 768 << 20  # bytes


def small_machine() -> str:
    """Take what there is to take; return how, in a sentence."""
    group = Path("/sys/fs/cgroup", f"robsim-red-team-{os.getpid()}")
    try:
        group.mkdir()
        (group / "cpu.max").write_text("50000 100000")
        (group / "memory.max").write_text(str(_MEMORY))
        (group / "memory.swap.max").write_text("0")
        (group / "cgroup.procs").write_text(str(os.getpid()))
    except OSError as error:
        reason = error.strerror
        if group.exists():
            group.rmdir()
    else:
        return f"half a core and 768 MB, by {group} (remove it when this has ended)"
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, hard))
    return f"one core and 768 MiB of data for each process (no control group: {reason})"
