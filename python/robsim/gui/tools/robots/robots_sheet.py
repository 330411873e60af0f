"""The still picture of the panel that defines a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from robsim.gui.hosts.script import words
from robsim.gui.tools.pictures import Picture
from robsim.gui.tools.sheet import ACCENT, CHOSEN, LINE, QUIET, TEXT, WARNING, Sheet, Shown
from robsim.vision.robots.sketch import OUTLINE

_WIDTH, _HEIGHT = 800, 500
_SIDE = 455  # of the picture
_LEFT = 480  # of the text column
_ROOM = _WIDTH - _LEFT - 12
_SQUARE, _ARROW = "#ffd500", 44.0


def robots_still(picture: Picture | None, title: str, state: Mapping[str, Any]) -> bytes:
    """Return a picture of the drawing, or of the square to capture (PNG)."""
    sheet = Sheet(_WIDTH, _HEIGHT)
    draws = state["mode"] == "draw"
    sheet.title("robots", state["name"] if draws else title)
    shown = Shown(None if picture is None else picture.frame, _SIDE)
    if draws:
        _draw_parts(shown, state)
    elif state["square"]:
        u, v, side = state["square"]
        half = side / 2 - 0.5
        shown.rectangle((u - half, v - half, u + half, v + half), _SQUARE, 2)
    sheet.show(shown, _SIDE, _SIDE)
    _write(sheet, state)
    return sheet.png()


def _draw_parts(shown: Shown, state: Mapping[str, Any]) -> None:
    for part, corners in state["parts"].items():
        shown.line(corners, state["inks"][part], closed=len(corners) > 2)
    part = state["part"]
    for corner in state["parts"][part]:
        shown.dot(corner, state["inks"][part])
    # The robot faces right after a clockwise rotation by the alignment.
    shown.arrow(state["centre"], -math.radians(state["alignment"]), _ARROW, "white")


def _write(sheet: Sheet, state: Mapping[str, Any]) -> None:
    y = 34.0
    for part, corners in state["parts"].items():
        is_chosen = part == state["part"] and state["mode"] == "draw"
        sides = (_LEFT, y, _LEFT + _ROOM, y + 28)
        look = (CHOSEN, ACCENT) if is_chosen else ("white", LINE)
        sheet.box(sides, fill=look[0], line=look[1], radius=5)
        sheet.dot((_LEFT + 14, y + 14), 5, state["inks"][part])
        name = words(f"part.{state['roles'].get(part, 'marker')}", color=part)
        if part == OUTLINE:
            name = words("part.outline")
        sheet.text((_LEFT + 28, y + 14), name, kind="bold" if is_chosen else "regular")
        sheet.text((_LEFT + _ROOM - 10, y + 14), f"{len(corners)}", ink=QUIET, right=True)
        y += 34
    y += 14
    size = f"{state['size']:.6g} {words('robot_size_unit')}"
    facts = {"robot_heading": f"{state['alignment']:.1f}\N{DEGREE SIGN}", "robot_size": size}
    for label, value in facts.items():
        sheet.text((_LEFT, y), words(label), ink=QUIET)
        sheet.text((_LEFT + _ROOM, y), value, ink=TEXT, right=True)
        y += 24
    y += 8
    if state["mode"] == "capture":
        if state["square"]:
            u, v, side = (round(value) for value in state["square"])
            sheet.text((_LEFT, y), words("square", side=side, u=u, v=v))
            y += 26
        sheet.paragraph((_LEFT, y), words("hint.capture"), _ROOM, ink=QUIET)
        return
    for problem in state["problems"]:
        y = sheet.paragraph((_LEFT, y), problem, _ROOM, ink=WARNING) + 6
