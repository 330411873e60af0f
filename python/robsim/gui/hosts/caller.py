"""The host without a browser: whoever calls says what the mouse would, and gets the answers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from robsim.base.checks import check_choice
from robsim.gui._link import Buffers, Link
from robsim.gui._view import View


def answers_to(view: View, kind: str, fields: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what a view answers to a message, once it has done what that asks for.

    Raises
    ------
    TypeError, ValueError
        If the message is none, or is refused; the text says why.
    """
    check_choice("kind", kind, tuple(view.messages))
    line = _Answers()
    view.settle()  # a tool has its first picture, if there is one
    view.receive(line, {"type": kind, "id": "caller", **_as_sent(fields)})
    view.settle()
    for head in line.heads:
        if head["type"] == "note" and head["level"] == "error":
            raise ValueError(head["text"])
    return line.heads


def _as_sent(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return fields as a browser would send them."""
    try:
        sent: dict[str, Any] = json.loads(json.dumps(fields))
    except TypeError as error:  # such as an array
        raise TypeError(f"fields must be numbers, texts, lists or None: {error}") from None
    return sent


class _Answers(Link):
    """A line that nobody watches: it gets what is said to it alone, and neither frames nor news."""

    def __init__(self) -> None:
        super().__init__()
        self.heads: list[dict[str, Any]] = []

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        self.heads.append(dict(head))
