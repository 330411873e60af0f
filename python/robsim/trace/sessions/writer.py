"""Writes a session during a run: an MCAP file that survives a kill at any moment."""

from __future__ import annotations

import math
import os
import queue
import threading
import time
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from robsim._core import Frame, PlaneMap
from robsim.base.checks import check_bool
from robsim.base.files import as_path, naming, sync_folder
from robsim.base.in_browser import check_has_threads
from robsim.base.text import cut, one_line
from robsim.base.warn import warn_user
from robsim.trace.sessions._file import (
    END,
    SETUP,
    TRACE,
    Pieces,
    lock,
    new_writer,
    session_file,
)
from robsim.trace.sessions._ros import Message, Messages, channels
from robsim.trace.sessions._setup import setup_text
from robsim.trace.sessions.rows import Row
from robsim.trace.trace import Trace
from robsim.vision.imaging.video import load_opencv

#: Of JPEG pictures; colours in full resolution.
JPEG_QUALITY = 95

#: Limits of the queue: beyond them, pictures are left out.
_MOST_WAITING = 16  # steps
_LONGEST_WAIT = 0.4  # s

_BETWEEN_SYNCS = 1.0  # s
_AFTER_ERROR = 1.0  # s, before a full disk is tried again


@dataclass
class Counts:
    """Counts of recorded and omitted data."""

    steps: int = 0
    frames: int = 0
    frames_left_out: int = 0


class SessionWriter:
    """Records a run in a file, for `robsim.trace.Session`; a separate thread writes.

    Only the constructor raises errors of the disk, FileExistsError for another session, and
    ImportError without OpenCV. A kill loses the step being written. While a callback holds the
    interpreter, nothing is written, and the previous step can be lost, too. `add` warns of the
    first error.

    `Session` knows the keys area, dt, plane_map, stop_input, colors, markers, model, robot of
    `setup`; `floor` is the map of the floor itself, below the markers. `lossless` pictures are PNG,
    else JPEG. With `waits`, `add` waits for a slow disk or processor, so that the file has every
    frame, as for a `robsim.Recording`.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        *,
        setup: Mapping[str, Any],
        lossless: bool = False,
        waits: bool = False,
    ) -> None:
        check_has_threads("The recording of a session")
        self.path = session_file(as_path(path))
        kind = "PNG" if check_bool("lossless", lossless) else "JPEG"
        cv2 = load_opencv("recording a session")
        text = setup_text(setup, kind=kind)
        self._waits = check_bool("waits", waits)
        self._is_told = False
        check_is_free(self.path)
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._file = _SessionFile(self.path, _encoder(cv2, kind), text, setup)
        self._queue: queue.SimpleQueue[_Item | threading.Event | None] = queue.SimpleQueue()
        self._thread = threading.Thread(
            target=_write, args=(self._queue, self._file), name="robsim session", daemon=True
        )
        self._process = os.getpid()
        self._thread.start()
        self._finish = weakref.finalize(
            self, _finish, self._queue, self._thread, self._file, self._process
        )

    @property
    def counts(self) -> Counts:
        return replace(self._file.counts)

    @property
    def error(self) -> Exception | None:
        """The first error of disk or encoder."""
        return self._file.error

    def add(self, row: Row, frame: Frame | None) -> None:
        """Record a step; row and frame must stay unchanged, but the writer adds picture values."""
        if not self._finish.alive or self._process != os.getpid():
            return
        is_full = frame is not None and self._queue.qsize() >= _MOST_WAITING
        if is_full and self._waits:
            self.flush()
            is_full = False
        until = math.inf if self._waits else time.monotonic() + _LONGEST_WAIT
        self._queue.put(_Item(row, None if is_full else frame, until, is_full, time.time_ns()))
        if self.error is not None and not self._is_told:
            self._is_told = True
            warn_user(f"{one_line(self.path)} cannot be written: {cut(self.error)}")

    def flush(self) -> None:
        """Wait until all that was added is written."""
        if self._finish.alive and self._process == os.getpid():
            done = threading.Event()
            self._queue.put(done)
            while not done.wait(0.1) and self._thread.is_alive():
                pass

    def close(self, trace: Trace | None = None) -> None:
        """Finish the session, with a trace's rest; warn of unrecorded data."""
        if not self._finish.alive or self._process != os.getpid():
            return
        self._file.trace = trace
        self._finish()
        if trouble := self._file.trouble():
            warn_user(f"{one_line(self.path)}: {trouble}")


