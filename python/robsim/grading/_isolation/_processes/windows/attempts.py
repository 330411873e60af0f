"""What a worker tries on Windows; each attempt does no harm."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from collections.abc import Callable
from ctypes import wintypes
from typing import Any

assert sys.platform == "win32"

_TERMINATE, _VM_READ = 0x1, 0x10

_kernel = ctypes.WinDLL("kernel32", use_last_error=True)
_kernel.OpenProcess.argtypes = (wintypes.DWORD, wintypes.BOOL, wintypes.DWORD)
_kernel.OpenProcess.restype = wintypes.HANDLE
_kernel.CloseHandle.argtypes = (wintypes.HANDLE,)
_kernel.ReadProcessMemory.argtypes = (
    *(wintypes.HANDLE, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t),
    ctypes.c_void_p,
)


def _start(target: dict[str, Any]) -> str:
    subprocess.run([sys.executable, "-I", "-S", "-c", ""], check=False)
    return "started a process"


def _may_end(target: dict[str, Any]) -> str:
    _kernel.CloseHandle(_opened(target, _TERMINATE))
    return "may end the grader"


def _read_memory(target: dict[str, Any]) -> str:
    own = ctypes.create_string_buffer(8)
    process = _opened(target, _VM_READ)
    try:
        if not _kernel.ReadProcessMemory(process, target["address"], own, len(own), None):
            raise ctypes.WinError(ctypes.get_last_error())
    finally:
        _kernel.CloseHandle(process)
    return f"read {len(own)} bytes of the grader's memory"


def _opened(target: dict[str, Any], rights: int) -> int:
    process = _kernel.OpenProcess(rights, False, target["process"])
    if not process:
        raise ctypes.WinError(ctypes.get_last_error())
    return int(process)


ATTEMPTS: dict[str, Callable[[dict[str, Any]], str]] = {
    "start a process": _start,
    "end the grader": _may_end,
    "read the grader's memory": _read_memory,
}
