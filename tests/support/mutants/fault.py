"""A deliberate fault: one place in one file, and what stands there instead."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, order=True)
class Fault:
    """What is changed: `old`, which begins at byte `start` of a file, becomes `new`."""

    file: str
    start: int
    line: int
    old: str
    new: str
    name: str = ""

    def put_into(self, tree: Path) -> None:
        """Change the file below a folder."""
        path = tree / self.file
        content, old = path.read_bytes(), self.old.encode()
        end = self.start + len(old)
        assert content[self.start : end] == old, f"{self} is not there"
        path.write_bytes(content[: self.start] + self.new.encode() + content[end:])

    @property
    def about(self) -> str:
        """Where it is and what it changes, in a line."""
        changed = f"{' '.join(self.old.split())[:40]} -> {' '.join(self.new.split())[:40]}"
        return f"{self.name or changed}  {self.file}:{self.line}"

    def record(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)
