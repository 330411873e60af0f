"""The sources of a submission: a folder of callbacks, as bytes, and loaded again."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any

from robsim.simulation._folders.callback_folder import CallbackFolder


def read(path: str | PathLike[str], slots: Sequence[str]) -> bytes:
    """Return the sources of a folder."""
    sources: Mapping[str, bytes] = CallbackFolder(path, slots)._read()
    return pickle.dumps((Path(path).name, dict(sources)))


@contextmanager
def loaded(message: bytes, slots: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Give the callbacks by slot, which import each other in the context."""
    name, sources = pickle.loads(message)
    folder, callbacks = CallbackFolder.of_sources(Path(name), Path(name), sources, tuple(slots))
    with folder.importable():
        yield dict(callbacks)
