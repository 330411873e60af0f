"""What a browser may send to the panel that calibrates a floor."""

from __future__ import annotations

from robsim.gui._messages import Messages, maybe, number, point, switch, text, whole
from robsim.gui.tools.tool import TOOL_MESSAGES

MESSAGES: Messages = {
    **TOOL_MESSAGES,
    "magnify": {"at": point, "half": whole, "glass": whole},
    "add": {"at": point, "reach": number},
    "choose": {"point": maybe(whole)},
    "move": {"point": whole, "at": point, "goes_on": switch},
    "nudge": {"point": whole, "by": point, "goes_on": switch},
    "snap": {"point": whole, "reach": number},
    "place": {"point": whole, "x": maybe(number), "y": maybe(number)},
    "cut": {"point": whole},
    "clear": {},
    "fill": {"step": number},
    "set": {"name": text, "value": number},
    "by": {"name": text},
    "sheets": {},
    "sheet": {"number": whole, "x": maybe(number), "y": maybe(number)},
    "board": {"pattern": text, "columns": whole, "rows": whole, "square": number},
    "take": {},
    "take_all": {},
    "watch": {"on": switch},
    "drop": {"picture": maybe(whole)},
    "use_lens": {},
    "undo": {},
    "redo": {},
    "load": {"file": text},
    "forget": {},
    "save": {"file": text},
}
