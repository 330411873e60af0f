"""A disk that is full, for tests."""

from contextlib import contextmanager

import pytest


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
