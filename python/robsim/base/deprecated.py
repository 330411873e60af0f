"""Warnings of public names that a later version removes."""

from __future__ import annotations

from robsim.base.warn import warn_user


def warn_deprecated(name: str, *, since: str, gone_in: str, instead: str) -> None:
    """Warn in the user's line; a test reads all calls, and fails from version `gone_in` on."""
    message = f"{name} is deprecated since robsim {since}; {gone_in} removes it. Use {instead}."
    warn_user(DeprecationWarning(message))
