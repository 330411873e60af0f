"""Writes a session while a run goes on: pictures, rows, set-up, safe from a kill at any moment."""

from __future__ import annotations

import math
import os
import queue
import threading
import time
import weakref
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import Frame, PlaneMap
from robsim.base.checks import check_bool, check_float
from robsim.base.files import PartialFile, as_path, naming, sync_folder, write_whole
from robsim.base.text import cut, one_line
from robsim.base.warn import warn_user
from robsim.trace.sessions import _pictures as matroska
from robsim.trace.sessions._setup import setup_text
from robsim.trace.sessions.rows import HEADER, Row, line_of, with_frame
from robsim.trace.trace import Trace
from robsim.vision.imaging.video import load_opencv

#: The files of a session.
SETUP, ROWS, VIDEO, END, TRACE = "setup.toml", "steps.csv", "frames.mkv", "end.toml", "trace.npz"

#: Of the JPEG pictures of a video that is not lossless; colours in full resolution.
JPEG_QUALITY = 95

#: Limits of what waits to be written: what is above is left out of the video.
_MOST_WAITING = 16  # steps
_LONGEST_WAIT = 0.4  # s

_BETWEEN_SYNCS = 1.0  # s
_BETWEEN_CUES = 1000  # ms
_AFTER_ERROR = 1.0  # s, before a full disk is tried again


@dataclass
class Counts:
    """What was recorded, and what was not."""

    steps: int = 0
    frames: int = 0
    frames_left_out: int = 0
    steps_lost: int = 0


class SessionWriter:
    """Records a run in a folder, for `robsim.trace.Session`; a separate thread writes.

    Only the constructor raises errors of the disk, FileExistsError for another session, and
    ImportError without OpenCV. A kill loses the steps of the last second. While a callback holds
    the interpreter, nothing is written, and the previous step can be lost, too.

    `Session` knows the keys area, dt, plane_map, stop_input, colors, markers, model, robot of
    `setup`. `lossless` pictures are PNG, else JPEG; `fps` is for players. With `waits`, `add` waits
    for a slow disk or processor, so that the video has every frame, as of a `robsim.Recording`.
    """

    def __init__(
        self,
        folder: str | PathLike[str],
        *,
        setup: Mapping[str, Any],
        lossless: bool = False,
        fps: float | None = None,
        waits: bool = False,
    ) -> None:
        self.folder = as_path(folder, "folder")
        if fps is not None:
            fps = check_float("fps", fps, "1/s", exclusive_minimum=0, maximum=1e5)
        kind = "PNG" if check_bool("lossless", lossless) else "JPEG"
        cv2 = load_opencv("recording a session")
        text = setup_text(setup, kind=kind, fps=fps)
        self._waits = check_bool("waits", waits)
        plane_map = _plane_map_of(setup)
        _claim(self.folder, text.encode())
        try:
            self._files = _Files(self.folder, _Encoder(cv2, kind), fps, plane_map)
        except BaseException:
            with suppress(OSError):  # so that the folder can be tried again
                (self.folder / SETUP).unlink()
                (self.folder / ROWS).unlink()
            raise
        self._queue: queue.SimpleQueue[_Item | threading.Event | None] = queue.SimpleQueue()
        self._thread = threading.Thread(
            target=_write, args=(self._queue, self._files), name="robsim session", daemon=True
        )
        self._process = os.getpid()
        self._thread.start()
        self._finish = weakref.finalize(
            self, _finish, self._queue, self._thread, self._files, self._process
        )

    @property
    def counts(self) -> Counts:
        return replace(self._files.counts)

    @property
    def error(self) -> Exception | None:
        """The first error of disk or encoder."""
        return self._files.error

    def add(self, row: Row, frame: Frame | None) -> None:
        """Record a step; row and frame must stay unchanged, but the writer adds picture values."""
        if not self._finish.alive or self._process != os.getpid():
            return
        is_full = frame is not None and self._queue.qsize() >= _MOST_WAITING
        if is_full and self._waits:
            self.flush()
            is_full = False
        until = math.inf if self._waits else time.monotonic() + _LONGEST_WAIT
        self._queue.put(_Item(row, None if is_full else frame, until, is_full))

    def flush(self) -> None:
        """Wait until all that was added is written."""
        if self._finish.alive and self._process == os.getpid():
            done = threading.Event()
            self._queue.put(done)
            while not done.wait(0.1) and self._thread.is_alive():
                pass

    def close(self, trace: Trace | None = None) -> None:
        """Finish the session, a trace's rest in ``trace.npz``; warn of unrecorded data."""
        if not self._finish.alive or self._process != os.getpid():
            return
        self._finish()
        if trace is not None:
            self._files.attempt(lambda: trace.save(self.folder / TRACE))
        if trouble := self._files.trouble():
            warn_user(f"{one_line(self.folder)}: {trouble}")


