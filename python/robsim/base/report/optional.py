"""Packages that robsim can do without, imported where they are needed."""

from __future__ import annotations

import importlib
from typing import Any


def import_optional(name: str, what: str) -> Any:
    """Return a module.

    Parameters
    ----------
    name : str
        Its name; the first part is that of the package for pip.
    what : str
        What needs it, with its verb, for the message.

    Raises
    ------
    ImportError
        If it is not installed.
    """
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        raise ImportError(f"{what} {package}: pip install {package}") from error
