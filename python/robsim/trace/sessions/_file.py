"""Reads the MCAP file of a session, complete or cut off; completes a cut-off file."""

from __future__ import annotations

import io
import os
import struct
import sys
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from robsim.base.files import open_file
from robsim.base.files.reading import regular
from robsim.base.text import cut, one_line
from robsim.trace.sessions._ros import PICTURES, STEPS, picture_in, text_in
from robsim.trace.sessions.rows import MOST_LINE, MOST_ROWS, Row, row_of_json

MAGIC = MCAP0_MAGIC  # at both ends of a file
#: The metadata of a session, and its attachment.
SETUP, END, TRACE = "robsim.setup", "robsim.end", "trace.npz"
#: The errors of a damaged file.
UNREADABLE = (ValueError, struct.error, McapError)

_MOST_CHUNK, _MOST_TEXT = 2**28, 2**21  # bytes: of a chunk with a picture, of other records
_MOST_IN_CHUNK = 1000  # records, to be completed
_WINDOW = 4096  # bytes, read at once
_FAR = 2**62  # a byte beyond any file
_RECORD = struct.Struct("<BQ")  # opcode, length
_CHUNK = struct.Struct("<16xQIIQ")  # size, checksum, length of the compression's name, size
_MESSAGE = struct.Struct("<HI16x")  # channel, sequence


def session_file(path: Path) -> Path:
    """Return the file for a session's name, with the suffix ``.mcap``."""
    return path if path.name.endswith(".mcap") else path.with_name(path.name + ".mcap")


def existing_file(path: Path) -> Path:
    """Return the existing file or folder of a session, with or without ``.mcap``."""
    return path if path.exists() else session_file(path)


def lock(descriptor: int) -> bool:
    """Lock a file until it is closed; False: another writer has it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            place = os.lseek(descriptor, 0, os.SEEK_CUR)
            os.lseek(descriptor, _FAR, os.SEEK_SET)  # others cannot read a locked byte
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
            os.lseek(descriptor, place, os.SEEK_SET)
        else:
            import fcntl

            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


class Place(NamedTuple):
    """The place of a picture, or its message and the surrounding chunk."""

    start: int
    size: int
    chunk: int = 0
    chunk_size: int = 0
    checksum: int = 0


@dataclass
class Recorded:
    """The content of a session without its pictures, which are in `file`."""

    file: Path
    trace_file: Path
    setup: str = ""
    rows: list[Row] = field(default_factory=list)
    places: list[Place | None] = field(default_factory=list)  # of the picture of each row
    steps: int | None = None  # written ones; None: the recording was not ended
    trace: Place | None = None
    problems: list[str] = field(default_factory=list)

    @staticmethod
    def encoded(file: BinaryIO, place: Place) -> bytes:
        """Return a picture as stored in a file; ValueError or struct.error if it is damaged."""
        if place.chunk_size == 0:
            return _read(file, place.start, place.size)
        chunk = _read(file, place.chunk, place.chunk_size)
        if place.checksum not in (0, zlib.crc32(chunk)):
            raise ValueError("its checksum is wrong")
        start = place.start - place.chunk
        return picture_in(chunk[start : start + place.size])


def _read(file: BinaryIO, start: int, size: int) -> bytes:
    file.seek(start)
    return file.read(size)


def _stream(content: bytes) -> ReadDataStream:
    return ReadDataStream(io.BytesIO(content))


class _Records:
    """The records of a file."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self.size = file.seek(0, os.SEEK_END)
        self._start, self._window = 0, b""
        if self.at(0, len(MAGIC)) != MAGIC:
            raise ValueError("it is not an MCAP file")

    def at(self, start: int, size: int) -> bytes:
        """Return some bytes, fewer at the end of the file."""
        first = start - self._start
        if not 0 <= first <= first + size <= len(self._window):
            self._start, self._window = start, _read(self._file, start, max(size, _WINDOW))
            first = 0
        return self._window[first : first + size]

    def text(self, start: int, size: int) -> ReadDataStream:
        """Return a record, read as a whole; ValueError if it is too long."""
        if size > _MOST_TEXT:
            raise ValueError(f"a record at byte {start} must have at most {_MOST_TEXT} bytes")
        return _stream(self.at(start, size))

    def whole(self, start: int, end: int) -> Iterator[tuple[int, int, int]]:
        """Give opcode, place and size of the content of each complete record."""
        while start + _RECORD.size <= end:
            opcode, size = _RECORD.unpack(self.at(start, _RECORD.size))
            start += _RECORD.size
            if start + size > end or opcode == 0:
                return
            yield opcode, start, size
            start += size

    def data(self) -> Iterator[tuple[int, int, int]]:
        """Give the records of the file up to the end of its data."""
        for record in self.whole(len(MAGIC), self.size):
            yield record
            if record[0] == Opcode.DATA_END:
                return

    def chunk(self, start: int, size: int) -> tuple[int, int, int]:
        """Return place, size and checksum of a chunk's records; ValueError if it is compressed."""
        if len(head := self.at(start, _CHUNK.size)) == _CHUNK.size:
            inside, checksum, packed, length = _CHUNK.unpack(head)
            if 0 < packed < 32:
                raise ValueError("its chunks are compressed: run mcap compress --compression none")
            if inside == length == size - _CHUNK.size:
                return start + _CHUNK.size, length, checksum
        raise ValueError(f"the chunk at byte {start} is damaged")

    def is_cut(self, end: int) -> bool:
        """Whether a killed writer can have left the rest: one record, cut off at the file's end."""
        rest = self.at(end, _RECORD.size + _CHUNK.size)
        if len(rest) < _RECORD.size + _CHUNK.size or rest[0] == Opcode.DATA_END:
            return True
        inside, _, _, length = _CHUNK.unpack_from(rest, _RECORD.size)
        is_chunk = inside == length == _RECORD.unpack_from(rest)[1] - _CHUNK.size < _MOST_CHUNK
        kinds = (Opcode.MESSAGE_INDEX, Opcode.METADATA, Opcode.ATTACHMENT)
        return bool(is_chunk if rest[0] == Opcode.CHUNK else rest[0] in kinds)


