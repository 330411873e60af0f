"""What a browser may send to the panel that defines a robot."""

from __future__ import annotations

from robsim.gui._messages import Messages, number, point, switch, text, whole
from robsim.gui.tools.tool import TOOL_MESSAGES

MESSAGES: Messages = {
    **TOOL_MESSAGES,
    "load": {"name": text},
    "square": {"at": point, "side": number},
    "capture": {},
    "capture_whole": {},
    "no_camera": {},
    "resume": {},
    "part": {"name": text},
    "move": {"corner": whole, "at": point, "goes_on": switch},
    "insert": {"corner": whole, "at": point},
    "cut": {"corner": whole},
    "clear": {},
    "guess": {},
    "turn": {"degrees": number},
    "face": {"at": point, "goes_on": switch},
    "resize": {"size": number},
    "scale": {"one": point, "other": point, "distance": number},
    "undo": {},
    "redo": {},
    "reset": {},
    "save": {"name": text, "overwrite": switch},
}
