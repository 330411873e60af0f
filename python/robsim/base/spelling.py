"""Names in messages: suggestions for misspelled ones (options, choices, columns), articles."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable

from robsim.base.text import quoted

_LONGEST = 100  # characters; no name is longer, and the search takes their square


def closest(name: str, known: Iterable[str], *, cutoff: float = 0.6) -> str | None:
    """Return the known name that `name` resembles most, or None if it resembles none.

    Case, underscores, hyphens and spaces do not count. At a `cutoff` of 1 only the same name fits.
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

    It has no name: Python, from 3.12 on, would add a suggestion of its own.
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
            hint = f"did you mean {meant!r}?" if meant else f"there are {there}"
            raise error(f"{what} {quoted(name)}: {hint}")


def with_article(name: str) -> str:
    return f"{'an' if name[0] in 'AEIOUaeiou' else 'a'} {name}"


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name.lower())