def check_is_free(folder: str | PathLike[str]) -> None:
    if any(os.path.lexists(Path(folder) / name) for name in (SETUP, ROWS, VIDEO, END, TRACE)):
        raise FileExistsError(
            f"{one_line(folder)} has a recorded session already, which is not overwritten: give "
            "another name"
        )


def _plane_map_of(setup: Mapping[str, Any]) -> PlaneMap:
    given = setup.get("plane_map")
    return given if isinstance(given, PlaneMap) else PlaneMap(np.eye(3) if given is None else given)


def _claim(folder: Path, setup: bytes) -> None:
    """Write the set-up into a folder that has no session yet; two at once do not both succeed."""
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{one_line(folder)} is a file, not a folder: give another name")
    check_is_free(folder)
    folder.mkdir(parents=True, exist_ok=True)
    part = PartialFile(folder / SETUP)
    try:
        with naming(folder / SETUP):
            matroska.write_all(part.descriptor, setup)
        part.commit(overwrite=False)
    except FileExistsError:
        check_is_free(folder)
        raise
    finally:
        part.discard()


@dataclass(frozen=True, slots=True)
class _Item:
    """A step on its way to the disk."""

    row: Row
    frame: Frame | None
    until: float  # s, monotonic: later, the frame is left out
    is_full: bool


class _Encoder:
    """Makes JPEG or PNG pictures of frames."""

    def __init__(self, cv2: Any, kind: str) -> None:
        self.kind = kind
        self._cv2 = cv2
        self._suffix, self._options = ".png", []
        if kind == "JPEG":
            full = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
            self._suffix = ".jpg"
            self._options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
            self._options += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, full]

    def encode(self, frame: Frame) -> bytes:
        """Return a frame as a picture; others can use the interpreter meanwhile."""
        bgr = self._cv2.cvtColor(frame.image, self._cv2.COLOR_RGB2BGR)
        _, picture = self._cv2.imencode(self._suffix, bgr, self._options)
        return bytes(picture)


