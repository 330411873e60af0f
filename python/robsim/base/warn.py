"""Warnings that show the user's line."""

from __future__ import annotations

import sys
import warnings


def warn_user(warning: str | Warning) -> None:
    """Warn at the user's line that called robsim."""
    level, caller = 1, sys._getframe()
    while caller.f_back and _is_of_robsim(caller.f_globals.get("__name__", "")):
        level, caller = level + 1, caller.f_back
    warnings.warn(warning, stacklevel=level)


def _is_of_robsim(module: str) -> bool:
    # The frame of a context manager lies between two of robsim.
    return module in ("robsim", "contextlib") or module.startswith("robsim.")
