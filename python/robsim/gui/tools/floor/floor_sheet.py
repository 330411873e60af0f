"""The still picture of the panel that calibrates a floor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robsim._core import Frame
from robsim.gui.hosts.script import words
from robsim.gui.tools.pictures import Picture
from robsim.gui.tools.sheet import QUIET, TEXT, WARNING, Sheet, Shown
from robsim.lab.calibration.grid import draw_grid
from robsim.vision.imaging.calibration import Calibration

_WIDTH, _HEIGHT = 900, 500
_SIDE = 560  # of the picture
_LEFT = 585  # of the text column
_ROOM = _WIDTH - _LEFT - 12
_MOST_ROWS = 17
_POINT, _WRONG = "#5ee08a", "#ff5a5f"


def floor_still(
    picture: Picture | None, title: str, state: Mapping[str, Any], calibration: Calibration | None
) -> bytes:
    """Return a picture of the points, their fit and the grid (PNG)."""
    sheet = Sheet(_WIDTH, _HEIGHT)
    sheet.title("floor", title)
    shown = Shown(_with_grid(picture, state, calibration), _SIDE)
    fit = state["fit"]
    wrong = _wrong_of(fit)
    for one in [] if fit is None else fit["points"]:
        shown.line([one["at"], one["to"]], _WRONG, 2)
    for point in state["points"]:
        shown.dot(point["at"], _WRONG if str(point["number"]) == wrong else _POINT)
    sheet.show(shown, *shown.size)
    _write(sheet, state, wrong)
    return sheet.png()


def _with_grid(
    picture: Picture | None, state: Mapping[str, Any], calibration: Calibration | None
) -> Frame | None:
    if picture is None or calibration is None or state["grid"] is None:
        return None if picture is None else picture.frame
    height, width = picture.frame.image.shape[:2]
    if calibration.size != (width, height):
        return picture.frame
    return Frame(draw_grid(picture.frame.image, calibration))


def _wrong_of(fit: Mapping[str, Any] | None) -> str | None:
    """Return the name of a point that does not fit."""
    if fit is None:
        return None
    return next((one["name"] for one in fit["points"] if not one["used"]), None)


def _write(sheet: Sheet, state: Mapping[str, Any], wrong: str | None) -> None:
    fit, y = state["fit"], 40.0
    if fit is not None:
        numbers = {name: f"{fit[name]:.2f}" for name in ("rms", "worst_mm")}
        mm = f"{fit['rms_mm']:.2f}"
        lines = [
            words("floor_rms", rms=numbers["rms"], mm=mm, count=fit["count"]),
            words("floor_worst", worst=fit["worst"], worst_mm=numbers["worst_mm"]),
        ]
        for line in lines:
            sheet.text((_LEFT, y), line, ink=TEXT)
            y += 19
    for problem in state["problems"]:
        y = sheet.paragraph((_LEFT, y), problem, _ROOM, ink=WARNING)
    y += 8
    _write_points(sheet, state, wrong, y)


def _write_points(sheet: Sheet, state: Mapping[str, Any], wrong: str | None, y: float) -> None:
    if not state["points"]:
        return
    ends = [_LEFT + share * _ROOM for share in (0.16, 0.44, 0.72, 1.0)]
    heads = ("floor_column.point", "floor_column.x", "floor_column.y", "floor_column.mm")
    for end, head in zip(ends, heads, strict=True):
        sheet.text((end, y), words(head), ink=QUIET, size=11, right=True)
    off = {} if state["fit"] is None else {p["name"]: p["mm"] for p in state["fit"]["points"]}
    for point in state["points"][:_MOST_ROWS]:
        y += 20
        name = str(point["number"])
        places = ["" if one is None else f"{one:g}" for one in point["place"]]
        error = f"{off[name]:.2f}" if name in off else ""
        ink = WARNING if name == wrong else TEXT
        for end, entry in zip(ends, (name, *places, error), strict=True):
            sheet.text((end, y), entry, ink=ink, size=11, right=True)
    if len(state["points"]) > _MOST_ROWS:
        sheet.text((ends[0], y + 18), "\N{HORIZONTAL ELLIPSIS}", ink=QUIET, right=True)
