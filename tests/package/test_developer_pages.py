"""The worked examples of the pages for developers run as they stand there."""

import doctest
import itertools
import types

import pytest

import robsim
from prose import ROOT, blocks
from python_devices import PATIENT

PAGES = ROOT / "python/robsim"
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not PAGES.is_dir(), reason="needs the sources"),
]


def test_the_new_room_of_the_page_works(monkeypatch):
    module, tests = blocks(PAGES / "NEW_ROOM.md")
    room = types.ModuleType("smoothing")
    exec(module, vars(room))
    monkeypatch.setattr(robsim.estimation, "moving_mean", room.moving_mean, raising=False)
    (example,) = doctest.DocTestFinder().find(room.moving_mean, globs={"robsim": robsim})
    assert example.examples
    assert doctest.DocTestRunner().run(example).failed == 0
    names = {}
    exec(tests, names)
    run = [test() for name, test in names.items() if name.startswith("test_")]
    assert len(run) == 2


def test_the_camera_of_the_page_is_good(monkeypatch):
    (program,) = blocks(PAGES / "lab/ARCHITECTURE.md")
    patient = program.replace("seconds=1.0", "seconds=300").replace(
        "Camera())", "Camera(), **PATIENT)"
    )
    times = itertools.count(step=40)
    clock = types.SimpleNamespace(monotonic=lambda: next(times))
    monkeypatch.setattr("robsim.lab.rehearsal.camera_check.time", clock)
    names = {"PATIENT": PATIENT}
    exec(patient, names)
    # A busy machine is late.
    of_time = {"frame rate", "jitter", "lost frames", "exposure to arrival"}
    assert {problem.kind for problem in names["report"].problems} <= of_time
    assert names["report"].seen == names["report"].frames > 0
