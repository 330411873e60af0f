"""Files of users that stand in for modules which robsim needs, such as ``numpy.py``."""

from __future__ import annotations

import os
import sys

_NEEDED = ("numpy", "PIL", "matplotlib", "cv2", "tornado", "rich", *sys.stdlib_module_names)


def told(error: Exception) -> Exception:
    """Return the error of an import, or one that names the file at fault."""
    folders = {os.path.realpath(folder or os.curdir) for folder in (sys.path[0], "")}
    for name in _NEEDED:
        file = getattr(sys.modules.get(name), "__file__", None)
        if file and os.path.dirname(os.path.realpath(file)) in folders:
            return ImportError(
                f"{file} stands in for the module {name}, which robsim needs: rename your file"
            )
    return error
