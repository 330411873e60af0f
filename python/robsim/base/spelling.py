"""Names in messages: suggestions for misspelled ones (options, choices, columns), articles."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable

from robsim.base.text import quoted

_LONGEST = 100  # characters; no name is longer, and the search takes their square


def closest(name: str, known: Iterable[str], *, cutoff: float = 0.6) -> str | None:
    """Return the known name that `name` resembles most, or None if `name` resembles no name.

    Case, underscores, hyphens and spaces do not count. With a `cutoff` of 1 only equal names fit.
    """
    if len(name) > _LONGEST:
        return None
    plain = {_plain(other): other for other in known}
    close = difflib.get_close_matches(_plain(name), plain, 1, cutoff)
    return plain[close[0]] if close else None


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return the end of an error message, ``"; did you mean 'x'?"``, or ``""``."""
    meant = closest(name, known)
    return "" if meant is None else f"; did you mean {meant!r}?"


def no_attribute(message: str, name: str = "", known: Iterable[str] = ()) -> AttributeError:
    """Return an AttributeError whose message suggests the known name closest to `name`.

    The error's `name` is not set: Python, from 3.12 on, would add a second suggestion.
    """
    return AttributeError(message + suggestion(name, known), obj=None)


def check_names(
    what: str, given: Iterable[str], known: Iterable[str], error: Callable[[str], Exception]
) -> None:
    """Raise an error for the first unknown name; `what` begins it: ``"a task has no option"``."""
    known = list(known)
    for name in given:
        if name not in known:
            meant, there = closest(name, known), ", ".join(known) or "none"
            hint = f"did you mean {meant!r}?" if meant else f"known: {there}"
            raise error(f"{what} {quoted(name)}: {hint}")


def check_call(
    call: str,  # the name that users know, such as find_blobs
    names: list[str],
    required: list[str],
    n_allowed: int,  # how many may come without their names
    n_positional: int,  # how many came so
    keywords: tuple[str, ...],  # the names that came
) -> None:
    """Raise a TypeError if these are no arguments of a native function: the core calls it."""
    if n_positional > n_allowed:
        text = f"{call}() takes {n_allowed or 'no'} positional argument"
        more = (
            f": give the others by name, as in {names[n_allowed]}=..." if names[n_allowed:] else ""
        )
        raise TypeError(f"{text}{'s' * (n_allowed != 1)}, got {n_positional}{more}")
    given = names[:n_positional]
    for name in keywords:
        if name in given:
            raise TypeError(f"{call}() got two values for {name}")
        if name not in names:
            meant = suggestion(name, [other for other in names if other not in given])
            hint = meant or f": it takes {', '.join(names) or 'none'}"
            raise TypeError(f"{call}() has no argument '{name}'{hint}")
        given.append(name)
    for name in required:
        if name not in given:
            raise TypeError(f"{call}() needs the argument {name}")


def with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())
