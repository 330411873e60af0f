"""The frames of a video file and their times, read with PyAV."""

from __future__ import annotations

import math
import zlib
from array import array
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.base.files import content_of
from robsim.base.text import one_line
from robsim.vision.imaging.images import MOST_PIXELS, Pixels, image_suffixes, tell_of_turn
from robsim.vision.imaging.video import load_av, noted_headings

_COMPLETE = 0.95  # fraction of its duration; some files only estimate it
_MOST_ROUNDING = 0.1  # of the time between two frames, in the file
_MOST_JITTER = 0.02  # of it, by the camera
_MOST_LOST = 1 / 3  # of the intervals; with more of them, the rate is not known
_UNKNOWN = -(2**63)  # as a stamp

# Only what holds its own frames: FFmpeg also reads playlists of other files and of addresses.
_ALONE = {
    "protocol_whitelist": "file",
    "format_whitelist": "mov,matroska,avi,dv,ogg,flv,asf,mpeg,mpegvideo,mpegts,mxf,ivf,"
    "gif,yuv4mpegpipe",
}


class VideoReader:
    """The frames of a video file by their number; damaged frames count, too."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self._av = load_av("reading a video")
        if file.suffix.lower() in image_suffixes() - {".gif"}:
            raise ValueError(f"{one_line(file)} is an image, not a video: give the folder instead")
        if content_of(file, 5) == b"\x89MCAP":
            raise ValueError(
                f"{one_line(file)} is a session: use robsim.trace.Session(...), "
                "or convert it with robsim sessions video"
            )
        stamps, n, end, has_keys = array("q"), 0, 0.0, False
        with self._open() as (container, stream):
            self._tick, self._rate = float(stream.time_base), float(stream.average_rate or 0)
            claimed = stream.frames / self._rate if self._rate else 0.0
            frame = 1 / self._rate / self._tick if self._rate else 0.0  # without a duration
            if len(container.streams) == 1:  # not a longer sound
                claimed = max(claimed, (container.duration or 0) / self._av.time_base)
            for packet in filter(lambda one: one.size, self._packets(container, stream)):
                n += 1
                has_keys |= packet.is_keyframe
                end = max(end, _stamp(packet) + (packet.duration or frame))
                if not packet.is_discard:  # hidden by an edit list
                    stamps.append(_stamp(packet))
            # An AVI does not tell in which order frames are shown, but the decoder does.
            is_unordered = container.format.name == "avi" and stream.codec_context.has_b_frames
            is_whole = 0 < stream.frames <= n or end * self._tick >= _COMPLETE * claimed
        ends = f"ends after {end * self._tick:.3g} of {claimed:.3g} s: it is truncated or damaged"
        self.shortage = "" if is_whole else f"{one_line(file)} {ends}"
        is_timed = _UNKNOWN not in stamps
        self._stamps = np.unique(np.asarray(stamps))  # of two at one time the first is shown
        self.count = len(self._stamps if is_timed else stamps)
        self._first = math.inf if has_keys else -math.inf  # stamp of the first frame to show
        self._is_stamped = is_timed and not is_unordered  # or frames are counted
        self.headings = noted_headings(file)
        #: Time between two frames (s), None = not constant, and those of all since the first.
        self.dt: float | None = 1 / self._rate if self._rate else 0.0
        self.times = self.dt * np.arange(self.count)
        if is_timed and self.count > 1:
            times = (self._stamps - self._stamps[0]) * self._tick
            self.dt, self.times = _regular(times, self.dt, self._tick)

    def name(self, index: int) -> str:
        return f"frame {index} of {one_line(self.file)}"

    def read(self) -> Iterator[Pixels | ValueError]:
        """Yield all frames, an error for each that cannot be decoded."""
        index = 0
        for number, pixels in chain(self._from(0), [(self.count, None)]):
            yield from map(self._undecoded, range(index, number))
            if pixels is not None:
                yield pixels
            index = number + 1

    def at(self, index: int) -> Pixels:
        """Return a frame; IndexError: a missing frame, ValueError: an undecodable frame."""
        if not 0 <= index < self.count:
            raise IndexError(f"there is no {self.name(index)}")
        # An interlaced frame needs the previous one; a seek may land behind.
        for start in (max(index - 1, 0), 0):
            number, pixels = next((one for one in self._from(start) if one[0] >= index), (-1, None))
            if number == index and pixels is not None:
                return pixels
        raise self._undecoded(index)

    def _undecoded(self, index: int) -> ValueError:
        return ValueError(f"{self.name(index)} cannot be decoded: it is damaged")

    def _from(self, start: int) -> Iterator[tuple[int, Pixels]]:
        """Yield number and pixels of decoded frames, from a key frame before `start` on."""
        with self._open() as (container, stream):
            if start and self._is_stamped:
                with suppress(self._av.FFmpegError):  # from the beginning
                    container.seek(int(self._stamps[start]), stream=stream)
            converter, index = self._av.video.reformatter.VideoReformatter(), -1
            for frame in self._progressive(self._decoded(container, stream), stream):
                found = index + 1
                if self._is_stamped:
                    stamp = round(_stamp(frame) * frame.time_base / stream.time_base)
                    found = int(np.searchsorted(self._stamps, stamp))
                if index < found < self.count:
                    if frame.rotation:
                        tell_of_turn()
                    pixels = converter.reformat(frame, format="rgb24").to_ndarray()
                    yield found, np.ascontiguousarray(pixels)
                    index = found

    def _progressive(self, frames: Iterator[Any], stream: Any) -> Iterator[Any]:
        """Yield frames; for interlaced video, the rows of the field exposed first."""
        graph = None
        for frame in chain(frames, [None]):
            if graph is None and frame is not None and frame.interlaced_frame:
                graph = self._av.filter.Graph()
                source, yadif = graph.add_buffer(template=stream), graph.add("yadif", "deint=1")
                graph.link_nodes(source, yadif, graph.add("buffersink")).configure()
            if graph is not None:
                graph.push(frame)
                with suppress(BlockingIOError, EOFError):  # until it wants more
                    while True:
                        yield graph.pull()
            elif frame is not None:
                yield frame

    def _decoded(self, container: Any, stream: Any) -> Iterator[Any]:
        """Yield frames, except grey ones: a damaged key frame, and the frames that depend on it."""
        is_ffv1 = stream.codec_context.name == "ffv1"  # each frame depends on the previous one
        has_sums = False
        damaged, first = set[int](), self._first  # stamps; a cut file and a seek begin with grey
        for packet in self._packets(container, stream):
            stamp, frames = _stamp(packet), None
            if packet.is_keyframe and first == math.inf:
                first = stamp
            is_sound = is_ffv1 and _is_sound(packet)
            has_sums |= is_sound and packet.size > 0  # the last one is empty
            if is_sound or not has_sums:
                with suppress(self._av.FFmpegError):
                    frames = packet.decode()
            if frames is None:
                damaged |= {stamp} - {_UNKNOWN}  # a decoder may still give it
                first = math.inf if packet.is_keyframe or is_ffv1 else first
            for one in frames or ():
                if _stamp(one) >= first and _stamp(one) not in damaged:
                    yield one

    def _packets(self, container: Any, stream: Any) -> Iterator[Any]:
        with suppress(self._av.FFmpegError):  # a file that is cut off
            yield from container.demux(stream)

    @contextmanager
    def _open(self) -> Iterator[tuple[Any, Any]]:
        name = f"file:{self.file.absolute()}"
        # Titles need not be UTF-8; from PyAV 19 on, they never fail.
        is_strict = int(self._av.__version__.partition(".")[0]) < 19
        titles = {"metadata_errors": "replace"} if is_strict else {}
        try:
            container = self._av.open(name, container_options=_ALONE, **titles)
        except self._av.FFmpegError as error:
            raise ValueError(
                f"{one_line(self.file)} is not a video file, such as MP4, MKV or AVI, or it is "
                "damaged or truncated"
            ) from error
        with container:
            stream = container.streams.best("video")
            codec = stream and stream.codec_context
            if not codec or codec.width * codec.height > MOST_PIXELS:
                raise ValueError(
                    f"{one_line(self.file)} must have a known codec, and frames of at most "
                    f"{MOST_PIXELS} px"
                )
            codec.thread_count = 1  # more are no faster
            # A damaged picture is an error.
            codec.options = {"err_detect": "explode", "max_pixels": str(MOST_PIXELS)}
            yield container, stream


def _regular(times: Floats, dt: float, tick: float) -> tuple[float | None, Floats]:
    """Return the time between frames, None = not constant, and their times, not rounded to ticks.

    `dt` is the claim of the file (s).
    """
    intervals = np.rint(np.diff(times) / np.median(np.diff(times)))  # more than 1: frames lost
    if (intervals > 1).mean() > _MOST_LOST:
        return None, times
    k = np.append(0, intervals.cumsum())
    mean = float(times[-1] / k[-1])
    rounding = min(tick, _MOST_ROUNDING * mean) if intervals.max() > 1 else tick
    for one in (dt or mean, mean):
        if np.abs(times - one * k).max() <= rounding:
            return one, one * k
    is_steady = np.abs(np.diff(times) - mean * intervals).max() <= _MOST_JITTER * mean
    return (mean if is_steady else None), times


_MIRRORED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def _is_sound(packet: Any) -> bool:
    """Return whether the checksums of a packet of FFV1 are right; the decoder only logs that."""
    data = bytes(packet).translate(_MIRRORED)  # its polynomial has the bits the other way round
    return zlib.crc32(data, 2**32 - 1) == 2**32 - 1


def _stamp(one: Any) -> int:
    """Return the time of a packet or frame, in ticks of the file."""
    known = one.dts if one.pts is None else one.pts
    return _UNKNOWN if known is None else int(known)
