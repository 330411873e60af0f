"""The panel that defines a robot: picture, polygons, heading, size and name."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import PurePath
from typing import Any, ClassVar

from robsim._core import ColorClass
from robsim.base.checks import check_float
from robsim.base.text import quoted
from robsim.gui._css_colors import css_color
from robsim.gui._link import Messages, number, point, switch, text, whole
from robsim.gui.tools.pictures import OnePicture, Picture, Pictures
from robsim.gui.tools.robots.drawing import RobotDrawing, cut_out
from robsim.gui.tools.robots.robots_sheet import robots_still
from robsim.gui.tools.tool import TOOL_MESSAGES, Acts, ToolView
from robsim.vision.imaging import images
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import (
    as_robot,
    default_robot,
    robot_names,
    set_default_robot,
    user_robots,
)
from robsim.vision.robots.sketch import OUTLINE, Sketch, is_cut_out, over_floor
from robsim.vision.robots.user_robots import add_robot, check_new_name

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
    "reset": {},
    "save": {"name": text, "overwrite": switch},
}


_SQUARE = 0.4  # of the shorter side of a picture
_SMALLEST = 8.0  # px
_NAME = "mine"
_OUTLINE_INK = "#ffd500"
_OTHER_INK = "#d6409f"  # of a marker with an unknown colour


class RobotsView(ToolView):
    """Defines a robot, from a captured picture or an existing robot."""

    kind: ClassVar[str] = "robots"
    messages: ClassVar[Messages] = MESSAGES

    def __init__(
        self,
        source: Pictures | None,
        robot: RobotDefinition,
        colors: Iterable[ColorClass],
        *,
        begins_live: bool = True,  # with the pictures of the source, not the robot
    ) -> None:
        drawn = OnePicture(over_floor(robot.image), robot.name)
        super().__init__(drawn if source is None else source)
        self._as_loaded = Sketch.of(robot)
        self._begun = self._as_loaded  # the drawing after Reset
        self.drawing = RobotDrawing(self._as_loaded)
        self.name = robot.name
        self._of: str | None = robot.name  # the robot of the drawing; None = from a picture
        self._first = self._loaded = robot
        self._colors = tuple(colors)
        self._part = OUTLINE
        self._square: tuple[float, float, float] | None = None  # centre and side (px)
        self._has_pictures = source is not None
        self.is_frozen = not begins_live or source is None  # shows the drawing
        self.begin()
        if self.is_frozen:
            self.post(self._show_drawing)

    @property
    def history(self) -> RobotDrawing:
        return self.drawing

    def changes(self) -> Acts:
        drawing = self.drawing
        return {
            "move": lambda m: drawing.move(self._part, m["corner"], m["at"], goes_on=m["goes_on"]),
            "insert": lambda m: drawing.insert(self._part, m["corner"], m["at"]),
            "cut": lambda m: drawing.remove(self._part, m["corner"]),
            "clear": lambda _: drawing.put(self._part, []),
            "guess": lambda _: drawing.go_to(drawing.sketch.guessed(self._part, self._colors)),
            "turn": lambda m: drawing.turn(m["degrees"]),
            "face": lambda m: drawing.face(m["at"], goes_on=m["goes_on"]),
            "resize": lambda m: drawing.resize(m["size"]),
            "scale": lambda m: drawing.scale(m["one"], m["other"], m["distance"]),
        }

    def acts(self) -> Acts:
        return {
            "load": lambda m: self.load(_listed(m["name"])),
            "square": lambda m: self._put_square(m["at"], m["side"]),
            "capture": lambda _: self.capture(),
            "capture_whole": lambda _: self.capture(whole=True),
            "resume": lambda _: self._resume(),
            "no_camera": lambda _: self._show_drawing(),
            "reset": lambda _: self._reset(),
            "part": lambda m: self._choose(m["name"]),
            "save": lambda m: self._save(m["name"], m["overwrite"]),
        }

    def state(self) -> dict[str, Any]:
        sketch = self.drawing.sketch
        return {
            "mode": "draw" if self.is_frozen else "capture",
            "can_capture": self._can_capture,
            "square": self._square and [*self._square],
            "name": self.name,
            "robots": robot_names(),
            "part": self._part,
            "parts": {part: corners.tolist() for part, corners in sketch.parts.items()},
            "roles": sketch.roles,
            "inks": self._inks(),
            "centre": sketch.middle.tolist(),
            "alignment": sketch.alignment,
            "turned": sketch.alignment if self.is_frozen else 0.0,
            "size": sketch.size,
            "problems": sketch.problems(),
        }

    def still(self) -> Callable[[], bytes]:
        return partial(robots_still, self.picture, self.source.title, self._state())

    def changed_source(self) -> None:
        self._square = None  # the square belongs to the previous pictures

    def changed_picture(self) -> None:
        if self._square is None and self.picture is not None and not self.is_frozen:
            height, width = self.picture.frame.image.shape[:2]
            middle = (width / 2, height / 2, _SQUARE * min(width, height))
            self._square = self.source.robot_in(self.picture) or middle

    # Changes; TypeError, ValueError or OSError: nothing changed.

    def load(self, robot: RobotDefinition) -> None:
        """Draw on an existing robot."""
        self._as_loaded = Sketch.of(robot)
        self._begun = self._as_loaded
        self.drawing.begin(self._begun)
        self.name = self._of = robot.name
        self._loaded = robot
        self._show_drawing()

    def capture(self, *, whole: bool = False) -> None:
        """Draw on the square or on all of the live picture, with initial guesses."""
        if self.picture is None or self._square is None or self.is_frozen:
            raise ValueError("there is no live picture to capture")
        image = self.picture.frame.image
        pixels = image if whole else cut_out(image, self._square)
        sketch = Sketch.of_picture(pixels, self.drawing.sketch.size, self._colors)
        self._draw_on(sketch)
        if not any(len(corners) for corners in sketch.markers.values()):
            where = "picture" if whole else "square"
            self.note(f"no robot in the {where}: capture again, or draw by hand", "warning")

    def loading(self, pixels: images.Pixels, name: str) -> Callable[[], object]:
        if not is_cut_out(pixels):
            return super().loading(pixels, name)
        sketch = Sketch.of_picture(pixels, 1.0, self._colors)

        stem = PurePath(name).stem
        return lambda: self._draw_on(replace(sketch, size=self.drawing.sketch.size), stem)

    def go_back(self) -> None:
        if not self._has_pictures:
            raise ValueError("there is no camera to return to")
        self._left = None, False  # not the drawing, which may have changed
        super().go_back()

    @property
    def back(self) -> str | None:
        return super().back if self._has_pictures else None

    def look_at(self, k: int) -> None:
        if self.is_frozen:
            raise ValueError("the panel shows the drawing; press Capture again for the pictures")
        super().look_at(k)

    def freeze(self, on: bool) -> None:
        raise ValueError("this tool cannot freeze a picture: use capture() instead")

    def definition(self) -> RobotDefinition:
        """Return the robot in the drawing; ValueError if it is incomplete."""
        if self.drawing.sketch is self._as_loaded:
            return self._loaded  # includes fields outside of the drawing
        return self.drawing.sketch.definition(self.name)

    def save(self, name: str, *, overwrite: bool = False) -> RobotDefinition:
        """Save the robot to the user's robots, which survive a restart."""
        robot = add_robot(
            name, self.drawing.sketch.definition(name), overwrite=overwrite, ignore_colors=True
        )
        self.name = self._of = robot.name
        self._loaded = robot
        self._begun = self._as_loaded = self.drawing.sketch
        self.tell_state()
        return robot

    def named(self) -> RobotDefinition:
        """Return the robot in the drawing; a changed robot gets a free name."""
        if self.drawing.sketch is not self._as_loaded and not self._is_mine:
            self.name = _free_name(self.name)
        return self.definition()

    def keep(self) -> str:
        """Save the changes, and make the robot the default; return a summary."""
        done = []
        if self.drawing.sketch is not self._as_loaded:
            self.save(self.name, overwrite=self._is_mine)
            done.append(f"saved as {self.name}")
        elif self._loaded is self._first or not self._is_stored:
            return ""
        if self.name != default_robot():
            set_default_robot(self.name)
            done.append(f"{self.name} is now the default robot")
        return "; ".join(done)

    @property
    def _is_stored(self) -> bool:
        """Whether the robot of the drawing is stored under its name."""
        return self._of in robot_names() and as_robot(self._of) == self._loaded

    @property
    def _is_mine(self) -> bool:
        return self._of in user_robots() and self._is_stored

    @property
    def _can_capture(self) -> bool:
        return self._has_pictures or self.is_replaced

    def _reset(self) -> None:
        if self.drawing.sketch is not self._begun:
            self.drawing.go_to(self._begun)
        self._show_drawing()

    def _draw_on(self, sketch: Sketch, name: str = _NAME) -> None:
        self._begun = sketch
        self.drawing.begin(sketch)
        self.name, self._of = _free_name(name), None
        self._part = OUTLINE
        self._show_drawing()

    def _choose(self, part: str) -> None:
        self.drawing.sketch.part(part)  # raises for an unknown part
        self._part = part
        self.tell_state()

    def _inks(self) -> dict[str, str]:
        """Return the ink of each part: a marker has its colour."""
        known = {color.name: css_color(color) for color in self._colors}
        colors = self.drawing.sketch.markers
        return {OUTLINE: _OUTLINE_INK, **{name: known.get(name, _OTHER_INK) for name in colors}}

    def _put_square(self, at: tuple[float, float], side: float) -> None:
        height, width = self.shown.frame.image.shape[:2]
        side = check_float("side", min(side, width, height), "px", minimum=_SMALLEST)
        u = min(max(at[0], side / 2), width - side / 2)
        v = min(max(at[1], side / 2), height - side / 2)
        self._square = (u, v, side)
        self.tell_state()

    def _resume(self) -> None:
        if not self._can_capture:
            raise ValueError("there is no camera to return to")
        self.is_frozen = False
        if self.is_replaced:
            self.show(self.source.at(0))
        self._show()
        self.tell_state()

    def _save(self, name: str, overwrite: bool) -> None:
        self.note(f"saved as {self.save(name, overwrite=overwrite).name}", "info")

    def _show_drawing(self) -> None:
        self.is_frozen = True
        self.show(Picture(over_floor(self.drawing.sketch.image), self.name))
        self.tell_state()


def _listed(name: str) -> RobotDefinition:
    """Return a robot of the list: browsers must not name folders."""
    if name not in robot_names():
        raise ValueError(f"unknown robot {quoted(name)}")
    return as_robot(name)


def _free_name(name: str) -> str:
    """Return an unused robot name: `name` itself, or a variant marked as the user's own."""
    for one in itertools.chain([name, _NAME], (f"{_NAME}{n}" for n in itertools.count(2))):
        with suppress(ValueError):
            check_new_name(one, overwrite=False)
            return one
    raise AssertionError("numbers do not end")
