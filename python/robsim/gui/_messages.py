"""What a browser may send: the checks of fields, and of a message against a table of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

Check = Callable[[Any], Any]
#: Type of message -> field -> check; `id` is in all of them. The field `buffers` is no JSON.
Messages = Mapping[str, Mapping[str, Check]]

_MOST_TEXT = 200  # characters


class Refused(Exception):
    """A message that cannot be used; its text goes back to the browser."""


def text(value: Any) -> str:
    """Return a short text."""
    if not isinstance(value, str) or len(value) > _MOST_TEXT:
        raise Refused(f"a text of up to {_MOST_TEXT} characters")
    return value


def number(value: Any) -> float:
    """Return a finite number."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        with suppress(OverflowError):
            if math.isfinite(found := float(value)):
                return found
    raise Refused("a finite number")


def whole(value: Any) -> int:
    """Return a whole number from 0."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**53:
        raise Refused("a whole number from 0")
    return value


def switch(value: Any) -> bool:
    """Return true or false."""
    if not isinstance(value, bool):
        raise Refused("true or false")
    return value


def setting(value: Any) -> bool | float | str:
    """Return the value of a control."""
    if isinstance(value, bool):
        return value
    return text(value) if isinstance(value, str) else number(value)


def message(value: Any) -> dict[str, Any]:
    """Return a message, to be checked by whom it is for."""
    if not isinstance(value, dict):
        raise Refused("a message")
    return value


def maybe(check: Check) -> Check:
    return lambda value: None if value is None else check(value)


def list_of(check: Check, most: int) -> Check:
    """Return a check of lists of so many items."""

    def checked(value: Any) -> list[Any]:
        if not isinstance(value, list) or len(value) > most:
            raise Refused(f"a list of up to {most}")
        return [check(item) for item in value]

    return checked


def point(value: Any) -> tuple[float, float]:
    """Return x and y."""
    if not isinstance(value, list) or len(value) != 2:
        raise Refused("x and y")
    return number(value[0]), number(value[1])


def buffers_of_message(value: Any) -> list[bytes]:
    """Return the buffers of a message that is passed on, to be checked by whom it is for."""
    if len(value) > 1:
        raise Refused("one at most")
    return [bytes(one) for one in value]


def one_buffer(most: int) -> Check:
    """Return a check of buffers: it returns the only one, of up to so many bytes."""

    def checked(value: Any) -> bytes:
        if len(value) != 1 or len(value[0]) > most:
            raise Refused(f"one, of up to {most} bytes")
        return bytes(value[0])

    return checked


#: What every panel takes.
COMMON: Messages = {
    "hello": {"width": whole},
    "size": {"width": whole},
    "bye": {},
    "grant": {"upto": whole, "late": switch},
}


def checked_message(
    message: Any, messages: Messages, buffers: Sequence[bytes] = ()
) -> dict[str, Any]:
    """Return a message with the fields of its type and no others; else raise `Refused`."""
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str) or kind not in messages:
        raise Refused("not a message of this panel")
    fields = {"id": text, **messages[kind]}
    given = {**message, "buffers": buffers}  # whatever the browser says of them
    return {"type": kind} | {
        name: _checked(kind, name, check, given) for name, check in fields.items()
    }


def _checked(kind: str, name: str, check: Check, message: dict[str, Any]) -> Any:
    try:
        return check(message[name])
    except KeyError:
        raise Refused(f"the message {kind} lacks {name}") from None
    except Refused as expected:
        raise Refused(f"{name} of the message {kind} must be {expected}") from None
