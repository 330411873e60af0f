"""The panel that trains colours: regions of the picture, classes, detections, messages."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

from PIL import Image

from robsim._core import ColorClass, Frame, MarkerLayout, color_histograms
from robsim.base.text import quoted
from robsim.gui._link import Link, Messages, Refused, list_of, setting, switch, text, whole
from robsim.gui.tools.colors.colors_sheet import colors_still
from robsim.gui.tools.colors.training import (
    OPTIONS,
    ColorTraining,
    Region,
    found_in,
    painted,
    ranges_of,
)
from robsim.gui.tools.pictures import Picture, Pictures
from robsim.gui.tools.tool import TOOL_MESSAGES, Acts, T, ToolView, file_to_save
from robsim.vision.imaging import images
from robsim.vision.markers.color_files import colors_of_text, colors_to_toml, save_colors
from robsim.vision.markers.color_score import score_color
from robsim.vision.markers.painting import paint_of
from robsim.vision.robots.definition import RobotDefinition

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
    "region": {"region": _exactly(4, whole), "keep": whole, "goes_on": switch},
    "ranges": {"ranges": _exactly(3, _exactly(2, whole)), "goes_on": switch},
    "set": {"name": text, "value": setting, "goes_on": switch},
    "thresholds": {"text": _long_text},
    "remove": {},
    "score": {},
    "save": {"file": text},
}


_ALPHA = 200  # of a class's pixels, on the picture


class ColorsView(ToolView):
    """Trains colour classes on pictures."""

    kind: ClassVar[str] = "colors"
    messages: ClassVar[Messages] = MESSAGES

    def __init__(
        self, source: Pictures, colors: Iterable[ColorClass], robot: RobotDefinition, file: Path
    ) -> None:
        super().__init__(source)
        self.training = ColorTraining(colors)
        self.file = file
        self._known = set(self.training.classes)  # classes that the file may contain
        self._markers = robot.marker_layout()
        self._chosen = next(iter(self.training.classes), "red")
        self._region: Region | None = None
        self._tests = True
        self._beside = self.beside("robsim colour score")
        self.begin()

    def acts(self) -> Acts:
        return {
            "choose": lambda message: self.choose(message["name"]),
            "region": lambda m: self._train(tuple(m["region"]), m["keep"], goes_on=m["goes_on"]),
            "ranges": lambda m: self._set_ranges(m["ranges"], goes_on=m["goes_on"]),
            "set": lambda m: self._set(m["name"], m["value"], goes_on=m["goes_on"]),
            "thresholds": lambda message: self._take_text(message["text"]),
            "score": lambda _: self._score(),
            "save": lambda m: self.note(
                f"written: {self.save(m['file'] or None).absolute()}", "info"
            ),
        }

    @property
    def history(self) -> ColorTraining:
        return self.training

    def changes(self) -> Acts:
        return {"remove": lambda _: self.training.remove(self._chosen)}

    def tell(self, link: Link) -> None:
        super().tell(link)
        self._tell_histograms()

    def state(self) -> dict[str, Any]:
        return {
            "chosen": self._chosen,
            "classes": [self._class_of(name) for name in self.training.classes],
            "options": self.training.options(self._chosen),
            "text": colors_to_toml(self.training.value) if self.training.classes else "",
            "file": str(self.file),
            "place": str(self.file.absolute()),
            "region": self._region and [*self._region],
            "tests": self._tests,
        }

    def head(self, picture: Picture) -> tuple[dict[str, Any], list[bytes]]:
        colors = self.training.value
        if not (self._tests and colors):
            return {"boxes": [], "found": None, "missed": None}, []
        found = found_in(picture.frame, colors, self._markers)
        return found, [_mask(picture.frame, colors, self._markers)]

    def still(self) -> Callable[[], bytes]:
        about = (self.picture, self.source.title, self._state())
        return partial(colors_still, *about, self.training.value, self._markers)

    def changed_picture(self) -> None:
        if self.is_frozen or not self.source.is_live:
            self._tell_histograms()

    def changed_source(self) -> None:
        self._region = None  # the region belongs to the previous pictures

    def _class_of(self, name: str) -> dict[str, Any]:
        one = self.training.classes[name]
        drift = [
            {"picture": picture, "medians": medians.tolist(), "share": share}
            for picture, medians, share in self.training.drift(name)
        ]
        number = list(self.training.classes).index(name)
        return {
            "name": name,
            "css": "rgb({}, {}, {})".format(*paint_of(name, number)),
            "ranges": [list(ends) for ends in ranges_of(one.color)],
            "drift": drift,
        }

    # Changes of the classes; TypeError, ValueError or OSError: nothing changed.

    def choose(self, name: str) -> None:
        """Choose a class, or a new one, for training."""
        ColorClass(name)  # raises for an invalid name
        if name != self._chosen:
            self._chosen, self._region = name, None
        self.tell_state()

    def train(self, name: str, region: Region, *, more: bool = False) -> ColorClass:
        """Make a class from a region of the picture."""
        self.choose(name)
        known = self.training.classes.get(name)
        return self._train(region, len(known.samples) if known and more else 0)

    def change(self, change: Callable[[], T]) -> T:
        done = super().change(change)
        self.show_again()
        return done

    def travel(self, step: Callable[[], None]) -> None:
        def there() -> None:
            step()
            one = self.training.classes.get(self._chosen)
            last = one.samples[-1] if one and one.samples else None
            is_seen = last and self.picture and last.picture == self.picture.name
            self._region = last.region if last and is_seen else None

        self.change(there)
        self._tell_histograms()

    def save(self, path: str | PathLike[str] | None = None) -> Path:
        """Write the classes into a file, which becomes the panel's file."""
        file = file_to_save(self.file if path is None else path)
        if not self.training.value:
            raise ValueError("no colours yet: mark a region of the picture")
        names = {color.name for color in self.training.value}
        save_colors(file, self.training.value, remove=self._known - names)
        self.file, self._known = file, names
        self.tell_state()
        return file

    def _train(self, region: Region, keep: int, *, goes_on: bool = False) -> ColorClass:
        name, picture = self._chosen, self.shown
        image = picture.frame.image
        color_histograms(image, region)  # raises for an invalid region
        self._region = region
        self._tell_histograms()
        self.change(
            lambda: self.training.train(
                name, image, region, picture=picture.name, keep=keep, goes_on=goes_on
            )
        )
        return self.training.classes[name].color

    def _score(self) -> None:
        """Send the score of the class under other light and noise, after computing it."""
        one = self.training.classes.get(self._chosen)
        picture, region = self.picture, self._region
        if one is None or picture is None or region is None:
            raise ValueError("mark a region of the picture first: the test uses this region")
        if self._beside.is_busy:
            raise ValueError("the previous test is still running")
        image, color = picture.frame.image, one.color
        color_histograms(image, region)  # raises for a region of a previous, larger picture

        def tell(message: dict[str, Any] | None) -> None:
            if message is not None:
                self.send(message)

        self._beside.begin(lambda: _score_message(image, color, region), tell)

    def _take_text(self, text: str) -> None:
        try:
            colors = colors_of_text(text)
        except ValueError as error:
            raise ValueError(f"thresholds: {error}") from None
        self.change(lambda: self.training.replace(colors))

    def _set_ranges(self, ranges: list[list[int]], *, goes_on: bool) -> None:
        y, u, v = ((low, high) for low, high in ranges)
        color = ColorClass(self._chosen, y=y, u=u, v=v)
        self.change(lambda: self.training.put(color, goes_on=goes_on))

    def _set(self, name: str, value: Any, *, goes_on: bool) -> None:
        if name == "tests" and isinstance(value, bool):
            self._tests = value
            self.change(lambda: None)
            return
        if name not in OPTIONS:
            raise ValueError(f"unknown setting {quoted(name)}")
        if name == "margin" and isinstance(value, float) and value.is_integer():
            value = int(value)  # JSON has only floats
        self.change(lambda: self.training.adjust(self._chosen, goes_on=goes_on, **{name: value}))

    def _tell_histograms(self) -> None:
        """Send the histograms of the marked region in the displayed picture."""
        if self.picture is None or self._region is None:
            return
        try:
            counts = color_histograms(self.picture.frame.image, self._region)
        except ValueError:  # region of a picture of another size
            return
        head = {"type": "histograms", "region": [*self._region]}
        self.send(head, counts.astype("<f4").tobytes())


def _score_message(image: images.Pixels, color: ColorClass, region: Region) -> dict[str, Any]:
    score = score_color(image, color, [region], repeats=2)
    return {
        "type": "score",
        "name": score.color.name,
        "rate": score.rate,
        "widened_rate": score.widened_rate,
        "margin": score.margin,
        "remarks": [*score.remarks],
        "ranges": [list(ends) for ends in ranges_of(score.proposed)],
        "levels": [
            {"name": sweep.name, "levels": list(sweep.levels), "rates": list(sweep.rates)}
            for sweep in score.sweeps
        ],
    }


def _mask(frame: Frame, colors: Sequence[ColorClass], markers: MarkerLayout) -> bytes:
    """Return the class of each pixel as a picture to overlay (PNG)."""
    index, inks = painted(frame, colors, markers)
    shown = Image.fromarray(index, "P")
    shown.putpalette([0, 0, 0, *(part for ink in inks for part in ink)])
    out = io.BytesIO()
    alpha = bytes([0, *[_ALPHA] * len(inks)])
    bits = next(bits for bits in (1, 2, 4, 8) if len(inks) < 1 << bits)  # fewer bits are faster
    shown.save(out, "PNG", transparency=alpha, bits=bits, compress_level=1)
    return out.getvalue()
