"""Landlock: the worker sees only granted files, has no TCP, and cannot signal other processes."""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from robsim.teach.isolation._layers.calls import PR_SET_NO_NEW_PRIVS, prctl, syscall

assert sys.platform == "linux"

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446  # the same on all processors
_VERSION = 1  # a flag of _CREATE_RULESET
_PATH_BENEATH = 1

_WRITE_FILE, _READ_FILE, _READ_DIR = 1 << 1, 1 << 2, 1 << 3
_REMOVE, _MAKE_DIR, _MAKE_FILE = 1 << 4 | 1 << 5, 1 << 7, 1 << 8
_REFER, _TRUNCATE, _IOCTL_DEVICE = 1 << 13, 1 << 14, 1 << 15
_OF_ABI_1 = (1 << 13) - 1

READ = _READ_FILE | _READ_DIR
LIST = _READ_DIR
DEVICE = _READ_FILE | _WRITE_FILE
SCRATCH = READ | _WRITE_FILE | _REMOVE | _MAKE_DIR | _MAKE_FILE | _REFER | _TRUNCATE

#: A descriptor of a path, and the rights granted below it.
Grant = tuple[int, int]


def landlock_abi() -> int:
    """Return the kernel's version of Landlock; 0 = without Landlock."""
    try:
        return syscall(_CREATE_RULESET, None, 0, _VERSION)
    except OSError:
        return 0


def _handled(abi: int) -> tuple[int, int, int]:
    """Return the rights that a version can forbid: on files, network and other processes."""
    files = _OF_ABI_1
    files |= _REFER if abi >= 2 else 0
    files |= _TRUNCATE if abi >= 3 else 0
    files |= _IOCTL_DEVICE if abi >= 5 else 0
    return files, 3 if abi >= 4 else 0, 3 if abi >= 6 else 0


def restrict(grants: Iterable[Grant]) -> int:
    """Restrict this process and its children to grants; return the version of Landlock.

    Raise OSError if the kernel has no Landlock, or refuses.
    """
    abi = landlock_abi()
    if not abi:
        raise OSError("the kernel has no Landlock")
    handled = _handled(abi)
    size = 8 if abi < 4 else 16 if abi < 6 else 24
    rules = syscall(_CREATE_RULESET, struct.pack("<QQQ", *handled)[:size], size, 0)
    try:
        for descriptor, rights in grants:
            rule = struct.pack("<Qi", rights & handled[0], descriptor)
            syscall(_ADD_RULE, rules, _PATH_BENEATH, rule, 0)
        prctl(PR_SET_NO_NEW_PRIVS, 1)
        syscall(_RESTRICT_SELF, rules, 0)
    finally:
        os.close(rules)
    return abi


def open_grants(trees: Iterable[Path], hidden: Sequence[Path]) -> list[Grant]:
    """Return grants to read all files in trees except hidden ones.

    Landlock can only allow: in a folder with a hidden entry, the other entries are granted
    one by one. The folder may be listed, because the import of a module needs this.
    """
    forbidden = [Path(os.path.realpath(path)) for path in hidden]
    grants = []
    for tree in dict.fromkeys(Path(os.path.realpath(tree)) for tree in trees):
        for path, rights in _granted(tree, forbidden):
            with suppress(OSError):  # gone, or closed to us
                descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
                grants.append((descriptor, rights if path.is_dir() else rights & ~_READ_DIR))
    return grants


def _granted(path: Path, hidden: list[Path]) -> Iterator[tuple[Path, int]]:
    if any(path.is_relative_to(secret) for secret in hidden):
        return
    if not any(secret.is_relative_to(path) for secret in hidden):
        yield path, READ
        return
    yield path, LIST
    for child in path.iterdir():
        if not child.is_symlink() or not _touches(child, hidden):
            yield from _granted(child, hidden)


def _touches(link: Path, hidden: list[Path]) -> bool:
    """Return whether a link leads into a hidden path, or above it."""
    end = Path(os.path.realpath(link))
    return any(end.is_relative_to(secret) or secret.is_relative_to(end) for secret in hidden)