class _Files:
    """The files of a session, for the thread that writes them."""

    def __init__(
        self, folder: Path, encoder: _Encoder, fps: float | None, plane_map: PlaneMap
    ) -> None:
        self.counts = Counts()
        self.error: Exception | None = None
        self._folder = folder
        self._encoder = encoder
        self._fps = fps
        self._plane_map = plane_map
        self._rows = _AppendedFile(folder / ROWS)
        self._rows.append(HEADER)
        sync_folder(folder)
        self._video: _AppendedFile | None = None
        self._size = (0, 0)
        self._cues: list[matroska.Picture] = []  # one in a second
        self._start = math.nan  # time of the first picture (s)
        self._time = 0  # that of the last one in the video (ms)
        self._waiting: list[bytes] = []  # rows that the disk did not take
        self._try_again = -math.inf

    def write(self, item: _Item) -> None:
        """Write a step: the picture first, so that no row has a picture that is not there."""
        row, frame = item.row, item.frame
        number, left_out = None, "busy" if item.is_full else ""
        if frame is not None:
            seen = frame.plane_map
            row = replace(
                row,
                frame_index=frame.index,
                plane_map=None if seen == self._plane_map else seen,
                headings=frame.headings,
            )
            if time.monotonic() > item.until:
                left_out = "busy"
            else:
                left_out = self._write_picture(row.t, frame)
            number = None if left_out else self.counts.frames
        self.counts.frames += number is not None
        self.counts.frames_left_out += bool(left_out)
        self._waiting.append(line_of(with_frame(row, number, left_out)))
        self.attempt(self._write_rows)

    def _write_picture(self, t: float, frame: Frame) -> str:
        """Write a picture; return why it was not, as a word."""
        height, width = frame.image.shape[:2]
        if self._cues and (width, height) != self._size:
            return "size"
        if time.monotonic() < self._try_again:
            return "error"
        if self.attempt(lambda: self._append_picture(t, frame)):
            return ""
        self._try_again = time.monotonic() + _AFTER_ERROR
        return "error"

    def _append_picture(self, t: float, frame: Frame) -> None:
        height, width = frame.image.shape[:2]
        picture = self._encoder.encode(frame)
        if self._video is None:
            self._video = _AppendedFile(self._folder / VIDEO)
            sync_folder(self._folder)
        head = b""
        if self._video.end == 0:
            self._size, self._start = (width, height), t
            head = matroska.head(self._encoder.kind, self._size, self._fps)
        # Players need times that do not fall.
        moment = min(max(self._time, round(1000 * (t - self._start))), 2**40)
        end = self._video.append(head + matroska.cluster(picture, moment))
        self._time = moment
        if not self._cues or moment >= self._cues[-1].time + _BETWEEN_CUES:
            self._cues.append(matroska.Picture(end - len(picture), len(picture), moment))

    def _write_rows(self) -> None:
        self._rows.append(b"".join(self._waiting))
        self.counts.steps += len(self._waiting)
        self._waiting.clear()

    def sync(self) -> None:
        """Bring what was written to the disk, the video first."""
        for file in (self._video, self._rows):
            if file is not None:
                self.attempt(file.sync)

    def finish(self) -> None:
        """Complete and close all files."""
        if self._waiting:
            self.attempt(self._write_rows)
        self.counts.steps_lost = len(self._waiting)
        if self._video is not None and self._cues:
            self.attempt(self._finish_video)
        self.sync()
        self.attempt(self._write_end)
        for file in (self._video, self._rows):
            if file is not None:
                self.attempt(file.close)

    def _finish_video(self) -> None:
        assert self._video is not None
        n = self.counts.frames
        duration = self._time * n / max(1, n - 1)
        matroska.finish(self._video.descriptor, self._cues, duration, self._video.end)

    def _write_end(self) -> None:
        import tomlkit

        end = {**vars(self.counts)}
        if self.error is not None:
            end["error"] = cut(f"{type(self.error).__name__}: {self.error}")
        write_whole(self._folder / END, tomlkit.dumps(end).encode())

    def attempt(self, action: Any) -> bool:
        """Do something that may fail; keep the first error, and return whether it succeeded."""
        try:
            action()
        except Exception as error:
            if self.error is None:
                self.error = error.with_traceback(None)
            return False
        return True

    def trouble(self) -> str:
        """Return a sentence on what could not be recorded; "" if all is there."""
        counts, parts = self.counts, []
        if counts.frames_left_out:
            seen = counts.frames + counts.frames_left_out
            parts.append(f"{counts.frames_left_out} of {seen} frames were left out of the video")
        if counts.steps_lost:
            parts.append(f"{counts.steps_lost} steps could not be written")
        if self.error is not None:
            parts.append(f"the first error was {cut(self.error)}")
        elif counts.frames_left_out:
            parts.append(
                "disk or processor could not keep up, or the frames changed their size; see the "
                f"column left_out of {ROWS}"
            )
        return "; ".join(parts)


class _AppendedFile:
    """A new file that grows by whole pieces: what a full disk took of one is removed again."""

    def __init__(self, path: Path) -> None:
        self._path = path
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        self.descriptor = os.open(path, flags, 0o666)
        self.end = 0
        self._close = weakref.finalize(self, os.close, self.descriptor)
        self._close.atexit = False  # the session is finished there, and needs it

    def append(self, piece: bytes) -> int:
        """Write a piece; return the new end of the file."""
        with naming(self._path):
            try:
                matroska.write_all(self.descriptor, piece)
            except OSError:
                os.ftruncate(self.descriptor, self.end)
                os.lseek(self.descriptor, self.end, os.SEEK_SET)
                raise
        self.end += len(piece)
        return self.end

    def sync(self) -> None:
        with naming(self._path):
            os.fsync(self.descriptor)

    def close(self) -> None:
        with naming(self._path):
            self._close()


def _write(items: queue.SimpleQueue[Any], files: _Files) -> None:
    """Write what comes, until None does."""
    is_over = threading.Event()
    syncing = threading.Thread(
        target=_sync, args=(files, is_over), name="robsim session to disk", daemon=True
    )
    syncing.start()
    while (item := items.get()) is not None:
        if isinstance(item, _Item):
            files.attempt(lambda item=item: files.write(item))
        else:
            item.set()
    is_over.set()
    syncing.join()
    files.finish()


def _sync(files: _Files, is_over: threading.Event) -> None:
    """Bring the files to the disk once a second: beside the writing, which must not wait for it."""
    while not is_over.wait(_BETWEEN_SYNCS):
        files.sync()


def _finish(
    items: queue.SimpleQueue[Any], thread: threading.Thread, files: _Files, process: int
) -> None:
    if os.getpid() == process:  # a forked child has none of its parent's threads
        items.put(None)
        thread.join()