def check_is_free(path: Path) -> None:
    """Raise an error unless a session can be written there."""
    if path.parent.exists() and not path.parent.is_dir():
        raise NotADirectoryError(f"{one_line(path.parent)} is a file, not a folder")
    if os.path.lexists(path):
        raise FileExistsError(
            f"{one_line(path)} already exists, and a session overwrites no file: use another name"
        )


@dataclass(frozen=True, slots=True)
class _Item:
    """A step on its way to the disk."""

    row: Row
    frame: Frame | None
    until: float  # s, monotonic: later, the frame is left out
    is_full: bool
    now: int  # when it was added (ns since 1970)


def _encoder(cv2: Any, kind: str) -> Callable[[Frame], bytes]:
    """Return the function that makes a JPEG or PNG picture of a frame."""
    suffix, options = ".png", []
    if kind == "JPEG":
        full = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444
        suffix, options = ".jpg", [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
        options += [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, full]

    def encode(frame: Frame) -> bytes:  # others can use the interpreter meanwhile
        bgr = cv2.cvtColor(frame.image, cv2.COLOR_RGB2BGR)
        return bytes(cv2.imencode(suffix, bgr, options)[1])

    return encode


class _SessionFile:
    """The file of a session, for the thread that writes it."""

    def __init__(
        self, path: Path, encode: Callable[[Frame], bytes], setup: str, given: Mapping[str, Any]
    ) -> None:
        self.counts = Counts()
        self.error: Exception | None = None
        self.trace: Trace | None = None
        self.encode = encode
        self._plane_map = given.get("plane_map") or PlaneMap()
        self._floor = given.get("floor") or given.get("plane_map")
        self._mm_per_px = given.get("mm_per_px")
        self._messages: Messages | None = None
        self._size: tuple[int, int] | None = None
        self._try_again = -math.inf
        self._file = _AppendedFile(path)
        try:
            self._writer = new_writer(self._file)
            self._writer.start("ros2", "robsim")
            self._writer.add_metadata(SETUP, {"toml": setup})
            self._channels = {}
            for topic, kind, text in channels():
                schema = self._writer.register_schema(kind, "ros2msg", text.encode())
                self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)
            self._file.append()
            sync_folder(path.parent)
        except BaseException:
            with suppress(OSError):  # so that the name can be tried again
                self._file.close()
                path.unlink()
            raise

    def write(self, item: _Item) -> None:
        """Write a step with its picture, as one chunk."""
        row, frame = item.row, item.frame
        left_out, data = "busy" if item.is_full else "", b""
        if frame is not None:
            seen = frame.plane_map
            row = replace(
                row,
                frame_index=frame.index,
                plane_map=None if seen == self._plane_map else seen,
                headings=frame.headings,
            )
            left_out, data = self._picture(item.until, frame)
        self.counts.frames_left_out += bool(left_out)
        row = replace(row, left_out=left_out)
        if self._messages is None:
            moment = next(t for t in (row.t_sent, row.t_arrival, row.t) if not math.isnan(t))
            epoch = item.now - round(1e9 * moment)
            floor = self._floor or (frame.plane_map if frame else PlaneMap())
            self._messages = Messages(floor, self._mm_per_px, epoch)
            self._add(row, self._messages.first(row.t))
        self._add(row, self._messages.of(row))
        if data and frame is not None:
            self._add(row, self._messages.picture(row, frame, data))
            self.counts.frames += 1
        self._writer.flush()
        self.attempt(self._append)
        self.counts.steps += 1

    def _add(self, row: Row, messages: Iterator[Message]) -> None:
        for topic, t, data in messages:
            self._writer.add_message(self._channels[topic], t, data, t, int(row.k) % 2**32)

    def _append(self) -> None:
        if time.monotonic() >= self._try_again:
            self._try_again = time.monotonic() + _AFTER_ERROR
            self._file.append()
            self._try_again = -math.inf

    def _picture(self, until: float, frame: Frame) -> tuple[str, bytes]:
        """Return the reason for an omitted picture, as a word, or the picture."""
        height, width = frame.image.shape[:2]
        if time.monotonic() > until:
            return "busy", b""
        if self._size not in (None, (width, height)):
            return "size", b""
        if self._file.waiting:  # a disk that takes nothing must not fill the memory
            return "error", b""
        encoded: list[bytes] = []
        if not self.attempt(lambda: encoded.append(self.encode(frame))):
            return "error", b""
        self._size = (width, height)
        return "", encoded[0]

    def sync(self) -> None:
        self.attempt(self._file.sync)

    def finish(self) -> None:
        """Complete and close the file."""
        self.attempt(self._file.append)
        if not self._file.waiting:
            self.attempt(self._complete)
        self.sync()
        self.attempt(self._file.close)

    def _complete(self) -> None:
        if (trace := self.trace) is not None and len(trace):
            now = time.time_ns()
            self._writer.add_attachment(now, now, TRACE, "application/zip", trace._packed())
        end = {name: str(value) for name, value in vars(self.counts).items()}
        if self.error is not None:
            end["error"] = cut(f"{type(self.error).__name__}: {self.error}")
        self._writer.add_metadata(END, end)
        self._writer.finish()
        self._file.append()

    def attempt(self, action: Any) -> bool:
        """Run an action that may fail; keep the first error, and return whether it succeeded."""
        try:
            action()
        except Exception as error:
            if self.error is None:
                self.error = error.with_traceback(None)
            return False
        return True

    def trouble(self) -> str:
        """Return a sentence on missing records; "" if the record is complete."""
        counts, parts = self.counts, []
        if counts.frames_left_out:
            seen = counts.frames + counts.frames_left_out
            parts.append(f"{counts.frames_left_out} of {seen} frames were omitted: /diagnostics")
        if self._file.waiting:
            parts.append("the last steps could not be written")
        if self.error is not None:
            parts.append(f"the first error was {cut(self.error)}")
        return "; ".join(parts)


