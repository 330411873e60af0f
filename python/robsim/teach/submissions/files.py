"""A submission as it was read, and as it goes to the worker."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any

from robsim.teach.submissions.names import checked_path

#: What a submission is: files named after slots, one Python file, or a notebook.
FOLDER, FILE, NOTEBOOK = "folder", "file", "notebook"

_MAGIC = b"robsim submission 1\n"
_LENGTHS = struct.Struct("<II")  # of the heading, of the contents
_MOST_HEADING = 2**22  # bytes
_MOST_CONTENTS = 2**28


@dataclass(frozen=True)
class SubmissionFiles:
    """A submission that was read, and not run."""

    name: str  # of its folder or file
    kind: str  # `FOLDER`, `FILE` or `NOTEBOOK`
    main: str  # the file that defines the slots; empty for a folder
    sources: Mapping[str, bytes]  # by path, with ``/``; of a notebook only code and tags
    slots: tuple[str, ...]  # its slots and functions, without forbidden ones
    notes: tuple[str, ...] = ()  # sentences on omitted files

    def __post_init__(self) -> None:
        object.__setattr__(self, "sources", MappingProxyType(dict(self.sources)))

    def __reduce__(self) -> tuple[Any, ...]:
        return SubmissionFiles.from_message, (self.to_message(),)

    @property
    def modules(self) -> dict[str, bytes]:
        return {
            PurePosixPath(path).stem: content
            for path, content in self.sources.items()
            if "/" not in path and path.endswith(".py")
        }

    def write_to(self, folder: str | PathLike[str]) -> None:
        """Write the files into an empty folder; raise SubmissionError if a path leads out of it."""
        for path, content in self.sources.items():
            if (counted := checked_path(path, self.name)) is not None:
                file = Path(folder, counted)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(content)

    def to_message(self) -> bytes:
        """Return it as bytes: a heading in JSON, and the contents of the files."""
        heading = {
            "name": self.name,
            "kind": self.kind,
            "main": self.main,
            "slots": self.slots,
            "notes": self.notes,
            "files": [[path, len(content)] for path, content in self.sources.items()],
        }
        text = json.dumps(heading).encode("ascii")
        contents = b"".join(self.sources.values())
        return _MAGIC + _LENGTHS.pack(len(text), len(contents)) + text + contents

    @classmethod
    def from_message(cls, message: bytes) -> SubmissionFiles:
        """Return the submission of `to_message`; raise ValueError for other bytes."""
        start = len(_MAGIC) + _LENGTHS.size
        if len(message) < start or not message.startswith(_MAGIC):
            raise ValueError("a submission's message must start with its mark")
        length, size = _LENGTHS.unpack_from(message, len(_MAGIC))
        if length > _MOST_HEADING or size > _MOST_CONTENTS or len(message) != start + length + size:
            raise ValueError(f"a submission's message has wrong lengths: {length} and {size} bytes")
        try:
            heading = json.loads(message[start : start + length])
            name, kind, main = (_text(heading[key]) for key in ("name", "kind", "main"))
            slots, notes = (tuple(map(_text, heading[key])) for key in ("slots", "notes"))
            sources = _taken_apart(heading["files"], memoryview(message)[start + length :])
        except (ValueError, TypeError, KeyError, RecursionError) as error:
            raise ValueError("a submission's message has a wrong heading") from error
        if kind not in (FOLDER, FILE, NOTEBOOK):
            raise ValueError("a submission's message has a wrong heading")
        return cls(name, kind, main, sources, slots, notes)


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError("not a text")
    return value


def _taken_apart(files: Iterable[tuple[str, int]], contents: memoryview) -> dict[str, bytes]:
    sources: dict[str, bytes] = {}
    for path, size in files:
        if type(size) is not int or not 0 <= size <= len(contents):
            raise ValueError("a size is wrong")
        sources[_text(path)] = bytes(contents[:size])
        contents = contents[size:]
    if len(contents):
        raise ValueError("the sizes do not add up")
    return sources
