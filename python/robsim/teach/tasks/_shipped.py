"""The solutions that ship: for each task a right one, and the others as changes of it.

A file of ``assets/solutions`` has those of a task, in TOML::

    [base]                   # the files of a right solution by name
    [right.NAME]             # another one: the base with these changes, in turn
    says = "..."             # the first line of its first file
    "old" = "new"            # instead of a text, in all files of the base that have it
    "motion.py" = "..."      # a file of its own

One that has a file for each slot has no others of the base. The wheel has none of these files, but
``solutions.bin``, in which nobody comes across a solution without looking for one.
"""

from __future__ import annotations

import json
import tomllib
import zlib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

from robsim.teach.tasks.solutions import Solution, with_shared

PACKED = Path(__file__).with_name("solutions.bin")

_SAYS = "says"


def pack(sources: Mapping[str, str]) -> bytes:
    """Return the solutions of tasks, as TOML by the name of the task, in one file."""
    return zlib.compress(json.dumps(sources).encode(), level=9)


def unpack(packed: bytes) -> dict[str, str]:
    """Return what was packed."""
    sources: dict[str, str] = json.loads(zlib.decompress(packed))
    return sources


@cache
def shipped_solutions(task: str, slots: tuple[str, ...]) -> tuple[Solution, ...]:
    """Return the solutions of a kind of task that ship with robsim, in the order of their file."""
    return tuple(with_shared(_solutions(unpack(PACKED.read_bytes())[task], slots)))


def _solutions(source: str, slots: tuple[str, ...]) -> Iterator[Solution]:
    tables = tomllib.loads(source)
    for kind in ("right", "wrong"):
        for name, changes in tables[kind].items():
            try:
                files = _changed(tables["base"], changes, slots)
            except ValueError as error:
                raise ValueError(f"{kind}.{name}: {error}") from None
            yield Solution(
                name=name,
                is_right=kind == "right",
                folder=None,
                files={file.removesuffix(".py"): text.encode() for file, text in files.items()},
                slots=slots,
            )


def _changed(
    base: Mapping[str, str], changes: Mapping[str, str], slots: tuple[str, ...]
) -> dict[str, str]:
    """Return the files of a solution by name."""
    own = {key: text for key, text in changes.items() if key.endswith(".py")}
    is_whole = all(f"{slot}.py" in own for slot in slots)
    files = {} if is_whole else {name: text for name, text in base.items() if name not in own}
    for key, new in changes.items():
        if key in own:
            continue
        old = next(iter(base.values())).split('"""')[1] if key == _SAYS else key
        changed = {name: text.replace(old, new) for name, text in files.items() if old in text}
        if not changed:
            raise ValueError(f"no file has the text {old!r}")
        files |= changed
    return files | own
