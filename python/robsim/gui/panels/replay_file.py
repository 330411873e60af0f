"""Replay files: scenario, callbacks and changes of a run, as text."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from typing import Any

import numpy as np

from robsim.base.checks import Floats
from robsim.base.files import as_path, read_text
from robsim.base.files.reading import parse_json
from robsim.base.text import one_line
from robsim.simulation.slots import SLOTS

FORMAT = "robsim replay 1"
_MOST_BYTES = 1 << 26
_MOST_STEPS = 1_000_000
_KINDS: dict[str, type] = {
    **{"format": str, "scenario": str, "slots": list, "files": dict, "changes": list},
    **{"steps": int, "digest": str},
}
_MESSAGES = ("set", "go_to", "path")  # of the browser, which change a run


@dataclass(frozen=True)
class ReplayFile:
    """A run: its start, and each change with its step, stage and message or files."""

    scenario: str  # TOML
    slots: Sequence[str]  # that files fill
    files: Mapping[str, str]  # source of Python modules by name, without .py
    changes: Sequence[Sequence[Any]]
    steps: int
    digest: str
    format: str = FORMAT

    def to_text(self) -> str:
        return json.dumps(asdict(self), indent=1)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> ReplayFile:
        """Read a file without running its code. ValueError: the file is damaged."""
        file = as_path(path)
        try:
            return cls.of_text(read_text(file, _MOST_BYTES))
        except ValueError as error:
            raise ValueError(f"{one_line(file)}: {error}") from None

    @classmethod
    def of_text(cls, text: str) -> ReplayFile:
        """Parse a text; a ValueError gives the reason for a refusal."""
        if len(text) > _MOST_BYTES:
            raise ValueError(f"the file has more than {_MOST_BYTES >> 20} MB")
        told = parse_json(text)
        if not isinstance(told, dict) or told.get("format") != FORMAT:
            raise ValueError("not a replay file of this version")
        if told.keys() != _KINDS.keys() or any(type(told[n]) is not k for n, k in _KINDS.items()):
            raise ValueError("a part is missing")
        found = cls(**told)
        found._check()
        return found

    def _check(self) -> None:
        ks = [self._checked_change(change)[0] for change in self.changes]
        if self.steps > _MOST_STEPS:
            raise ValueError(f"the run has more than {_MOST_STEPS} steps")
        if self.steps < 0 or ks != sorted(ks) or ks[-1:] > [self.steps]:
            raise ValueError("the steps are not in order")
        sources = [self.files, *(told for *_, told in self.changes if "type" not in told)]
        for name, text in (item for files in sources for item in files.items()):
            if not (name.isidentifier() and isinstance(text, str)):  # no path, such as ../x
                raise ValueError("invalid names of Python files")
        if any(slot not in list(SLOTS) for slot in self.slots):
            raise ValueError("unknown slots")

    @staticmethod
    def _checked_change(change: Any) -> tuple[int, str, dict[str, Any]]:
        if isinstance(change, list) and [*map(type, change)] == [int, str, dict]:
            k, stage, told = change
            if k >= 0 and told.get("type", _MESSAGES[0]) in _MESSAGES:
                return k, stage, told
        raise ValueError("a change is damaged")

    @property
    def code(self) -> dict[str, int]:
        """The number of lines of each Python file, by name, in its longest version."""
        files = [self.files, *(told for *_, told in self.changes if "type" not in told)]
        lines: dict[str, int] = {}
        for name, text in (item for one in files for item in one.items()):
            lines[f"{name}.py"] = max(lines.get(f"{name}.py", 0), len(text.splitlines()))
        return lines


def digest_of(columns: Mapping[str, Floats]) -> str:
    """Return a checksum of the columns of a trace."""
    parts = (np.ascontiguousarray(columns[name]).tobytes() for name in sorted(columns))
    return hashlib.sha256(b"".join(parts)).hexdigest()
