import itertools
from types import SimpleNamespace

import pytest

FRAMES = 8


@pytest.fixture
def _checks_few_frames(monkeypatch):
    """`check_camera` looks at so many frames in 300 s, however long that takes."""
    times = itertools.count()
    clock = SimpleNamespace(monotonic=lambda: 299 / FRAMES * next(times))
    monkeypatch.setattr("robsim.lab.rehearsal.camera_check.time", clock)