def read_file(path: Path) -> Recorded:
    """Return the content of a file; ValueError names a damaged one."""
    with open_file(path) as file:
        try:
            return _content(_Records(file), Recorded(path, path))
        except UNREADABLE as error:
            said = cut(error) or "a record is too short"
            raise ValueError(f"{one_line(path)}: {said}") from error


def _content(inside: _Records, found: Recorded) -> Recorded:
    opcode = end = 0
    steps = _Steps(inside, found)
    for opcode, start, size in inside.data():
        end = start + size
        if opcode == Opcode.METADATA:
            said = records.Metadata.read(inside.text(start, size))
            if said.name == SETUP and not found.setup:
                found.setup = said.metadata.get("toml", "")
            elif said.name == END:
                found.steps = int(said.metadata.get("steps", ""))
        elif opcode == Opcode.ATTACHMENT:
            head = _stream(inside.at(start, min(size, _WINDOW)))
            head.read(16)  # times
            name, _, n = head.read_prefixed_string(), head.read_prefixed_string(), head.read8()
            if name == TRACE and head.count + n <= size:
                found.trace = Place(start + head.count, n)
        elif opcode == Opcode.CHUNK:
            steps.read(*inside.chunk(start, size))
    if not found.setup:
        raise ValueError("it contains no robsim session, or ends before the set-up of the session")
    if found.steps is None:
        found.problems.append("the recording was not ended: it was killed, or still continues")
    if opcode != Opcode.DATA_END and (rest := inside.size - end):
        found.problems.append(f"the last {rest} bytes are torn or damaged: they are ignored")
    return found


class _Steps:
    """Reads the steps in chunks, and the places of their pictures."""

    def __init__(self, inside: _Records, found: Recorded) -> None:
        self._inside, self._rows, self._places = inside, found.rows, found.places
        self._topics: dict[int, str] = {}

    def read(self, start: int, size: int, checksum: int) -> None:
        end, before, sequence = start, len(self._rows), -1
        for opcode, place, length in self._inside.whole(start, start + size):
            end = place + length
            if opcode == Opcode.CHANNEL:
                channel = records.Channel.read(self._inside.text(place, length))
                self._topics[channel.id] = channel.topic
            elif opcode == Opcode.MESSAGE and length >= _MESSAGE.size:
                number, count = _MESSAGE.unpack(self._inside.at(place, _MESSAGE.size))
                place, length = place + _MESSAGE.size, length - _MESSAGE.size
                topic = self._topics.get(number)
                if topic == STEPS:
                    sequence = count
                    self._add(text_in(self._inside.at(place, min(length, MOST_LINE + 10))))
                elif topic == PICTURES and count == sequence and size <= _MOST_CHUNK:
                    self._places[-1] = Place(place, length, start, size, checksum)
        is_checked = checksum and size <= _WINDOW and len(self._rows) > before
        if end != start + size:
            raise ValueError(f"the chunk at byte {start} is shorter than a record in it")
        if is_checked and zlib.crc32(self._inside.at(start, size)) != checksum:
            raise ValueError(f"the checksum of the chunk at byte {start} is wrong")

    def _add(self, line: bytes) -> None:
        try:
            row = row_of_json(line)
            if self._rows and row.k != self._rows[-1].k + 1:
                raise ValueError(f"step {row.k} follows step {self._rows[-1].k}")
            if len(self._rows) == MOST_ROWS:
                raise ValueError(f"a session must have at most {MOST_ROWS} steps")
        except (ValueError, TypeError, OverflowError) as error:
            raise ValueError(f"step {len(self._rows)} from the start: {cut(error)}") from error
        self._rows.append(row)
        self._places.append(None)


