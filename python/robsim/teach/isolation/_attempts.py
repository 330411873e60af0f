"""Harmless attempts of a worker to leave its sandbox, for a report on the isolation."""

from __future__ import annotations

import ctypes
import json
import os
import socket
import sys
from collections.abc import Callable
from typing import Any

_PTRACE_SEIZE, _PTRACE_DETACH, _IN_CREATE = 0x4206, 17, 0x100


def run(channel: socket.socket, memory: tuple[int, ...]) -> None:
    """Read the targets, make all attempts, and send their outcomes."""
    target = json.loads(channel.recv(1 << 16))
    answers = {name: _outcome(act, target) for name, act in ATTEMPTS.items()}
    channel.sendall(json.dumps(answers).encode() + b"\n")


def _outcome(act: Callable[[dict[str, Any]], str], target: dict[str, Any]) -> list[Any]:
    try:
        return [False, act(target)]
    except (OSError, AttributeError, RuntimeError) as error:
        return [True, getattr(error, "strerror", None) or str(error)]


def _read_file(target: dict[str, Any]) -> str:
    with open(target["file"], "rb") as file:
        return f"read {len(file.read())} bytes of a file of the grader's"


def _read_hidden(target: dict[str, Any]) -> str:
    with open(target["hidden"], "rb") as file:
        return f"read {len(file.read())} bytes of a hidden file"


def _find_file(target: dict[str, Any]) -> str:
    return f"found a file of the grader's, of {os.stat(target['file']).st_size} bytes"


def _watch_folder(target: dict[str, Any]) -> str:
    libc = ctypes.CDLL(None, use_errno=True)
    watch, folder = _checked(libc.inotify_init1(0)), os.fsencode(target["folder"])
    _checked(libc.inotify_add_watch(watch, folder, _IN_CREATE))
    return "watches names in a folder of the grader's"


def _change_file(target: dict[str, Any]) -> str:
    os.chmod(target["file"], 0o644)
    return "changed the rights of a file of the grader's"


def _write_outside(target: dict[str, Any]) -> str:
    with open(os.path.join(target["folder"], "left"), "w") as file:
        file.write("left")
    return "left a file in a folder that all may write to"


def _read_memory(target: dict[str, Any]) -> str:
    with open(f"/proc/{target['process']}/mem", "rb") as file:
        file.seek(target["address"])
        return f"read {len(file.read(8))} bytes of the grader's memory"


class _Piece(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("length", ctypes.c_size_t))


def _copy_memory(target: dict[str, Any]) -> str:
    own = ctypes.create_string_buffer(8)
    to = _Piece(ctypes.addressof(own), 8)
    of = _Piece(target["address"], 8)
    libc = ctypes.CDLL(None, use_errno=True)
    words = (ctypes.byref(to), ctypes.c_ulong(1), ctypes.byref(of), ctypes.c_ulong(1))
    count = libc.process_vm_readv(ctypes.c_int(target["process"]), *words, ctypes.c_ulong(0))
    return f"copied {_checked(count)} bytes of the grader's memory"


def _trace(target: dict[str, Any]) -> str:
    libc = ctypes.CDLL(None, use_errno=True)
    process = ctypes.c_long(target["process"])
    _checked(libc.ptrace(ctypes.c_long(_PTRACE_SEIZE), process, None, None))
    libc.ptrace(ctypes.c_long(_PTRACE_DETACH), process, None, None)
    return "traced the grader"


def _connect(target: dict[str, Any]) -> str:
    with socket.create_connection(("127.0.0.1", target["port"]), timeout=5):
        return "connected to a server of this machine"


def _send(target: dict[str, Any]) -> str:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"x", ("127.0.0.1", target["port"]))
    return "sent a packet"


def _fork(target: dict[str, Any]) -> str:
    if sys.platform == "win32":
        raise NotImplementedError
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)
    return "started a process"


def _execute(target: dict[str, Any]) -> str:
    """Try to run a missing program: if the attempt is allowed, other programs can run."""
    try:
        os.execv("/nonexistent/robsim", ["robsim"])
    except FileNotFoundError:
        return "may run programs"
    return "ran a program"


def _signal(target: dict[str, Any]) -> str:
    os.kill(target["process"], 0)
    return "may signal the grader"


def _checked(result: int) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return int(result)


ATTEMPTS: dict[str, Callable[[dict[str, Any]], str]] = {
    "read a file": _read_file,
    "read a hidden file": _read_hidden,
    "change a file": _change_file,
    "write outside its folder": _write_outside,
    "connect": _connect,
    "send a packet": _send,
}
if sys.platform != "win32":
    ATTEMPTS |= {"start a process": _fork, "run a program": _execute, "signal the grader": _signal}
if sys.platform == "linux":
    ATTEMPTS |= {
        "find a file": _find_file,
        "watch a folder": _watch_folder,
        "open the grader's memory": _read_memory,
        "copy the grader's memory": _copy_memory,
        "trace the grader": _trace,
    }
