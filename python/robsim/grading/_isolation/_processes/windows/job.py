"""Job objects: what is in one has limits, and ends with it."""

from __future__ import annotations

import ctypes
import math
import sys
from ctypes import wintypes
from subprocess import Popen
from typing import Any

from robsim.grading._isolation._limits import Limits

assert sys.platform == "win32"

_kernel = ctypes.WinDLL("kernel32", use_last_error=True)
_psapi = ctypes.WinDLL("psapi", use_last_error=True)

_EXTENDED_LIMITS, _USER_INTERFACE = 9, 4  # kinds of information on a job
_PROCESS_TIME, _ACTIVE_PROCESS, _PROCESS_MEMORY = 0x2, 0x8, 0x100
_DIE_ON_UNHANDLED_EXCEPTION, _KILL_ON_JOB_CLOSE = 0x400, 0x2000
_ALL_OF_USER_INTERFACE = 0xFF
_TICK = 1e-7  # s


class _BasicLimits(ctypes.Structure):
    _fields_ = (
        ("process_time", ctypes.c_int64),
        ("job_time", ctypes.c_int64),
        ("flags", wintypes.DWORD),
        ("least_working_set", ctypes.c_size_t),
        ("most_working_set", ctypes.c_size_t),
        ("processes", wintypes.DWORD),
        ("affinity", ctypes.c_size_t),
        ("priority_class", wintypes.DWORD),
        ("scheduling_class", wintypes.DWORD),
    )


class _ExtendedLimits(ctypes.Structure):
    _fields_ = (
        ("basic", _BasicLimits),
        ("io", ctypes.c_uint64 * 6),
        ("process_memory", ctypes.c_size_t),
        ("job_memory", ctypes.c_size_t),
        ("peak_process_memory", ctypes.c_size_t),
        ("peak_job_memory", ctypes.c_size_t),
    )


class _Memory(ctypes.Structure):
    _fields_ = (
        ("size", wintypes.DWORD),
        ("page_faults", wintypes.DWORD),
        ("peak_working_set", ctypes.c_size_t),
        ("working_set", ctypes.c_size_t),
        ("quotas", ctypes.c_size_t * 4),
        ("pagefile", ctypes.c_size_t),
        ("peak_pagefile", ctypes.c_size_t),
    )


def _declare(library: ctypes.WinDLL, name: str, *arguments: Any) -> None:
    """Say what a function gets behind a handle."""
    getattr(library, name).argtypes = (wintypes.HANDLE, *arguments)


_kernel.CreateJobObjectW.restype = wintypes.HANDLE
_declare(_kernel, "SetInformationJobObject", ctypes.c_int, ctypes.c_void_p, wintypes.DWORD)
_declare(_kernel, "AssignProcessToJobObject", wintypes.HANDLE)
_declare(_kernel, "TerminateJobObject", wintypes.UINT)
_declare(_kernel, "CloseHandle")
_declare(_kernel, "GetProcessTimes", *[ctypes.c_void_p] * 4)
_declare(_psapi, "GetProcessMemoryInfo", ctypes.c_void_p, wintypes.DWORD)


class Job:
    """A job object: whatever is in it ends when this ends it, or when this process ends.

    Parameters
    ----------
    limits : Limits, optional
        What a process in it may take; with them there is one alone.
    """

    def __init__(self, limits: Limits | None) -> None:
        self._handle = _kernel.CreateJobObjectW(None, None)
        if not self._handle:
            raise ctypes.WinError(ctypes.get_last_error())
        try:
            self._limit(limits)
        except BaseException:
            self.close()
            raise

    def _limit(self, limits: Limits | None) -> None:
        most = _ExtendedLimits()
        most.basic.flags = _KILL_ON_JOB_CLOSE | _DIE_ON_UNHANDLED_EXCEPTION
        if limits is not None:
            most.basic.flags |= _PROCESS_TIME | _ACTIVE_PROCESS | _PROCESS_MEMORY
            most.basic.process_time = round(math.ceil(limits.cpu) / _TICK)
            most.basic.processes = 1
            most.process_memory = limits.memory
            self._set(_USER_INTERFACE, wintypes.DWORD(_ALL_OF_USER_INTERFACE))
        self._set(_EXTENDED_LIMITS, most)

    def _set(self, kind: int, content: ctypes.Structure | wintypes.DWORD) -> None:
        size = ctypes.sizeof(content)
        _check(_kernel.SetInformationJobObject(self._handle, kind, ctypes.byref(content), size))

    def take(self, process: Popen[bytes]) -> None:
        """Take a process that has started nothing yet."""
        _check(_kernel.AssignProcessToJobObject(self._handle, _handle_of(process)))

    def end(self, code: int) -> None:
        """End all that is in it; this is the exit code."""
        _kernel.TerminateJobObject(self._handle, code)

    def close(self) -> None:
        """Let it go, with all that is in it."""
        _kernel.CloseHandle(self._handle)


def cpu_seconds(process: Popen[bytes]) -> float:
    """Return the processor time of all threads of a process that runs, or has run."""
    times = (ctypes.c_uint64 * 4)()  # begin, end, in the system, in the program
    each = [ctypes.byref(times, 8 * index) for index in range(4)]
    _check(_kernel.GetProcessTimes(_handle_of(process), *each))
    return float((times[2] + times[3]) * _TICK)


def memory_of(process: Popen[bytes]) -> tuple[int, int]:
    """Return the memory that a process has asked for, and the most that it had in use (bytes)."""
    memory = _Memory(ctypes.sizeof(_Memory))
    _check(_psapi.GetProcessMemoryInfo(_handle_of(process), ctypes.byref(memory), memory.size))
    return int(memory.pagefile), int(memory.peak_working_set)


def _handle_of(process: Popen[bytes]) -> int:
    return int(process._handle)  # type: ignore[attr-defined]


def _check(done: int) -> None:
    if not done:
        raise ctypes.WinError(ctypes.get_last_error())