class _AppendedFile(Pieces):
    """A new file that grows by whole pieces: a part of one on a full disk is removed."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        self._descriptor = os.open(path, flags, 0o666)
        self._close = weakref.finalize(self, os.close, self._descriptor)
        self._close.atexit = False  # the session is finished there, and needs it
        lock(self._descriptor)

    def append(self) -> None:
        """Write all waiting pieces to the file, or no part of them."""
        piece = self.whole()
        with naming(self._path):
            try:
                while piece:  # a full disk may take a part before it refuses
                    piece = piece[os.write(self._descriptor, piece) :]
            except OSError:
                os.ftruncate(self._descriptor, self.start)
                os.lseek(self._descriptor, self.start, os.SEEK_SET)
                raise
        self.take()

    def sync(self) -> None:
        with naming(self._path):
            os.fsync(self._descriptor)

    def close(self) -> None:
        with naming(self._path):
            self._close()


def _write(items: queue.SimpleQueue[Any], file: _SessionFile) -> None:
    """Write incoming pieces, until None arrives."""
    is_over = threading.Event()
    syncing = threading.Thread(
        target=_sync, args=(file, is_over), name="robsim session to disk", daemon=True
    )
    syncing.start()
    while (item := items.get()) is not None:
        if isinstance(item, _Item):
            file.attempt(lambda item=item: file.write(item))
        else:
            item.set()
    is_over.set()
    syncing.join()
    file.finish()


def _sync(file: _SessionFile, is_over: threading.Event) -> None:
    """Flush the file to the disk once a second, in parallel to the writing."""
    while not is_over.wait(_BETWEEN_SYNCS):
        file.sync()


def _finish(
    items: queue.SimpleQueue[Any], thread: threading.Thread, file: _SessionFile, process: int
) -> None:
    if os.getpid() == process:  # a forked child lacks its parent's threads
        items.put(None)
        thread.join()
