"""Users' files that hide modules which robsim needs, such as ``numpy.py``."""

from __future__ import annotations

import os
import sys

_NEEDED = ("numpy", "PIL", "matplotlib", "cv2", "av", "tornado", "rich", *sys.stdlib_module_names)
_USED = ("copy", "csv", "json", "tomllib")  # long after their import, which finds no fault


def check_modules(error: Exception | None = None) -> None:
    """Raise ImportError for a user's file that hides a module and so caused the error."""
    said = ""
    if error is not None:
        import traceback  # such a file, too

        said = "".join(traceback.format_exception(error))
    for name in _NEEDED if said else _USED:
        file = getattr(sys.modules.get(name), "__file__", None) or ""
        is_of_user = os.path.dirname(file) in (*sys.path[:1], os.path.abspath(os.curdir))
        if file and is_of_user and (not said or file in said or f"'{name}'" in said):
            raise ImportError(
                f"{file} hides the module {name}, which robsim needs: rename your file"
            ) from error
