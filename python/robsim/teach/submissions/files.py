"""A submission after reading, and its message to the worker."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any

from robsim.teach.submissions.names import checked_path

#: Kinds of submissions: files named after slots, one Python file, or a notebook.
FOLDER, FILE, NOTEBOOK = "folder", "file", "notebook"

_MAGIC = b"robsim submission 1\n"
_LENGTHS = struct.Struct("<II")  # of the heading, of the contents


@dataclass(frozen=True)
class SubmissionFiles:
    """A submission that was read without running it."""

    name: str  # of its folder or file
    kind: str  # `FOLDER`, `FILE` or `NOTEBOOK`
    main: str  # the file that defines the slots; empty for a folder
    sources: Mapping[str, bytes]  # by path, with ``/``; of a notebook only code and tags
    slots: tuple[str, ...]  # its slots and functions, without forbidden ones
    notes: tuple[str, ...] = ()  # sentences on omitted files

    def __post_init__(self) -> None:
        object.__setattr__(self, "sources", MappingProxyType(dict(self.sources)))

    def __reduce__(self) -> tuple[Any, ...]:
        given = (self.name, self.kind, self.main, dict(self.sources), self.slots, self.notes)
        return SubmissionFiles, given

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
        """Return the submission as bytes, for digests: a JSON heading, and the files' contents."""
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
