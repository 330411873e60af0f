"""The panel that calibrates a floor: points or sheets in its picture, and their fit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from robsim._core import PlaneMap
from robsim.base.checks import check_float
from robsim.base.files import as_path
from robsim.base.text import one_line
from robsim.gui._link import (
    MAGNIFY,
    Link,
    Messages,
    magnified,
    maybe,
    number,
    point,
    switch,
    text,
    whole,
)
from robsim.gui.tools.floor.corners import FloorSheets, snapped
from robsim.gui.tools.floor.fitting import fit_of, fitted, grid_of, on_work_area, replaced
from robsim.gui.tools.floor.floor_sheet import floor_still
from robsim.gui.tools.floor.lens import LensPictures
from robsim.gui.tools.floor.points import MOST, FloorDraft, FloorPoints, checked_pixel
from robsim.gui.tools.pictures import Pictures
from robsim.gui.tools.tool import TOOL_MESSAGES, Acts, T, ToolView, file_to_save, refuse_device
from robsim.lab.calibration.floor_report import FloorCalibration
from robsim.lab.calibration.seen_sheets import SeenSheets
from robsim.vision.imaging import images
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import load_calibration, save_calibration

MESSAGES: Messages = {
    **TOOL_MESSAGES,
    "magnify": MAGNIFY,
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
    "load": {"file": text},
    "forget": {},
    "save": {"file": text},
}


#: The display and the source of the fit; "lens" fits the floor by the points.
WAYS = ("points", "sheets", "lens")
_FILL_REACH = 8.0  # px, around the expected corner of a grid
Pixel = tuple[float, float]


class FloorView(ToolView):
    """Calibrates a floor, by points placed on its picture or by sheets in the picture."""

    kind: ClassVar[str] = "floor"
    messages: ClassVar[Messages] = MESSAGES

    def __init__(
        self,
        source: Pictures,
        base: Calibration | None,
        draft: FloorDraft,
        file: Path,
        *,
        is_read: bool,  # whether `base` is from the file
    ) -> None:
        super().__init__(source)
        self.points = FloorPoints(draft)
        self.sheets = FloorSheets()
        self.base = base
        self.file = file
        self._files = {file.resolve()} if is_read else set()  # files read or written
        self.way = WAYS[0]
        self._chosen: int | None = None
        self._frames: tuple[int, int] | None = None
        self._fit_report: FloorCalibration | None = None  # of the last fit
        self._wrong = ""  # why the fit failed
        self._fitted: object = None  # the data of the last fit
        self.lens = LensPictures(self)
        self._fitting = self.beside("robsim floor fit")
        self._finding = self.beside("robsim floor sheets")
        self.begin()

    def handlers(self) -> Mapping[str, Callable[[Link, dict[str, Any]], None]]:
        return {**super().handlers(), "magnify": self._magnify}

    @property
    def history(self) -> FloorPoints:
        return self.points

    def changes(self) -> Acts:
        points = self.points
        return {
            "add": lambda m: self._add(m["at"], m["reach"]),
            "move": lambda m: points.move(m["point"], m["at"], goes_on=m["goes_on"]),
            "nudge": lambda m: points.nudge(m["point"], m["by"], goes_on=m["goes_on"]),
            "snap": lambda m: self.snap(m["point"], m["reach"]),
            "place": lambda m: points.place(m["point"], (m["x"], m["y"])),
            "cut": lambda m: self._cut(m["point"]),
            "clear": lambda _: points.clear(),
            "fill": lambda m: self.fill(m["step"]),
            "set": lambda m: self._set(m["name"], m["value"]),
            "choose": lambda m: self._choose(m["point"]),
            "sheet": lambda m: self.sheets.place(m["number"], m["x"], m["y"]),
            "by": lambda m: self.use(m["name"]),
        }

    def acts(self) -> Acts:
        return {
            **self.lens.acts(),
            "sheets": lambda _: self._find_sheets(),
            "load": lambda m: self.load(m["file"]),
            "forget": lambda _: self.take(None),
            "save": lambda m: self.note(
                f"written: {one_line(self.save(m['file'] or None))}", "info"
            ),
        }

    def look(self, now: float) -> float:
        self._fit_soon()
        return super().look(now)

    def tell(self, link: Link) -> None:
        super().tell(link)
        link.send(self.lens.message())

    def state(self) -> dict[str, Any]:
        draft = self.points.draft
        report = self._fit_report
        shown = self._shown_calibration()
        return {
            "points": [
                {"number": one.number, "at": [*one.pixel], "place": [*one.place]}
                for one in draft.points
            ],
            "chosen": self._chosen,
            "by": self.way,
            "sheets": self.sheets.state(),
            "area": [*draft.area],
            "mm_per_px": draft.mm_per_px,
            "marker_height": draft.marker_height,
            "grid": None if shown is None else grid_of(shown),
            "fit": None if report is None else fit_of(report),
            "problems": self._problems(),
            "remarks": [] if report is None else list(report.remarks),
            "pending": self._finding.is_busy or self._fitted != self._task(),
            "lens": _lens_state(self.base),
            "file": str(self.file),
            "cannot_save": self._why_not_saved(),
        }

    def still(self) -> Callable[[], bytes]:
        about = (self.picture, self.source.title, self._state())
        return partial(floor_still, *about, self._shown_calibration())

    def changed_picture(self) -> None:
        self._frames = images.frame_size(self.shown.frame.image)
        self.lens.changed_picture()

    # Changes; TypeError, ValueError or OSError: nothing changed.

    def change(self, change: Callable[[], T]) -> T:
        try:
            return change()
        finally:
            numbers = [one.number for one in self.points.draft.points]
            if self._chosen not in numbers:
                self._chosen = None
            self.tell_state()

    def add(self, pixel: Any, place: Any, reach: float) -> int:
        """Add a point, at the nearest corner or dot within reach (px), if any."""
        at = checked_pixel(pixel)
        found = self._snapped(at, reach) if reach > 0 else None
        number = self.points.add(at if found is None else found, place)
        self._chosen, self.way = number, WAYS[0]
        return number

    def snap(self, number: int, reach: float) -> None:
        """Move a point to the nearest corner or dot."""
        reach = check_float("reach", reach, "px", exclusive_minimum=0)
        found = self._snapped(self.points.point(number).pixel, reach)
        if found is None:
            raise ValueError(f"no corner or dot near point {number}")
        self.points.move(number, found)

    def fill(self, step: float) -> int:
        """Find the remaining corners of a grid in the picture, and add them."""
        draft = self.points.draft
        width, height = (side * draft.mm_per_px for side in draft.area)
        step = check_float("step", step, "mm", minimum=max(width, height) / 100)
        calibration = self.fit_report().calibration
        floor = calibration.floor
        assert floor is not None
        expected = self._grid_places(floor, step)
        if len(draft.points) + len(expected) > MOST:
            raise ValueError(
                f"step must be larger: the grid has {len(expected)} corners in the picture, but at "
                f"most {MOST} are allowed"
            )
        found = [
            (corner, place)
            for pixel, place in expected
            if (corner := self._snapped(pixel, _FILL_REACH))
        ]
        if not found:
            raise ValueError(f"no other corner found on a grid of {step:g} mm")
        self.points.extend(found)
        return len(found)

    def _grid_places(self, floor: PlaneMap, step: float) -> list[tuple[Pixel, Pixel]]:
        """Return the positions of a grid (mm) in the picture and on the floor, minus its points."""
        draft = self.points.draft
        width, height = images.frame_size(self.shown.frame.image)
        columns, rows = (int(side * draft.mm_per_px / step) + 1 for side in draft.area)
        places = [(column * step, row * step) for row in range(rows) for column in range(columns)]
        pixels = floor.to_pixel(np.array(places) / draft.mm_per_px).tolist()
        known = {one.place for one in draft.points}
        return [
            ((u, v), place)
            for (u, v), place in zip(pixels, places, strict=True)
            if place not in known and 0 <= u < width and 0 <= v < height
        ]

    def use(self, way: str) -> None:
        """Fit the floor by points or by sheets, or show the lens."""
        if way not in WAYS:
            raise ValueError(f"by must be one of {', '.join(WAYS)}")
        self.way = way

    def load(self, file: str | PathLike[str]) -> None:
        """Replace lens and floor by a calibration's."""
        path = as_path(file, "calibration")
        refuse_device(path)
        self.take(load_calibration(path))
        self._note_file(path)

    def take(self, calibration: Calibration | None) -> None:
        """Take lens and floor of a calibration; None = unknown."""
        self.base = calibration
        if calibration is not None and calibration.area and calibration.mm_per_px:
            self.points.adjust(
                area=calibration.area,
                mm_per_px=calibration.mm_per_px,
                marker_height=calibration.marker_height,
            )
        self.tell_state()

    def save(self, path: str | PathLike[str] | None = None) -> Path:
        """Write the calibration into a file, which becomes the panel's file."""
        file = file_to_save(self.file if path is None else path)
        calibration = self.calibration()
        there = replaced(file, calibration, is_known=file.resolve() in self._files)
        save_calibration(file, calibration)
        self._note_file(file)
        if there is not None and there.floor is not None and calibration.floor is None:
            self.note(
                f"{one_line(file)} had a floor for the replaced lens: calibrate the floor again",
                "info",
            )
        return file

    def _note_file(self, file: Path) -> None:
        """Note a file that was read or written, as the default for Save."""
        self.file = file
        self._files.add(file.resolve())
        self.tell_state()

    # Results.

    def fit_report(self) -> FloorCalibration:
        """Return the current fit; ValueError if something is missing or wrong."""
        task = self._task()
        if self._fitted != task:
            self._take_fit(task, self._fit(task))
        if self._fit_report is None:
            raise ValueError(self._wrong)
        return self._fit_report

    def calibration(self) -> Calibration:
        """Return the current calibration; ValueError if something is missing or wrong."""
        draft = self.points.draft
        if self.way == "sheets":
            return self.fit_report().calibration
        if not draft.points and self.base is not None:
            return on_work_area(self.base, draft)
        found = self.fit_report().calibration
        image = self.shown.frame.image
        try:
            return fitted(draft, self.base, found.size, image).calibration
        except ImportError:  # OpenCV is missing, so there are no sheets
            return found

    def _shown_calibration(self) -> Calibration | None:
        """Return the calibration for drawing the grid."""
        if self._fit_report is not None:
            return self._fit_report.calibration
        has_points = bool(self.points.draft.points) or self.way == "sheets"
        if self.base is None or self.base.floor is None or has_points:
            return None
        try:
            return on_work_area(self.base, self.points.draft)
        except ValueError:  # such as a height above the camera
            return None

    def _problems(self) -> list[str]:
        draft = self.points.draft
        if self.way == "sheets":
            said = [self._wrong] if self._wrong else []
        elif not draft.points and self.base is not None and self.base.floor is not None:
            said = []
        else:
            said = draft.problems() or ([self._wrong] if self._wrong else [])
        if self._fit_report is not None:
            said += [one.sentence for one in self._fit_report.problems]
        return said

    def _why_not_saved(self) -> str:
        """Return why the calibration cannot be saved and the remedy; empty if it can."""
        is_lens_alone = self.base is not None and self.base.floor is None
        has_points = bool(self.points.draft.points) or self.way == "sheets"
        if self._shown_calibration() is not None or (is_lens_alone and not has_points):
            return ""
        if self.way == "lens" and not has_points:
            return "take pictures of the board, and press Use this lens when the fit is good"
        return "; ".join(self._problems()) or "the calibration is not ready yet"

    # Fits: in a separate thread, always with the newest data.

    def _task(self) -> tuple[Any, ...]:
        by = self.sheets.task() if self.way == "sheets" else None
        return (self.way, self.points.draft, self.base, self._frames, by)

    def _fit(self, task: tuple[Any, ...]) -> FloorCalibration | str:
        """Return a fit, or the reason for its absence; any thread."""
        way, draft, base, size, by = task
        try:
            if size is None:
                return "there is no picture yet"
            if way == "sheets":
                if not by.corners:
                    return "no sheets found yet; press Find sheets"
                found: FloorCalibration = by.floor(
                    area=draft.area,
                    mm_per_px=draft.mm_per_px,
                    marker_height=draft.marker_height,
                    lens=base,
                )
                return found
            return fitted(draft, base, size)
        except (TypeError, ValueError, ImportError) as error:
            return str(error)

    def _fit_soon(self) -> None:
        task = self._task()
        if self._fitted == task or self._fitting.is_busy:
            return
        way, draft, *_ = task
        if way != "sheets" and draft.problems() and len(draft.complete) < 4:
            self._take_fit(task, "; ".join(draft.problems()))  # known without a fit
            self.tell_state()
            return

        def take(found: FloorCalibration | str | None) -> None:
            if self._fitted == self._task():
                return  # another thread fitted meanwhile
            self._take_fit(task, "the fit failed" if found is None else found)
            self.tell_state()

        self._fitting.begin(lambda: self._fit(task), take)

    def _take_fit(self, task: tuple[Any, ...], found: FloorCalibration | str) -> None:
        self._fitted = task
        self._wrong = found if isinstance(found, str) else ""
        self._fit_report = None if isinstance(found, str) else found

    # Messages.

    def _add(self, at: tuple[float, float], reach: float) -> None:
        if self.picture is None:
            raise ValueError("there is no picture yet")
        self.add(at, None, reach)

    def _cut(self, number: int) -> None:
        points = [one.number for one in self.points.draft.points]
        self.points.remove(number)
        if self._chosen == number and len(points) > 1:
            at = points.index(number)
            self._chosen = points[at - 1] if at else points[1]

    def _choose(self, number: int | None) -> None:
        self._chosen = None if number is None else self.points.point(number).number

    def _set(self, name: str, value: float) -> None:
        draft = self.points.draft
        if name in ("width", "height"):
            at = ("width", "height").index(name)
            area: list[float] = [*draft.area]
            area[at] = int(value) if value.is_integer() else value
            self.points.adjust(area=area)
        elif name in ("mm_per_px", "marker_height"):
            self.points.adjust(**{name: value})
        elif name == "mark":
            self.sheets.adjust(value)
        else:
            raise ValueError("unknown setting")

    def _find_sheets(self) -> None:
        image = self.shown.frame.image
        if self._finding.is_busy:
            raise ValueError("the previous picture is still being processed")

        def take(found: SeenSheets | str | None) -> None:
            self.way = "sheets"
            if isinstance(found, str):
                self.note(found)
            elif found is not None:
                self.sheets.take(found)
            self.tell_state()

        self._finding.begin(self.sheets.looking(image), take)
        self.tell_state()

    def find_sheets(self) -> None:
        """Find the sheets in the picture, and fit the floor by them."""
        found = self.sheets.looking(self.shown.frame.image)()
        if isinstance(found, str):
            raise ValueError(found)
        self.sheets.take(found)
        self.way = "sheets"

    def _magnify(self, link: Link, message: dict[str, Any]) -> None:
        """Send the pixels around a point."""
        if self.picture is None:
            return
        box, part = magnified(self.picture.frame.image, message)
        link.send({"type": "detail", "glass": message["glass"], "box": box}, [part.tobytes()])

    def _snapped(self, at: tuple[float, float], reach: float) -> tuple[float, float] | None:
        if self.picture is None:
            return None
        return snapped(self.picture.frame.image, at, reach)


def _lens_state(base: Calibration | None) -> dict[str, Any] | None:
    if base is None or base.intrinsics is None:
        return None
    residuals = base.lens_residuals
    return {"rms": None if residuals is None else residuals.rms, "size": [*base.size]}
