"""What a browser may send to the panel that trains colours."""

from __future__ import annotations

from typing import Any

from robsim.gui._messages import Messages, Refused, list_of, setting, text, whole
from robsim.gui.tools.tool import TOOL_MESSAGES

_LONGEST = 8000  # characters of a colour file


def _long_text(value: Any) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST:
        raise Refused(f"a text of up to {_LONGEST} characters")
    return value


def _exactly(count: int, check: Any) -> Any:
    def checked(value: Any) -> list[Any]:
        found: list[Any] = list_of(check, count)(value)
        if len(found) != count:
            raise Refused(f"a list of {count}")
        return found

    return checked


MESSAGES: Messages = {
    **TOOL_MESSAGES,
    "choose": {"name": text},
    "region": {"region": _exactly(4, whole), "keep": whole},
    "ranges": {"ranges": _exactly(3, _exactly(2, whole))},
    "set": {"name": text, "value": setting},
    "thresholds": {"text": _long_text},
    "remove": {},
    "score": {},
    "save": {"file": text},
}
