"""External frames, such as from a recording or a camera, one for each step of an `Experiment`.

The loop takes a camera's frames directly, without the interpreter.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import math
import queue
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import Arrival, Frame, Grabber, Observation, PlaneMap, RobotModel, RobotParameters
from robsim.base.checks import check_size
from robsim.base.text import quoted
from robsim.base.warn import warn_user
from robsim.simulation.scenario import Scenario
from robsim.vision.imaging.calibration import Calibration
from robsim.vision.imaging.calibration_file import calibration_text

DT_TOLERANCE = 2e-3  # relative; video files round their frame rate
_PATIENCE = 0.05  # s, after which the loop looks whether it was stopped


class FrameSource:
    """An iterable of frames (Frame, Observation or None), read one per step by the loop.

    Its optional attributes ``area`` (px) and ``dt`` (s) apply by default, else 1200 x 1200. With
    `is_polled`, a run waiting for a frame can be stopped, or has a limit for the wait. A wrong
    value raises TypeError or ValueError.
    """

    def __init__(
        self,
        frames: Iterable[Frame | Observation | None],
        *,
        area: tuple[int, int] | None = None,
        is_polled: bool = False,
    ) -> None:
        if isinstance(frames, (str, PathLike)):
            raise TypeError(
                f"frames must be an iterable of Frame objects, got {quoted(frames)}: for a video "
                f"or a folder of images, use robsim.Recording({quoted(str(frames))})"
            )
        if not isinstance(frames, Iterable) or isinstance(frames, (bytes, Mapping, np.ndarray)):
            raise TypeError(
                f"frames must be an iterable of Frame objects, got {_described(frames)}"
            )
        given = getattr(frames, "area", None) if area is None else area
        self.area = check_size("area", Scenario.area if given is None else given)
        self.dt: float | None = getattr(frames, "dt", None)
        self._frames = frames
        grabber = getattr(frames, "_grabber", None)
        self._grabber: Grabber | None = grabber if isinstance(grabber, Grabber) else None
        # Damaged pictures of a recording are steps without a frame.
        self._begin = getattr(frames, "_each", frames.__iter__)
        self._iterator = iter(self._begin())
        self._is_polled = is_polled and not self.is_live
        self._reader: _Reader | None = None
        self._reading = threading.Lock()
        self._has_begun = False
        self._is_seen = False  # whether a frame has been seen
        self._drawn: set[int | None] = set()  # headings that the frames tell
        self._failed_at: int | None = None
        #: The data that frames must bring, as the message of an error; None = frames are enough.
        self.lacks: str | None = None

    @property
    def is_spent(self) -> bool:
        """Whether the frames can be read only once, and some have been."""
        return self._has_begun and self._iterator is self._frames

    @property
    def is_live(self) -> bool:
        """Whether the frames come at their own pace, without a request."""
        return self._grabber is not None

    @property
    def native(self) -> FrameSource | Grabber:
        """The object that the loop calls for a frame: the grabber of a camera, or this one."""
        return self._grabber or self

    @property
    def counts(self) -> Any:
        """The `CameraCounts` of a live camera; None for other sources."""
        return getattr(self._frames, "counts", None) if self.is_live else None

    @property
    def doubts(self) -> list[str]:
        """Warnings of the camera: a frame rate below the requested one."""
        if self._grabber is None or (rates := self._grabber.kept_rate) is None:
            return []
        sent, asked = rates
        return [
            f"the camera sends {sent:.3g} frames/s, not {asked:.3g}: set fps={sent:.3g}, or add "
            "light; in dim light webcams halve their rate"
        ]

    @property
    def mm_per_px(self) -> float | None:
        """Length of a px of the work area on the floor (mm), as calibrated; None = not known."""
        return getattr(self._calibration or self._frames, "mm_per_px", None)

    @property
    def headings(self) -> int | None:
        """Number of drawn headings of the robot, in all taken frames; None = not known."""
        drawn = tuple(self._drawn)
        return drawn[0] if len(drawn) == 1 else None

    @property
    def _calibration(self) -> Calibration | None:
        found = getattr(self._frames, "calibration", None)
        return found if isinstance(found, Calibration) else None

    def described(self) -> dict[str, Any]:
        """Return the frames' part of a session's set-up."""
        said = {
            "frames": quoted(self._frames),
            "plane_map": getattr(self._frames, "plane_map", None),
            "mm_per_px": self.mm_per_px,
            "camera": _camera_of(self._frames),
        }
        if (calibration := self._calibration) is not None:
            said["plane_map"] = calibration.plane_map
            said["floor"] = calibration.floor
            said["calibration"] = calibration_text(calibration)
        return said

    def restart(self) -> None:
        """Restart with the first frame."""
        self._iterator = iter(self._begin())
        self._drawn = set()
        self._has_begun = False
        self._reader = self._failed_at = None

    @contextmanager
    def reading(self) -> Iterator[None]:
        """Read inside the context, in a separate thread if the loop must not wait for a frame."""
        # A second run beside the first one, which the loop refuses, must not touch its thread.
        if not self._reading.acquire(blocking=False):
            yield
            return
        try:
            if self.is_live:
                camera: Any = self._frames
                self._look_at(camera.size, camera.plane_map, camera._headings)
            if not self._is_polled:
                yield
                return
            if self._reader is None:
                self._reader = _Reader(self._iterator)
            with self._reader.running():
                yield
        finally:
            self._reading.release()

    def __call__(self, k: int) -> Frame | Observation | Arrival | None:
        """Return the frame of step k; `Arrival.END` after the last one."""
        self._has_begun = True
        try:
            taken: Frame | Observation | Arrival | None
            if self._reader is None:
                taken = next(self._iterator, Arrival.END)
            else:
                taken = self._reader.take()
        except BaseException:
            if self._reader is None or not self._reader.is_waiting:
                self._failed_at = k
            raise
        if taken is Arrival.END and self._failed_at is not None:
            raise EOFError(
                f"there are no more frames since the exception at step {self._failed_at}: a "
                "generator that has raised an exception cannot continue"
            )
        if self.lacks is not None and isinstance(taken, Frame):
            raise ValueError(f"{self.lacks}, or Observation objects with this data as frames")
        if taken is not Arrival.NOTHING_YET:
            self._failed_at = None
        frame = taken.frame if isinstance(taken, Observation) else taken
        if isinstance(frame, Frame):
            height, width, _ = frame.image.shape
            self._look_at((width, height), frame.plane_map, frame.headings)
        return taken

    @property
    def can_read_again(self) -> bool:
        """Whether the frames can be read more than once, each by its number."""
        return self._read is not None

    def again(self, k: int) -> Frame | None:
        """Return the frame of step k, read again, one thread at a time; else LookupError."""
        if (read := self._read) is None:
            raise LookupError("the frames can be read only once")
        with suppress(ValueError):  # a damaged picture
            taken = read(k)
            return taken.frame if isinstance(taken, Observation) else taken
        return None

    @property
    def _read(self) -> Any:
        return getattr(self._frames, "_at", getattr(self._frames, "__getitem__", None))

    def _look_at(self, size: tuple[int, int], plane_map: PlaneMap, headings: int | None) -> None:
        """Note the properties of a frame, and warn if the first does not fit the work area."""
        self._drawn.add(headings)
        if self._is_seen:
            return
        self._is_seen = True
        if size != self.area and plane_map == PlaneMap():
            warn_user(
                f"the frames have {size[0]} x {size[1]} px and no plane map, but the area has "
                f"{self.area[0]} x {self.area[1]} px: a pixel counts as a px of the area. Give "
                f"each Frame plane_map=robsim.vision.PlaneMap.scaled({size}, {self.area}), or "
                f"Experiment area={size}"
            )

    def model(self) -> RobotModel:
        return RobotModel(RobotParameters() if self.dt is None else RobotParameters(dt=self.dt))

    def checked(self, define_model: Callable[[], Any]) -> Callable[[], Any]:
        """Return a define_model that raises if the model has another dt than the frames."""
        dt = self.dt

        @functools.wraps(define_model)
        def check() -> Any:
            model = define_model()
            if dt is None or not isinstance(model, RobotModel):
                return model
            if not math.isclose(model.dt, dt, rel_tol=DT_TOLERANCE):
                raise ValueError(
                    f"the model's dt is {model.dt:g} s, but the frames' dt is {dt:g} s: set "
                    "the dt of the model or of the recording"
                )
            return model

        return check


def _described(frames: object) -> str:
    """Return a description of the wrong frames, with a remedy if possible."""
    if isinstance(frames, Frame):
        return "a single Frame: pass a list, [frame]"
    if isinstance(frames, np.ndarray):
        return f"an array of shape {frames.shape}: pass a list of robsim.Frame(image, t=...)"
    if inspect.isfunction(frames) or inspect.ismethod(frames):
        return f"the function {frames.__name__}: call it, frames={frames.__name__}()"
    return quoted(frames)


class _Reader:
    """Reads an iterator in a separate thread, one item per request."""

    def __init__(self, iterator: Iterator[Any]) -> None:
        self._iterator = iterator
        self._taken: queue.SimpleQueue[tuple[Any, BaseException | None]] = queue.SimpleQueue()
        self._wanted: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self.is_waiting = False  # for an item

    @contextmanager
    def running(self) -> Iterator[None]:
        """Keep the thread inside the context. A hanging thread ends with its current item."""
        self._wanted = queue.SimpleQueue()
        thread = threading.Thread(
            target=self._read, args=(self._wanted,), name="robsim frames", daemon=True
        )
        thread.start()
        try:
            yield
        finally:
            self._wanted.put(False)
            if not self.is_waiting:
                thread.join()

    def take(self) -> Any:
        """Return the next item, or `Arrival.NOTHING_YET` after a short while."""
        if not self.is_waiting:
            self.is_waiting = True
            self._wanted.put(True)
        try:
            item, error = self._taken.get(timeout=_PATIENCE)
        except queue.Empty:
            return Arrival.NOTHING_YET
        self.is_waiting = False
        if error is not None:
            raise error
        return item

    def _read(self, wanted: queue.SimpleQueue[bool]) -> None:
        while wanted.get():
            try:
                self._taken.put((next(self._iterator, Arrival.END), None))
            except BaseException as error:
                self._taken.put((None, error))


def _camera_of(frames: Any) -> dict[str, Any] | None:
    """Return the settings of a camera, if it has any, which a later recording must repeat."""
    features = getattr(frames, "features", None)
    if not dataclasses.is_dataclass(features) or isinstance(features, type):
        return None
    chosen = {name: getattr(frames, name) for name in ("size", "region", "coding")}
    return {**chosen, "features": dataclasses.asdict(features)}
