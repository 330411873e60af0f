"""How processes of workers are started: nothing of the grader's is in their environment."""

from __future__ import annotations

import os
import sys
from pathlib import Path

# What a worker keeps of the grader's environment: how numbers are computed, and nothing else.
_KEPT = ("OPENBLAS_CORETYPE", "GLIBC_TUNABLES", "NPY_DISABLE_CPU_FEATURES", "ROBSIM_CPU")
_SET = {
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "agg",
    "MALLOC_ARENA_MAX": "2",  # an arena for each thread takes 128 MiB of addresses
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
}


def environment_for(home: str) -> dict[str, str]:
    """Return the environment of a process with a home folder."""
    return {**_SET, "HOME": home, **{n: os.environ[n] for n in _KEPT if n in os.environ}}


def command_for(entry: str, *arguments: int) -> list[str]:
    """Return the command that runs ``"module:function"`` of this very robsim, isolated."""
    package = str(Path(__file__).parents[4])
    module, _, function = entry.partition(":")
    called = f"{function}({', '.join(map(str, arguments))})"
    code = f"import sys; sys.path.append({package!r}); from {module} import {function}; {called}"
    return [sys.executable, "-I", "-c", code]
