"""Reads single pictures of a session's video."""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from robsim.base.files import open_file
from robsim.base.text import cut, one_line
from robsim.vision.imaging.images import MOST_PIXELS, pixels_of

_EBML, _SEGMENT, _CLUSTER = 0x1A45DFA3, 0x18538067, 0x1F43B675
_UNKNOWN_SIZE = b"\x01" + 7 * b"\xff"
_START_SIZE = 8  # bytes of a size that is patched
# A cluster: its size, the time (ms), and a block of track 1, a key frame, to the end.
_CLUSTER_HEAD = struct.Struct(">I Q BBQ BQ BHB")
_BLOCK_HEAD = 4  # bytes: track, time after that of the cluster, flags
_LONG = 1 << 56  # marks a size of eight bytes
_MOST_PICTURE = 2**28  # bytes
_MOST_PICTURES = 20_000_000
_MOST_HEAD = 512  # bytes before the first cluster
_SEEK_ROOM = 32  # bytes, for where the cues are
_CODECS = {"JPEG": "V_MJPEG", "PNG": "V_MS/VFW/FOURCC"}


class Picture(NamedTuple):
    """Where an encoded picture is in the file, and its time (ms)."""

    start: int
    size: int
    time: int


def head(kind: str, size: tuple[int, int], fps: float | None) -> bytes:
    """Return what the file begins with, for JPEG or PNG pictures of a width and height."""
    track = [
        _number(0xD7, 1),  # TrackNumber
        _number(0x73C5, 1),  # TrackUID
        _number(0x83, 1),  # TrackType: video
        _number(0x9C, 0),  # FlagLacing
        _element(0x86, _CODECS[kind].encode()),  # CodecID
        _element(0xE0, _number(0xB0, size[0]) + _number(0xBA, size[1])),  # Video
    ]
    if kind == "PNG":  # Matroska has no name of its own for it
        bitmap = struct.pack("<IiiHH4s5I", 40, *size, 1, 24, b"MPNG", 0, 0, 0, 0, 0)
        track.append(_element(0x63A2, bitmap))  # CodecPrivate
    if fps is not None:
        track.append(_number(0x23E383, round(1e9 / fps)))  # DefaultDuration (ns)
    document = [
        *(_number(0x4286, 1), _number(0x42F7, 1), _number(0x42F2, 4), _number(0x42F3, 8)),
        *(_element(0x4282, b"matroska"), _number(0x4287, 4), _number(0x4285, 2)),
    ]
    info = [
        _number(0x2AD7B1, 1_000_000),  # TimestampScale: ms
        _element(0x4D80, b"robsim"),  # MuxingApp
        _element(0x5741, b"robsim"),  # WritingApp
        _void(11),  # Duration
    ]
    return b"".join(
        (
            _element(_EBML, b"".join(document)),
            _id(_SEGMENT) + _UNKNOWN_SIZE,
            _void(_SEEK_ROOM),
            _element(0x1549A966, b"".join(info)),
            _element(0x1654AE6B, _element(0xAE, b"".join(track))),  # Tracks
        )
    )


def cluster(picture: bytes, time: int) -> bytes:
    """Return an encoded picture as it stands in the file, with its time (ms)."""
    block = _BLOCK_HEAD + len(picture)
    size = _CLUSTER_HEAD.size - 12 + len(picture)
    return (
        _CLUSTER_HEAD.pack(
            _CLUSTER, _LONG | size, 0xE7, 0x88, time, 0xA3, _LONG | block, 0x81, 0, 0x80
        )
        + picture
    )


def finish(descriptor: int, cues: list[Picture], duration: float, end: int) -> None:
    """Write places of pictures, and the duration (ms), at the end: only for fast seeking."""
    first = read_at(descriptor, _MOST_HEAD, 0)
    segment = first.index(_id(_SEGMENT)) + 4
    content = segment + _START_SIZE
    table = _element(0x1C53BB6B, b"".join(_cue(picture, content) for picture in cues))
    _write_at(descriptor, table, end)
    seek = _element(0x53AB, _id(0x1C53BB6B)) + _number(0x53AC, end - content)
    seek_head = _element(0x114D9B74, _element(0x4DBB, seek))
    _write_at(descriptor, seek_head + _void(_SEEK_ROOM - len(seek_head)), content)
    place = first.index(_void(11), content + _SEEK_ROOM)
    _write_at(descriptor, b"\x44\x89\x88" + struct.pack(">d", duration), place)
    size = end + len(table) - content
    _write_at(descriptor, (_LONG | size).to_bytes(8, "big"), segment)


def _cue(picture: Picture, content: int) -> bytes:
    """Return where the cluster of a picture is, from where the segment's content begins."""
    place = picture.start - _CLUSTER_HEAD.size - content
    track = _number(0xF7, 1) + _number(0xF1, place)  # CueTrack, CueClusterPosition
    return _element(0xBB, _number(0xB3, picture.time) + _element(0xB7, track))


