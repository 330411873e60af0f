"""The still picture of the panel that trains colours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import ColorClass, Frame, MarkerLayout, color_histograms
from robsim.gui.hosts.script import words
from robsim.gui.tools.colors.training import found_in, painted
from robsim.gui.tools.pictures import Picture
from robsim.gui.tools.sheet import ACCENT, CHOSEN, LINE, QUIET, WARNING, Sheet, Shown

_WIDTH, _HEIGHT = 1000, 500
_SIDE = 455  # of the picture
_LEFT = 480  # of the text column
_RIGHT = _WIDTH - 12
_PLOT = (_LEFT + 22, _RIGHT - 84)  # of a histogram, from left to right
_HIGH = 58  # of a histogram
_REGION = "#ffd500"
_MOST_LINES, _MOST_COLUMNS = 7, 3  # of the thresholds, a class in each column


def colors_still(
    picture: Picture | None,
    title: str,
    state: Mapping[str, Any],
    colors: Sequence[ColorClass],
    markers: MarkerLayout,
) -> bytes:
    """Return a picture of the classes and their finds (PNG)."""
    sheet = Sheet(_WIDTH, _HEIGHT)
    frame = None if picture is None else picture.frame
    end = sheet.title("colors", title)
    if state["frozen"]:
        sheet.text((end + 10, 16), words("freeze"), ink=ACCENT)
    shown = Shown(frame, _SIDE)
    verdict = None
    if frame is not None and state["tests"] and colors:
        verdict = _draw_test(shown, frame, state, colors, markers)
    if state["region"]:
        shown.rectangle(state["region"], _REGION)
    sheet.show(shown, _SIDE, _SIDE)
    if verdict is not None:
        _write_verdict(sheet, *verdict)
    _write_classes(sheet, state)
    _draw_channels(sheet, frame, state)
    _write_options(sheet, state)
    _write_thresholds(sheet, state)
    return sheet.png()


def _draw_test(
    shown: Shown,
    frame: Frame,
    state: Mapping[str, Any],
    colors: Sequence[ColorClass],
    markers: MarkerLayout,
) -> tuple[str, bool]:
    """Draw the classes of the pixels; return the verdict on the robot."""
    shown.paint(*painted(frame, colors, markers))
    inks = {one["name"]: one["css"] for one in state["classes"]}
    found = found_in(frame, colors, markers)
    for name, *sides in found["boxes"]:
        shown.rectangle(sides, inks[name], 1)
    if not found["found"]:
        return words("not_seen", why=found["missed"]), False
    if found["missed"]:
        return words("found_robot_why", why=found["missed"]), True
    return words("found_robot"), True


def _write_verdict(sheet: Sheet, text: str, is_good: bool) -> None:
    ink, ground = ("#166b2f", "#dcf3e2") if is_good else (WARNING, "#fbefd0")
    rows = sheet.rows(text, _SIDE - 40)
    wide = max(sheet.length(row) for row in rows)
    sheet.box((14, 42, 34 + wide, 52 + 17 * len(rows)), fill=ground, radius=9)
    for i, row in enumerate(rows):
        sheet.text((24, 56 + 17 * i), row, ink=ink)


def _write_classes(sheet: Sheet, state: Mapping[str, Any]) -> None:
    x = float(_LEFT)
    for one in state["classes"]:
        is_chosen = one["name"] == state["chosen"]
        kind = "bold" if is_chosen else "regular"
        wide = sheet.length(one["name"], kind) + 36
        if x + wide > _RIGHT:
            break
        look = (CHOSEN, ACCENT) if is_chosen else ("white", LINE)
        sheet.box((x, 34, x + wide, 60), fill=look[0], line=look[1], radius=13)
        sheet.dot((x + 15, 47), 5, one["css"])
        sheet.text((x + 26, 47), one["name"], kind=kind)
        x += wide + 7
    if state["chosen"] not in [one["name"] for one in state["classes"]]:
        sheet.text((x + 4, 47), f"{state['chosen']}: {words('region_hint')}", ink=QUIET)


def _draw_channels(sheet: Sheet, frame: Frame | None, state: Mapping[str, Any]) -> None:
    counts = None
    if frame is not None and state["region"]:
        try:
            counts = color_histograms(frame.image, tuple(state["region"]))
        except ValueError:  # region of a picture of another size
            counts = None
    ranges = next(
        (one["ranges"] for one in state["classes"] if one["name"] == state["chosen"]), None
    )
    for i, channel in enumerate("YUV"):
        top = 72 + i * (_HIGH + 8)
        of_channel = None if counts is None else counts[i]
        _draw_channel(sheet, top, of_channel, None if ranges is None else ranges[i])
        sheet.text((_LEFT, top + _HIGH / 2), channel, ink=QUIET)


def _draw_channel(sheet: Sheet, top: float, counts: Any, ends: Sequence[int] | None) -> None:
    left, right = _PLOT
    level = (right - left) / 256
    sheet.box((left, top, right, top + _HIGH), line=LINE, radius=3)
    if ends is not None:
        low, high = left + level * ends[0], left + level * (ends[1] + 1)
        sheet.box((low, top + 1, high, top + _HIGH - 1), fill=CHOSEN)
        sheet.text((_RIGHT, top + _HIGH / 2), f"{ends[0]} \N{EN DASH} {ends[1]}", right=True)
    if counts is not None:
        for value in np.flatnonzero(counts).tolist():
            x, y = left + level * value, top + _HIGH - 2
            tall = max(1.0, (_HIGH - 6) * float(counts[value] / counts.max()))
            sheet.box((x, y - tall, x + level, y), fill=QUIET)
    if ends is not None:
        for x in (low, high):
            sheet.box((x - 1, top, x + 1, top + _HIGH), fill=ACCENT)


def _write_options(sheet: Sheet, state: Mapping[str, Any]) -> None:
    options, y = state["options"], 284
    is_on = "\N{CHECK MARK}" if options["limit_y"] else "\N{EN DASH}"
    texts = (f"{options['percentile']:g} %", f"{options['margin']}", is_on)
    names = ("percentile", "margin", "limit_y")
    for i, (name, text) in enumerate(zip(names, texts, strict=True)):
        x = _LEFT + 165 * i
        end = sheet.text((x, y), words(f"control.{name}"), ink=QUIET)
        sheet.text((end + 8, y), text)


def _write_thresholds(sheet: Sheet, state: Mapping[str, Any]) -> None:
    sheet.text((_LEFT, 312), words("thresholds"), kind="bold")
    sheet.box((_LEFT, 326, _RIGHT, 462), line=LINE, radius=4)
    for i, one in enumerate(state["text"].strip().split("\n\n")[:_MOST_COLUMNS]):
        for j, line in enumerate(one.splitlines()[:_MOST_LINES]):
            sheet.text((_LEFT + 10 + 165 * i, 341 + 18 * j), line, kind="mono", size=11)
    end = sheet.text((_LEFT, 479), words("color_file"), ink=QUIET)
    sheet.text((end + 8, 479), Path(state["file"]).name)
