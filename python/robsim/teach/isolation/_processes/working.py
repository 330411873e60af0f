"""The work of a worker: it prepares itself, reports its layers, and calls its entry."""

from __future__ import annotations

import builtins
import importlib
import io
import json
import os
import socket
import sys
import tempfile
import traceback
from collections.abc import Sequence
from functools import partial
from typing import Any, TextIO

from robsim.teach.isolation._layers.layer import Layers
from robsim.teach.isolation.ending import NO_MEMORY, NOT_SHUT_IN
from robsim.teach.isolation.limits import Request

# Of OpenCV. matplotlib has its backend from the environment.
_WINDOWS = (
    "imshow namedWindow moveWindow resizeWindow setWindowTitle setMouseCallback createTrackbar "
    "destroyWindow destroyAllWindows waitKey waitKeyEx"
)


def settle(scratch: str) -> None:
    """Print unbuffered to descriptors 1 and 2, use a folder as home, and show no windows."""
    sys.stdout, sys.stderr = _unbuffered(1), _unbuffered(2)
    os.chdir(scratch)
    for name in ("HOME", "USERPROFILE", "TMPDIR", "TMP", "TEMP", "MPLCONFIGDIR"):
        os.environ[name] = scratch
    tempfile.tempdir = scratch
    builtins.__import__ = partial(_imported, builtins.__import__)


def _imported(plain: Any, name: str, *how: Any, **options: Any) -> Any:
    module = plain(name, *how, **options)
    if name.partition(".")[0] == "cv2":
        no_key = dict.fromkeys(_WINDOWS.split(), lambda *_, **__: -1)
        vars(sys.modules["cv2"]).update(no_key)
    return module


def _unbuffered(descriptor: int) -> TextIO:
    """Return a stream that keeps all output, however the process ends."""
    raw = open(descriptor, "wb", buffering=0, closefd=False)  # noqa: SIM115
    return io.TextIOWrapper(raw, "utf-8", "backslashreplace", newline="\n", write_through=True)


def tell(layers: Layers, report: socket.socket) -> None:
    report.sendall(json.dumps({"layers": layers.to_message()}).encode() + b"\n")


def work(
    request: Request, layers: Layers, connection: socket.socket, memory: Sequence[int] = ()
) -> int:
    """Call the entry; return the exit code."""
    if request.isolation == "strict" and not all(layers.closed.values()):
        return NOT_SHUT_IN
    module, _, function = request.entry.partition(":")
    try:
        getattr(importlib.import_module(module), function)(connection, tuple(memory))
    except MemoryError:
        return NO_MEMORY
    except SystemExit as error:
        return error.code if isinstance(error.code, int) else int(error.code is not None)
    except BaseException:
        traceback.print_exc()
        return 1
    return 0
