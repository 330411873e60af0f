"""The worked examples of the pages for developers run as they stand there."""

import doctest
import types

import pytest

import robsim
from prose import ROOT, blocks

PAGES = ROOT / "python/robsim"
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not PAGES.is_dir(), reason="needs the sources"),
]


def test_the_new_room_of_the_page_works(monkeypatch):
    module, _, tests = blocks(PAGES / "NEW_ROOM.md")
    room = types.ModuleType("moving_mean")
    exec(module, vars(room))
    (example,) = doctest.DocTestFinder().find(
        room.moving_mean, globs={**vars(room), "robsim": robsim}
    )
    assert example.examples
    assert doctest.DocTestRunner().run(example).failed == 0
    monkeypatch.setattr(robsim.estimation, "moving_mean", room.moving_mean, raising=False)
    names = {}
    exec(tests, names)
    run = [test() for name, test in names.items() if name.startswith("test_")]
    assert len(run) == 2
