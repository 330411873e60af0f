"""Which kernels the linear algebra of numpy and scipy has: those of OPENBLAS_CORETYPE?

OpenBLAS picks them by the processor. As a program it prints them, and fails unless they are those
that were asked for, if any were, so that nobody takes the same kernels for four others.
"""

import ctypes
import os
import sys
from importlib.util import find_spec
from pathlib import Path

import scipy.linalg  # noqa: F401  brings its own OpenBLAS beside that of numpy

NAMES = ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename")


def kernels():
    """Return the kernels by library, such as ``{"libscipy_openblas-1.so": "Haswell"}``."""
    found = {}
    for package in ("numpy", "scipy"):
        folder = Path(find_spec(package).origin).parent
        for file in sorted(folder.with_name(f"{package}.libs").glob("lib*openblas*")):
            library = ctypes.CDLL(str(file))
            name = next(name for name in NAMES if hasattr(library, name))
            core = getattr(library, name)
            core.restype = ctypes.c_char_p
            found[file.name] = core().decode()
    return found


if __name__ == "__main__":
    found = kernels()
    print(found)
    wanted = os.environ.get("OPENBLAS_CORETYPE", "")
    same = {"Zen": {"Zen", "Haswell"}}  # builds without kernels of its own take Haswell's for Zen
    if wanted and (not found or not {*found.values()} <= same.get(wanted, {wanted})):
        sys.exit(f"OPENBLAS_CORETYPE={wanted} has no effect here")
