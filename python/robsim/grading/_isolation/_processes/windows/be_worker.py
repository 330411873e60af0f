"""A fresh process that becomes a worker, on Windows; in the worker."""

from __future__ import annotations

import base64
import importlib
import json
import os
import socket
import sys
import traceback
from typing import Any, NoReturn

from robsim.grading._isolation._ending import NOT_SHUT_IN
from robsim.grading._isolation._layers.layer import PROCESS, Layer, Layers
from robsim.grading._isolation._processes.working import settle, tell, work
from robsim.grading._isolation._request import Request

assert sys.platform == "win32"


def main() -> NoReturn:
    """Become the worker that standard input tells of."""
    code = NOT_SHUT_IN
    try:
        code = _be_worker(json.loads(sys.stdin.buffer.read()))
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)


def _be_worker(message: dict[str, Any]) -> int:
    connection, life = (socket.fromshare(base64.b64decode(each)) for each in message["sockets"])
    sys.path.extend(message["path"])
    for module in message["modules"]:
        importlib.import_module(module)
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, 0)
    os.close(null)
    settle(message["scratch"])
    made = [Layer(*values) for values in message["layers"]]
    layers = Layers((Layer(PROCESS, True, ""), *made))
    with life:
        tell(layers, life)
    with connection:
        return work(Request.from_message(message["request"]), layers, connection)
