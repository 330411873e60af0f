"""What a video file begins and ends with: no playlist, and what a note of ours says."""

from __future__ import annotations

import re
from os import SEEK_END
from pathlib import Path

from PIL import Image

from robsim.base.files import content_of
from robsim.base.text import one_line

_SYNC = rb"\x47.{%d}\x47"  # of packets in a transport stream

# Each container that FFmpeg reads and that holds its own frames, by its first bytes.
_CONTAINERS = re.compile(
    rb"|".join(
        (
            rb".{4}(?:ftyp|moov|mdat|wide|free|skip|pnot)",  # MP4, QuickTime
            rb"\x1a\x45\xdf\xa3",  # Matroska, WebM
            rb"RIFF.{4}AVI ",
            rb"OggS",
            rb"FLV\x01",
            rb"\x30\x26\xb2\x75\x8e\x66\xcf\x11",  # WMV
            rb"\x00\x00\x01[\xb3\xba]",  # MPEG-1, MPEG-2
            rb"\x06\x0e\x2b\x34",  # MXF
            rb"DKIF",  # IVF
            rb"YUV4MPEG2 ",
            _SYNC % 187,  # MPEG-TS
            rb".{4}" + _SYNC % 191,  # from a camcorder
            rb"GIF8[79]a",
        )
    ),
    re.DOTALL,
)
_LONGEST = 200  # bytes

# FFmpeg never takes a file with such a suffix for an image.
_SUFFIXES = frozenset(
    (
        *(".avi", ".flv", ".m2ts", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg"),
        *(".mpg", ".mts", ".mxf", ".ogv", ".ts", ".webm", ".wmv"),
    )
)


def check_is_video(file: Path) -> None:
    """Raise a ValueError unless a file begins as a video does.

    FFmpeg also reads playlists, and patterns of names of images: the frames of other files.
    """
    kind = Image.registered_extensions().get(file.suffix.lower())
    if kind not in (None, "MPEG", "GIF"):
        raise ValueError(f"{one_line(file)} is an image, not a video: give its folder")
    if file.suffix.lower() not in _SUFFIXES and re.search(r"[%*?{\[]", file.name):
        raise ValueError(
            f"{one_line(file)} has a name that stands for several images: give their folder, or "
            "rename it"
        )
    if not _CONTAINERS.match(content_of(file, _LONGEST)):
        raise ValueError(
            f"{one_line(file)} is not a video, or it is damaged: it begins as none does that has "
            "its frames in it"
        )


# A note at the end of a video file, in an element that players pass over: by suffix, the bytes
# before a text of 24 bytes.
_NOTE_LENGTH = 24
_PADDING = {
    ".mkv": b"\xec\x98",  # Void of Matroska
    ".webm": b"\xec\x98",
    ".avi": b"JUNK\x18\0\0\0",
    ".mp4": b"\0\0\0\x20free",
}
_NOTE = re.compile(rb"robsim headings ([1-9][0-9]{0,7}) *")


def note_headings(file: Path, headings: int) -> None:
    """Note at the end of a video how many headings the robot is drawn in."""
    text = f"robsim headings {headings}".encode().ljust(_NOTE_LENGTH)
    if len(text) > _NOTE_LENGTH:  # as good as any heading
        return
    with file.open("ab") as stream:
        stream.write(_PADDING[file.suffix.lower()] + text)


def noted_headings(file: Path) -> int | None:
    """Return what `note_headings` has noted in a video; None = nothing."""
    padding = _PADDING.get(file.suffix.lower())
    if padding is None:
        return None
    length = len(padding) + _NOTE_LENGTH
    with file.open("rb") as stream:
        size = stream.seek(0, SEEK_END)
        stream.seek(max(0, size - length))
        end = stream.read(length)
    found = _NOTE.fullmatch(end.removeprefix(padding)) if end.startswith(padding) else None
    return int(found[1]) if found else None
