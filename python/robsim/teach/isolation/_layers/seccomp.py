"""seccomp: the kernel refuses all calls that callbacks do not need."""

from __future__ import annotations

import ctypes
import os
import platform
import struct
from dataclasses import dataclass

from robsim.teach.isolation._layers.calls import DENIED, PR_SET_NO_NEW_PRIVS, PR_SET_SECCOMP, prctl

_FILTER = 2  # the mode of seccomp
_EPERM, _ENOSYS = 1, 38
_ALLOW, _KILL = 0x7FFF0000, 0x80000000


def _refuse(number: int) -> int:
    return 0x00050000 | number


# Instructions of the kernel's small virtual machine (linux/bpf_common.h), and offsets of the call.
_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_CALL, _ARCHITECTURE = 0, 4


def _low(argument: int) -> int:
    return 16 + 8 * argument


_CLONE_THREAD = 0x10000
_CLONE_NAMESPACES = 0x7E020080
# Forbidden settings of a worker for itself or others: (call, its argument, values).
_PRCTL = (1, 4, 35, 36, 0x59616D61)  # death signal, dumpable, memory map, subreaper, ptracer
_FCNTL = (8, 10, 15, 1024, 1026)  # whom and how to signal; leases, watches of folders
_IOCTL = (0x5412, 0x541C, 0x8901, 0x8902)  # keys into a terminal; whom to signal

Instruction = tuple[int, int, int, int]


@dataclass(frozen=True)
class Processor:
    """Numbers of a processor: its name to the kernel, its column of the table, special calls."""

    audit: int
    column: int
    clone: int
    clone3: int
    tgkill: int
    prlimit64: int
    prctl: int
    fcntl: int
    ioctl: int


PROCESSORS = {
    "x86_64": Processor(0xC000003E, 0, 56, 435, 234, 302, 157, 72, 16),
    "aarch64": Processor(0xC00000B7, 1, 220, 435, 131, 261, 167, 25, 29),
}


def restrict() -> str:
    """Restrict this process and its later threads to allowed calls; return the method.

    Raise OSError for an unknown processor, or if the kernel refuses.
    """
    machine = platform.machine()
    if machine not in PROCESSORS:
        raise OSError(f"robsim has no table of system calls for {machine}")
    program = program_for(PROCESSORS[machine], os.getpid())
    code = b"".join(struct.pack("<HBBI", *instruction) for instruction in program)
    instructions = ctypes.create_string_buffer(code)
    header = struct.pack("<H6xQ", len(program), ctypes.addressof(instructions))
    pointer = ctypes.create_string_buffer(header)
    prctl(PR_SET_NO_NEW_PRIVS, 1)
    prctl(PR_SET_SECCOMP, _FILTER, ctypes.addressof(pointer))
    return "seccomp"


def program_for(processor: Processor, process: int) -> list[Instruction]:
    """Return the filter for a process: denied calls get EPERM, all others are allowed."""
    p = processor
    refused: Instruction = (_RETURN, 0, 0, _refuse(_EPERM))
    program: list[Instruction] = [
        (_LOAD, 0, 0, _ARCHITECTURE),
        (_EQUAL, 1, 0, p.audit),  # refuses calls in 32-bit mode
        (_RETURN, 0, 0, _KILL),
        (_LOAD, 0, 0, _CALL),
    ]
    if p is PROCESSORS["x86_64"]:
        program += [(_AT_LEAST, 0, 1, 0x40000000), refused]  # x32: other numbers, same calls
    for numbers in DENIED.values():
        if (number := numbers[p.column]) is not None:
            program += [(_EQUAL, 0, 1, number), refused]
    # libc falls back to clone, whose flags a filter can read.
    program += [(_EQUAL, 0, 1, p.clone3), (_RETURN, 0, 0, _refuse(_ENOSYS))]
    program += _one_of(p.prctl, 0, _PRCTL) + _one_of(p.fcntl, 1, _FCNTL)
    program += _one_of(p.ioctl, 1, _IOCTL)
    program += [  # a signal only to its own threads: abort() needs one
        *((_EQUAL, 0, 4, p.tgkill), (_LOAD, 0, 0, _low(0)), (_EQUAL, 1, 0, process)),
        *(refused, (_RETURN, 0, 0, _ALLOW)),
    ]
    program += [  # read limits, but do not set them: the new limit is no pointer
        *((_EQUAL, 0, 6, p.prlimit64), (_LOAD, 0, 0, _low(2)), (_EQUAL, 0, 3, 0)),
        *((_LOAD, 0, 0, _low(2) + 4), (_EQUAL, 0, 1, 0), (_RETURN, 0, 0, _ALLOW), refused),
    ]
    program += [  # threads, but neither processes nor namespaces
        *((_EQUAL, 0, 4, p.clone), (_LOAD, 0, 0, _low(0)), (_ANY_BIT, 0, 1, _CLONE_THREAD)),
        *((_ANY_BIT, 0, 1, _CLONE_NAMESPACES), refused),
    ]
    return [*program, (_RETURN, 0, 0, _ALLOW)]


def _one_of(call: int, argument: int, values: tuple[int, ...]) -> list[Instruction]:
    """Return instructions that refuse a call whose argument is one of some values."""
    checks: list[Instruction] = [(_LOAD, 0, 0, _low(argument))]
    for value in values:
        checks += [(_EQUAL, 0, 1, value), (_RETURN, 0, 0, _refuse(_EPERM))]
    checks.append((_LOAD, 0, 0, _CALL))  # for the next checks
    return [(_EQUAL, 0, len(checks), call), *checks]
