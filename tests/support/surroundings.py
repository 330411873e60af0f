"""The surroundings of tests: extensions, programs, sanitizers, a full disk."""

import importlib
import os
import shutil
from contextlib import contextmanager

import pytest

#: What serves a camera that an extension reads: see tests/doubles.
DOUBLES = {"firewire": "_bus_server", "gige": "_gige_server"}


def needs_extension(name):
    """Return the extension of robsim; skip the test where it is not built."""
    try:
        return importlib.import_module(f"robsim._{name}")
    except ImportError as error:
        _without(name, str(error))


def needs_double(name):
    """Return the extension of robsim; skip the test unless that and its camera are built."""
    extension = needs_extension(name)
    try:
        importlib.import_module(DOUBLES[name])
    except ImportError as error:
        _without(name, str(error))
    return extension


def needs_program(name, what):
    """Return the path of a program; skip the test where it is not installed."""
    path = shutil.which(name)
    if path is None:
        _without(what, f"there is no {name}")
    return path


def _without(what, reason):
    if what in os.environ.get("ROBSIM_NEEDS", "").split(","):
        pytest.fail(f"{what} is in ROBSIM_NEEDS, and {reason}")
    pytest.skip(reason)


#: Sanitizers that `./run sanitize` and `./run thorough` load.
_LOADED = os.environ.get("LD_PRELOAD", "")
ADDRESS_SANITIZER = "libasan" in _LOADED
THREAD_SANITIZER = "libtsan" in _LOADED


@contextmanager
def full_disk(room):
    """No file of this process grows beyond so many bytes."""
    resource = pytest.importorskip("resource", reason="a limit of POSIX")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