class Pieces:
    """The pieces that a `Writer` has written, until its owner takes them."""

    def __init__(self) -> None:
        self.start = self.waiting = 0  # bytes
        self._pieces: list[bytes] = []

    def write(self, piece: bytes) -> None:
        self._pieces.append(piece)
        self.waiting += len(piece)

    def tell(self) -> int:
        return self.start + self.waiting

    def flush(self) -> None:
        """Do nothing."""

    def whole(self) -> bytes:
        return b"".join(self._pieces)

    def take(self) -> None:
        self.start, self.waiting = self.tell(), 0
        self._pieces.clear()


def new_writer(pieces: Any) -> Any:
    """Return a writer of unpacked chunks; `flush` ends one."""
    return Writer(pieces, chunk_size=2**40, compression=CompressionType.NONE)


def complete(path: Path, at_rest: float = 0.0) -> str:
    """Remove a torn record at the end of a file, and write its index; return "completed".

    Nothing is done to a file that is "whole", "in use", or "damaged" other than by a kill. A file
    changed within the last `at_rest` seconds is in use: it may be a copy in progress. An OSError
    leaves a file that can be completed later.
    """
    with open(path, "r+b", opener=regular) as file:
        if time.time() - os.fstat(file.fileno()).st_mtime < at_rest:
            return "in use"
        inside = _Records(file)
        if inside.size > len(MAGIC) and inside.at(inside.size - len(MAGIC), len(MAGIC)) == MAGIC:
            return "whole"
        if not lock(file.fileno()):
            return "in use"
        end, ending = _ending(inside)
        if not (ending and inside.is_cut(end)):
            return "damaged"
        file.seek(end)
        file.truncate()
        file.write(ending)
        file.flush()
        os.fsync(file.fileno())
    return "completed"


def _ending(inside: _Records) -> tuple[int, bytes]:
    """Return the end of the whole records, and the index; b"" if robsim did not write them.

    Another writer repeats them. Its index is right if all records have the same places.
    """
    pieces, end, names = Pieces(), 0, []
    writer = new_writer(pieces)
    for opcode, start, size in inside.data():
        if opcode == Opcode.DATA_END:
            break
        end = start + size
        if opcode == Opcode.MESSAGE_INDEX:  # of the chunk
            continue
        is_at = pieces.tell() in (0, start - _RECORD.size)  # 0: the header
        if not is_at or size > _MOST_CHUNK:
            return 0, b""
        pieces.take()
        if opcode == Opcode.CHUNK:
            place, length, _ = inside.chunk(start, size)
            if sum(1 for _ in inside.whole(place, place + length)) > _MOST_IN_CHUNK:
                return 0, b""
        names.append(_write_again(writer, opcode, _stream(inside.at(start, size))))
    is_same = SETUP in names and pieces.start <= end <= pieces.tell()
    writer.finish()
    return end, pieces.whole()[end - pieces.start :] if is_same else b""


# The methods of a writer, and the attributes of a record that they take.
_METHODS = {
    records.Header: "start profile library",
    records.Metadata: "add_metadata name metadata",
    records.Attachment: "add_attachment create_time log_time name media_type data",
    records.Schema: "register_schema name encoding data",
    records.Channel: "register_channel topic message_encoding schema_id metadata",
    records.Message: "add_message channel_id log_time data publish_time sequence",
}
_KINDS: dict[int, Any] = {
    Opcode[kind.__name__.upper()]: kind
    for kind in (records.Header, records.Metadata, records.Attachment, records.Chunk)
}


def _write_again(writer: Any, opcode: int, content: ReadDataStream) -> Any:
    """Write a record, or the records of a chunk; return the name of metadata."""
    if (kind := _KINDS.get(opcode)) is None:
        return None
    record = kind.read(content)
    for part in breakup_chunk(record) if kind is records.Chunk else [record]:
        method, *names = _METHODS[type(part)].split()
        getattr(writer, method)(*(getattr(part, name) for name in names))
    if kind is records.Chunk:
        writer.flush()
    return getattr(record, "name", None)
