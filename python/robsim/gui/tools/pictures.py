"""Where the pictures of a tool come from: a picture, a recording, a camera, a run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import Frame, PlaneMap, Step
from robsim.base.files import as_path
from robsim.base.text import one_line, quoted
from robsim.gui._driver import Driver
from robsim.gui._link import FrameClock
from robsim.gui.facade import Panel, is_shown, panel
from robsim.lab.cameras.camera import Camera
from robsim.lab.cameras.errors import CaptureError, EndOfStream, FrameTimeoutError
from robsim.simulation import Experiment, Simulation
from robsim.vision.imaging.images import Pixels, check_pixels, decoded, image_suffixes, load_image
from robsim.vision.imaging.recordings import Recording
from robsim.vision.robots.definition import RobotDefinition

_PATIENCE = 0.5  # s for a frame, before it is looked whether all is over


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of a source.

    Attributes
    ----------
    frame : Frame
        Its pixels.
    name : str
        What people call it.
    k : int or None
        Its number in the source; None = it has none.
    """

    frame: Frame
    name: str
    k: int | None = None


class Pictures:
    """A source of pictures; those that are live tell of each new one, in a thread of their own."""

    #: Whether new ones come by themselves.
    is_live = False
    #: How many there are to be looked at; None = only the newest one.
    count: int | None = None

    def __init__(self, title: str) -> None:
        self.title = title

    @property
    def kind(self) -> str:
        """What browsers call it: live, recording or picture."""
        if self.is_live:
            return "live"
        return "recording" if self.count else "picture"

    def at(self, k: int) -> Picture:
        """Return one of several; the number is within `count`."""
        raise LookupError(f"{self.title} has its newest picture alone")

    def begin(self, take: Callable[[Picture], object], fail: Callable[[str], object]) -> None:
        """Tell of the pictures from now on, and of what ends them, in any thread."""
        take(self.at(0))

    def settle(self) -> None:
        """Wait until the pictures that are known by now have been told of."""

    def close(self) -> None:
        """Tell of no more; what belongs to the user stays open."""


class OnePicture(Pictures):
    """A picture that stays as it is."""

    def __init__(self, image: Frame | Pixels, title: str) -> None:
        super().__init__(title)
        self._picture = Picture(image if isinstance(image, Frame) else Frame(image), title)

    def at(self, k: int) -> Picture:
        return self._picture


class RecordedPictures(Pictures):
    """The frames of a recording."""

    def __init__(self, recording: Recording) -> None:
        super().__init__(recording.source.name)
        self._recording = recording
        self.count = recording.count

    def at(self, k: int) -> Picture:
        return Picture(self._recording._at(k), f"frame {k}", k)