def find_pictures(file: Path, descriptor: int) -> tuple[list[Picture], int]:
    """Return whole pictures, and the bytes of a torn one; ValueError: another kind of file."""
    size = os.fstat(descriptor).st_size
    start = read_at(descriptor, _MOST_HEAD, 0)
    if not start.startswith(_id(_EBML)[:size]):
        raise ValueError(f"{one_line(file)} is not a video of a session, or damaged")
    place = start.find(_id(_CLUSTER))
    if place < 0:  # killed before it wrote a picture
        return [], size
    pictures: list[Picture] = []
    for picture, end in _clusters(descriptor, place, size):
        if len(pictures) == _MOST_PICTURES:
            raise ValueError(f"{one_line(file)} must have at most {_MOST_PICTURES} pictures")
        pictures.append(picture)
        place = end
    is_over = read_at(descriptor, 4, place) == _id(0x1C53BB6B)
    return pictures, 0 if is_over else size - place


def _clusters(descriptor: int, place: int, size: int) -> Iterator[tuple[Picture, int]]:
    """Give each picture that is whole, and where it ends."""
    while True:
        start = read_at(descriptor, _CLUSTER_HEAD.size, place)
        if len(start) < _CLUSTER_HEAD.size:
            return
        kind, length, _, _, time, _, block, *_ = _CLUSTER_HEAD.unpack(start)
        n = (block & ~_LONG) - _BLOCK_HEAD
        end = place + _CLUSTER_HEAD.size + n
        is_whole = kind == _CLUSTER and 0 < n <= _MOST_PICTURE and end <= size
        if not is_whole or length & ~_LONG != _CLUSTER_HEAD.size - 12 + n:
            return
        yield Picture(place + _CLUSTER_HEAD.size, n, time), end
        place = end


def _id(kind: int) -> bytes:
    return kind.to_bytes((kind.bit_length() + 7) // 8)


def _element(kind: int, content: bytes) -> bytes:
    n = len(content)
    size = (0x80 | n).to_bytes(1) if n < 0x7F else (_LONG | n).to_bytes(8)
    return _id(kind) + size + content


def _number(kind: int, value: int) -> bytes:
    return _element(kind, value.to_bytes(max(1, (value.bit_length() + 7) // 8)))


def _void(size: int) -> bytes:
    """Return an element of so many bytes that says nothing."""
    return _element(0xEC, bytes(size - 2))


def read_at(descriptor: int, size: int, place: int) -> bytes:
    """Return some bytes of an open file, fewer at its end."""
    os.lseek(descriptor, place, os.SEEK_SET)
    return os.read(descriptor, size)


def _write_at(descriptor: int, content: bytes, place: int) -> None:
    os.lseek(descriptor, place, os.SEEK_SET)
    write_all(descriptor, content)


def write_all(descriptor: int, content: bytes) -> None:
    """Write all of some bytes; a full disk may take a part of them before it refuses."""
    while content:
        content = content[os.write(descriptor, content) :]


class Pictures:
    """A video's pictures by `SessionWriter`, complete or not; ValueError: another kind of file."""

    def __init__(self, file: Path) -> None:
        self._file = file
        with self.opened() as descriptor:
            self._places, self.torn = find_pictures(file, descriptor)
            self.size = (0, 0)  # width, height (px)
            if self._places:
                pixels = self.read(descriptor, 0)
                self.size = (pixels.shape[1], pixels.shape[0])

    def __len__(self) -> int:
        return len(self._places)

    @contextmanager
    def opened(self) -> Iterator[int]:
        """Give a descriptor for `read` and `encoded`."""
        with open_file(self._file) as file:
            yield file.fileno()

    def encoded(self, descriptor: int, number: int) -> bytes:
        """Return a picture as it stands in the file."""
        place = self._places[number]
        return read_at(descriptor, place.size, place.start)

    def read(self, descriptor: int, number: int) -> NDArray[np.uint8]:
        """Return RGB pixels (H, W, 3); ValueError: damaged, too large or of another size."""
        content = io.BytesIO(self.encoded(descriptor, number))
        try:
            with Image.open(content, formats=("JPEG", "PNG")) as image:
                width, height = image.size
                if width * height > MOST_PIXELS:
                    raise ValueError(f"{width} x {height} px are too many")
                if self.size not in ((0, 0), image.size):
                    raise ValueError(f"{width} x {height} px, unlike the first one")
                return pixels_of(image, "RGB")
        except Exception as error:  # Pillow's decoders raise many types
            said = "no picture" if isinstance(error, UnidentifiedImageError) else cut(error)
            raise ValueError(
                f"frame {number} of {one_line(self._file)} is damaged: {said}"
            ) from error
