"""Optional packages, imported on use."""

from __future__ import annotations

import importlib
from typing import Any


def import_optional(name: str, what: str) -> Any:
    """Return a module; an ImportError names its user `what` (with a verb), and the pip package."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise ImportError(f"{what} {package}: pip install {package}") from error
