"""What a browser may send to the panel of a run."""

from robsim.gui._messages import (
    COMMON,
    Messages,
    buffers_of_message,
    list_of,
    maybe,
    message,
    number,
    point,
    setting,
    switch,
    text,
    whole,
)

_MOST_POINTS = 1000
_MOST_NAMES = 100

MESSAGES: Messages = {
    **COMMON,
    "press": {"button": text},
    "set": {"name": text, "value": setting},
    "go_to": {"x": number, "y": number},
    "path": {"points": list_of(point, _MOST_POINTS)},
    "look": {"k": maybe(whole)},
    "columns": {"names": list_of(text, _MOST_NAMES)},
    "inspect": {"k": maybe(whole), "path": list_of(text, _MOST_NAMES)},
    "source": {"slot": text},
    "edit": {"slot": text},
    "animate": {"on": switch},
    "tool": {"name": maybe(text)},
    "use_tool": {},
    "tell_tool": {"name": text, "message": message, "buffers": buffers_of_message},
}
