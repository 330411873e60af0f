"""Files of users that stand in for modules which robsim needs, such as ``numpy.py``."""

from __future__ import annotations

import os
import sys
import traceback

_NEEDED = ("numpy", "PIL", "matplotlib", "cv2", "tornado", "rich", *sys.stdlib_module_names)


def told(error: Exception) -> Exception:
    """Return the error of an import, or one that names the file at fault."""
    said = "".join(traceback.format_exception(error))
    for name in _NEEDED:
        file = getattr(sys.modules.get(name), "__file__", None) or ""
        is_of_user = os.path.dirname(file) in (*sys.path[:1], os.path.abspath(os.curdir))
        if file and is_of_user and (file in said or f"'{name}'" in said):
            return ImportError(
                f"{file} stands in for the module {name}, which robsim needs: rename your file"
            )
    return error
