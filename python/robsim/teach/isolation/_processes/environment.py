"""The environment and the command of workers' processes, without the grader's variables."""

from __future__ import annotations

import os
import sys
from pathlib import Path

# The variables that a worker keeps of the grader's environment: they only affect computations.
_KEPT = ("OPENBLAS_CORETYPE", "GLIBC_TUNABLES", "NPY_DISABLE_CPU_FEATURES", "ROBSIM_CPU")
_SET = {
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "agg",
    "MALLOC_ARENA_MAX": "2",  # an arena for each thread takes 128 MiB of addresses
    **dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"),
}


def environment_for(home: str) -> dict[str, str]:
    kept = {name: os.environ[name] for name in _KEPT if name in os.environ}
    if sys.platform == "win32":
        return {**_SET, **kept, **_of_windows(home)}
    return {**_SET, "HOME": home, **kept}


def _of_windows(home: str) -> dict[str, str]:
    """Return the variables that programs need there, and the place of this virtual environment."""
    root = os.environ.get("SYSTEMROOT", r"C:\Windows")
    libraries = [sys.base_prefix, os.path.join(sys.base_prefix, "Library", "bin")]  # conda's
    virtual = {"__PYVENV_LAUNCHER__": sys.executable} if sys.prefix != sys.base_prefix else {}
    return {
        "SYSTEMROOT": root,
        "PATH": os.pathsep.join([*libraries, os.path.join(root, "System32"), root]),
        **dict.fromkeys(("USERPROFILE", "TEMP", "TMP"), home),
        **virtual,
    }


def command_for(entry: str, *arguments: int) -> list[str]:
    """Return the command that runs ``"module:function"`` of this very robsim, isolated."""
    package = str(Path(__file__).parents[4])
    module, _, function = entry.partition(":")
    called = f"{function}({', '.join(map(str, arguments))})"
    code = (
        f"import sys; p = sys.path; at = [one.endswith('-packages') for one in (*p, '-packages')]; "
        f"p.insert(at.index(True), {package!r}); from {module} import {function}; {called}"
    )
    program = sys.executable
    if sys.platform == "win32":  # a virtual environment's program starts another process
        program = getattr(sys, "_base_executable", program)
    return [program, "-I", "-c", code]
