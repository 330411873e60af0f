"""The file of a trace: an archive of arrays with a text about the run, no pickle in it."""

from __future__ import annotations

import io
import json
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from robsim._base.checks import Floats
from robsim._base.files import write_whole
from robsim.trace._run_info import RunInfo

FORMAT = "robsim trace 1"

T = TypeVar("T")

Content = tuple[Mapping[str, Floats], RunInfo, int]
"""Groups of columns, what concerns the run as a whole, number of the first step."""


def write_trace(path: Path, content: Content) -> None:
    """Write the content of a trace into one file."""
    groups, run_info, first_step = content
    info = {
        "format": FORMAT,
        "groups": list(groups),
        "first_step": first_step,
        **run_info.as_record(),
    }
    text = np.array(json.dumps(info))
    archive = io.BytesIO()
    np.savez_compressed(archive, allow_pickle=False, info=text, **groups)
    write_whole(path, archive.getvalue())


def read_trace(path: Path, build: Callable[[Content], T]) -> T:
    """Return what `build` makes of a file that `write_trace` wrote; else a ValueError names it."""
    with path.open("rb") as file:
        try:
            if not zipfile.is_zipfile(file):
                raise ValueError("it is not an archive of arrays")
            file.seek(0)
            with np.load(file, allow_pickle=False) as archive:
                members = {name: archive[name] for name in archive.files}
            return build(_from_members(members))
        except _BROKEN as error:
            raise ValueError(f"{path} is not a trace of robsim, or damaged: {error}") from error


# What reading a broken archive raises, beside the errors of our own checks.
_BROKEN = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    OSError,
    MemoryError,
    RuntimeError,
    OverflowError,
    zipfile.BadZipFile,
    zlib.error,
    SyntaxError,
    tokenize.TokenError,
)


def _from_members(members: Mapping[str, NDArray[Any]]) -> Content:
    if "info" not in members:
        raise ValueError("it has no info")
    info = json.loads(str(members["info"]))
    if info.pop("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT!r}")
    first_step = info.pop("first_step")
    groups = {name: values for name, values in members.items() if name != "info"}
    if sorted(info.pop("groups")) != sorted(groups):
        raise ValueError(
            f"its groups are not those that it was saved with, but {', '.join(groups)}"
        )
    for name, values in groups.items():
        if values.dtype != np.float64 or values.ndim != 2:
            raise ValueError(f"{name} is {values.dtype} of shape {values.shape}")
    info["area"] = tuple(info["area"])
    for name in ("callbacks", "changed"):
        info[name] = tuple(info.get(name, ()))
    return groups, RunInfo(**info), first_step
