"""The sources of a tool's pictures: a picture, a recording, a camera, a run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import Frame, PlaneMap, Step
from robsim.base.files import as_path, open_file
from robsim.base.text import one_line
from robsim.gui._driver import Driver
from robsim.gui._link import FrameClock
from robsim.gui.hosted import HostedPanel
from robsim.lab.cameras.camera import Camera
from robsim.simulation import Simulation
from robsim.vision.imaging import images
from robsim.vision.imaging.recordings import Recording
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.sketch import over_floor

_AROUND = 1.2  # side of the square around a robot, in sides of its picture
_PATIENCE = 0.5  # s for a frame, before checking whether the source has ended


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of a source."""

    frame: Frame
    name: str  # for people
    k: int | None = None  # its number in the source; None = no number


class Pictures:
    """A source of pictures; live sources report each new picture from their own thread."""

    #: Whether new pictures arrive automatically.
    is_live = False
    #: Number of available pictures; None = only the newest one.
    count: int | None = None

    def __init__(self, title: str) -> None:
        self.title = title

    @property
    def kind(self) -> str:
        """The browsers' name of the kind: live, recording or picture."""
        if self.is_live:
            return "live"
        return "recording" if self.count else "picture"

    def at(self, k: int) -> Picture:
        """Return one of several pictures; the number is below `count`."""
        raise LookupError(f"{self.title} has only its newest picture")

    def begin(self, take: Callable[[Picture], object], fail: Callable[[str], object]) -> None:
        """Report pictures from now on, and the end of the source, in any thread."""
        take(self.at(0))

    def robot_in(self, picture: Picture) -> tuple[float, float, float] | None:
        """Return centre and side (px) of a square around the robot; None = unknown."""
        return None

    def settle(self) -> None:
        """Wait until all pictures so far have been reported."""

    def close(self) -> None:
        """Stop reporting; the user's objects stay open."""


class OnePicture(Pictures):
    """A single picture."""

    def __init__(self, image: Frame | images.Pixels, title: str) -> None:
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
    """The pictures of a camera, which a thread reads."""

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
                except TimeoutError:
                    continue
                except (OSError, ValueError) as error:
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
    """The pictures of a run's camera, while a panel drives the run.

    `mine` is the panel, if it was opened for this source; `close` closes it, too.
    """

    is_live = True

    def __init__(self, driver: Driver, title: str, mine: HostedPanel | None = None) -> None:
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

    def robot_in(self, picture: Picture) -> tuple[float, float, float] | None:
        """Return the square around the true pose of a simulated robot; columns are snapshots."""
        run = self._driver.runner
        poses = run._core.columns().get("pose_true", ()) if isinstance(run, Simulation) else ()
        if picture.k is None or picture.k >= len(poses) or not isinstance(run, Simulation):
            return None
        to_pixel, size = picture.frame.plane_map.to_pixel, _AROUND * run.robot.size
        x, y = poses[picture.k][:2]
        (u, v), (right, below) = to_pixel((x, y)), to_pixel((x + size, y))
        return float(u), float(v), float(np.hypot(right - u, below - v))

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


def picture_of(robot: RobotDefinition) -> Frame:
    """Return a robot's picture on a grey floor, with the scale of the work area."""
    shown = over_floor(robot.image).image
    scale = robot.size / shown.shape[1]
    to_area = [(scale, 0, (scale - 1) / 2), (0, scale, (scale - 1) / 2), (0, 0, 1)]
    return Frame(shown, plane_map=PlaneMap(to_area))


def given_picture(picture: Any) -> tuple[images.Pixels, str]:
    """Return the pixels (h, w, 3 or 4) of a picture, and a readable name.

    OSError: its file cannot be read. TypeError, ValueError: it is not a picture.
    """
    if isinstance(picture, Frame):
        return picture.image, "a picture"
    if isinstance(picture, (str, PathLike)):
        path = as_path(picture, "picture")
        with open_file(path) as file:
            return images.decoded(file, one_line(path)), path.name
    channels = 4 if isinstance(picture, np.ndarray) and picture.shape[2:] == (4,) else 3
    return images.check_pixels("picture", picture, channels, "a path, a Frame or "), "a picture"