class CameraPictures(Pictures):
    """What a camera sees, which is read in a thread."""

    is_live = True

    def __init__(self, camera: Camera) -> None:
        super().__init__(one_line(camera.source))
        self._camera = camera
        self._is_over = threading.Event()
        self._thread: threading.Thread | None = None

    def begin(self, take: Callable[[Picture], object], fail: Callable[[str], object]) -> None:
        def read() -> None:
            while not self._is_over.is_set():
                try:
                    frame = self._camera.read(_PATIENCE)
                except FrameTimeoutError:
                    continue
                except (EndOfStream, CaptureError, ValueError) as error:
                    fail(str(error))
                    return
                take(Picture(frame, f"frame {frame.index}"))

        self._thread = threading.Thread(target=read, name="robsim pictures", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._is_over.set()
        if self._thread is not None:
            self._thread.join(4 * _PATIENCE)


class RunPictures(Pictures):
    """What the camera of a run sees, while a panel drives it.

    Parameters
    ----------
    driver : Driver
        That of the panel.
    title : str
        What people call the run.
    mine : Panel or None
        The panel, if it was opened for this: it is closed with it.
    """

    is_live = True

    def __init__(self, driver: Driver, title: str, mine: Panel | None = None) -> None:
        super().__init__(title)
        self._driver, self._mine = driver, mine
        self._clock = FrameClock()
        self._take: Callable[[Picture], object] = lambda _: None

    def begin(self, take: Callable[[Picture], object], fail: Callable[[str], object]) -> None:
        self._take, self._fail = take, fail
        self._driver.on_step.append(self._look)
        self._driver.on_state.append(self._watch)
        self._driver.prepare()

    def settle(self) -> None:
        self._driver.ask(lambda: None)

    def close(self) -> None:
        if self._look in self._driver.on_step:
            self._driver.on_step.remove(self._look)
            self._driver.on_state.remove(self._watch)
        if self._mine is not None:
            self._mine.close()

    def _watch(self, driver: Driver) -> None:
        """In the thread of the run."""
        if driver.state == "closed":
            self._fail("the panel of the run was closed")

    def _look(self, step: Step) -> None:
        """In the thread of the run."""
        now = time.monotonic()
        if step.frame is None or (now < self._clock.due and self._driver.state == "running"):
            return
        self._clock.sent(now)
        self._take(Picture(step.frame, f"step {step.k}", step.k))


#: What a tool is opened on.
Seen = Camera | Recording | Simulation | Experiment | Frame | Pixels
_FLOOR = 150  # level of what lies below a robot's picture


def pictures_of(what: Any, robot: RobotDefinition) -> Pictures:
    """Return what shows the pictures of something; TypeError or ValueError if it has none."""
    if what is None:
        return OnePicture(picture_of(robot), f"the picture of the robot {robot.name}")
    if isinstance(what, Camera):
        return CameraPictures(what)
    if isinstance(what, Recording):
        return RecordedPictures(what)
    if isinstance(what, (Simulation, Experiment)):
        is_open = is_shown(what)
        found = panel(what)
        return RunPictures(found._view.driver, type(what).__name__, None if is_open else found)
    if isinstance(what, (Frame, np.ndarray)):
        pixels = what.image if isinstance(what, Frame) else check_pixels("what", what, 3)
        return OnePicture(what if isinstance(what, Frame) else pixels, "a picture")
    if isinstance(what, (str, PathLike)):
        path = as_path(what, "what")
        return _picture_file(path) if _is_picture(path) else RecordedPictures(Recording(path))
    raise TypeError(
        "what must be a Camera, a Recording, a Simulation, an Experiment, a Frame, an array or a "
        f"path, got {quoted(what)}"
    )


def _is_picture(path: Path) -> bool:
    return not path.is_dir() and path.suffix.lower() in image_suffixes()


def _picture_file(path: Path) -> Pictures:
    return OnePicture(load_image(path), path.name)


def picture_of(robot: RobotDefinition) -> Frame:
    """Return a robot's picture on a grey floor, with the scale of the work area."""
    shown = over_floor(robot.image).image
    scale = robot.size / shown.shape[1]
    to_area = [(scale, 0, (scale - 1) / 2), (0, scale, (scale - 1) / 2), (0, 0, 1)]
    return Frame(shown, plane_map=PlaneMap(to_area))


def over_floor(image: Pixels) -> Frame:
    """Return a picture (h, w, 3 or 4) on a grey floor."""
    if image.shape[2] == 3 or (image[..., 3] == 255).all():
        return Frame(np.ascontiguousarray(image[..., :3]))
    alpha = image[..., 3:].astype(np.uint16)  # in which 255 x 255 has room
    # alpha / 255 x colour + (1 - alpha / 255) x floor, rounded
    shown = (alpha * image[..., :3] + (255 - alpha) * np.uint16(_FLOOR) + 127) // 255
    return Frame(shown.astype(np.uint8))


def given_picture(picture: Any) -> tuple[Pixels, str]:
    """Return the pixels (h, w, 3 or 4) of a picture, and what people call it.

    Raises
    ------
    OSError
        If its file cannot be read.
    TypeError, ValueError
        If it is neither a Frame, nor an array, nor the path of a picture.
    """
    if isinstance(picture, Frame):
        return picture.image, "a picture"
    if isinstance(picture, (str, PathLike)):
        path = as_path(picture, "picture")
        with path.open("rb") as file:
            return decoded(file, one_line(path)), path.name
    channels = 4 if isinstance(picture, np.ndarray) and picture.shape[2:] == (4,) else 3
    return check_pixels("picture", picture, channels, "a path, a Frame or "), "a picture"
