"""What a browser may send: one table, and the check against it."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from typing import Any

_MOST_TEXT = 200  # characters
_MOST_POINTS = 1000
_MOST_NAMES = 100


class Refused(Exception):
    """A message that cannot be used; its text goes back to the browser."""


def _text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > _MOST_TEXT:
        raise Refused(f"a text of up to {_MOST_TEXT} characters")
    return value


def _number(value: Any) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        with suppress(OverflowError):
            if math.isfinite(number := float(value)):
                return number
    raise Refused("a finite number")


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**53:
        raise Refused("a whole number from 0")
    return value


def _switch(value: Any) -> bool:
    if not isinstance(value, bool):
        raise Refused("true or false")
    return value


def _setting(value: Any) -> bool | float | str:
    if isinstance(value, bool):
        return value
    return _text(value) if isinstance(value, str) else _number(value)


def _maybe(check: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda value: None if value is None else check(value)


def _list_of(check: Callable[[Any], Any], most: int) -> Callable[[Any], Any]:
    def checked(value: Any) -> list[Any]:
        if not isinstance(value, list) or len(value) > most:
            raise Refused(f"a list of up to {most}")
        return [check(item) for item in value]

    return checked


def _point(value: Any) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise Refused("x and y")
    return _number(value[0]), _number(value[1])


#: Type of message -> field -> check; `id` is in all of them.
_FIELDS: dict[str, dict[str, Callable[[Any], Any]]] = {
    "hello": {"width": _whole},
    "size": {"width": _whole},
    "bye": {},
    "grant": {"upto": _whole, "late": _switch},
    "press": {"button": _text},
    "set": {"name": _text, "value": _setting},
    "go_to": {"x": _number, "y": _number},
    "path": {"points": _list_of(_point, _MOST_POINTS)},
    "look": {"k": _maybe(_whole)},
    "columns": {"names": _list_of(_text, _MOST_NAMES)},
    "inspect": {"k": _maybe(_whole), "path": _list_of(_text, _MOST_NAMES)},
    "source": {"slot": _text},
    "edit": {"slot": _text},
    "animate": {"on": _switch},
}


def checked_message(message: Any) -> dict[str, Any]:
    """Return a message with the fields of its type and no others; else raise `Refused`."""
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str) or kind not in _FIELDS:
        raise Refused("not a message of this panel")
    fields = {"id": _text} | _FIELDS[kind]
    return {"type": kind} | {
        name: _checked(kind, name, check, message) for name, check in fields.items()
    }


def _checked(kind: str, name: str, check: Callable[[Any], Any], message: dict[str, Any]) -> Any:
    try:
        return check(message[name])
    except KeyError:
        raise Refused(f"the message {kind} lacks {name}") from None
    except Refused as expected:
        raise Refused(f"{name} of the message {kind} must be {expected}") from None
