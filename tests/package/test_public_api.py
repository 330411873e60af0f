"""What is public: names at the top and, by subject, in the rooms; nothing else can be reached."""

import importlib
import inspect
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import robsim

TESTS = Path(__file__).parents[1]
ROOMS = (*robsim._WINGS, "estimation.reference", "teach.gym")
MODULES = ["robsim", *(f"robsim.{room}" for room in ROOMS)]


@pytest.mark.long
def test_the_list_of_public_names_is_up_to_date(tmp_path):
    script = TESTS / "support" / "write_public_api.py"
    subprocess.run([sys.executable, script, tmp_path / "api.txt"], check=True)
    written = (tmp_path / "api.txt").read_text()
    listed = (TESTS / "public_api.txt").read_text()
    assert written == listed, "look at the difference; ./run stubs writes the list anew"


def test_a_module_offers_what_it_says_and_nothing_else():
    for module in map(importlib.import_module, MODULES):
        assert module.__all__ == sorted(
            module.__all__, key=lambda name: (not name.isupper(), not name[0].isupper(), name)
        )
        # It may hold modules of its own, never one of somebody else's.
        visible = {
            name
            for name, value in vars(module).items()
            if not name.startswith("_")
            and getattr(value, "__name__", "") != f"{module.__name__}.{name}"
        }
        assert visible <= set(module.__all__), module
    assert {"Simulation", "vision", "plotting"} <= set(dir(robsim))
    assert not hasattr(robsim, "_nothing")


def test_a_name_says_where_it_is_public():
    for module in map(importlib.import_module, MODULES):
        for name in module.__all__:
            value = getattr(module, name)
            if not isinstance(value, (str, tuple, Mapping)):
                at_the_top = name in robsim.__all__ and value is getattr(robsim, name)
                home = "robsim" if at_the_top else module.__name__
                assert value.__module__ == home, name
    assert "robsim._core" not in robsim.find_blobs.__doc__
    with pytest.raises(TypeError, match="step") as caught:
        robsim.Spin()(3)
    assert "robsim._core" not in str(caught.value)


def public_calls():
    for module in map(importlib.import_module, MODULES):
        for name in filter(lambda one: callable(getattr(module, one)), module.__all__):
            value = getattr(module, name)
            yield name, value
            for one, member in vars(value).items() if isinstance(value, type) else ():
                if callable(member) and not one.startswith("_"):
                    yield f"{name}.{one}", member


def test_what_is_public_has_a_docstring():
    found = dict(public_calls())
    assert len(found) > 400
    assert [name for name, value in found.items() if not inspect.getdoc(value)] == []


AT_ONCE = """
import random, threading
import robsim

errors, names = [], [name for name in (*robsim.__all__, *robsim._WINGS) ]


def ask(seed):
    for name in random.Random(seed).sample(names, len(names)):
        try:
            getattr(robsim, name)
        except Exception as error:
            errors.append((name, error))


threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(12)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(errors)
"""


@pytest.mark.parametrize("name", ["robsim.plotting", "robsim.lab.cameras"])
@pytest.mark.parametrize("double", [None, object()])
def test_tests_may_set_a_double_instead_of_a_module(monkeypatch, name, double):
    home, _, module = name.rpartition(".")
    monkeypatch.setattr(name, double)
    assert getattr(importlib.import_module(home), module) is double


@pytest.mark.long
def test_threads_that_ask_for_rooms_at_once_get_whole_ones():
    run = subprocess.run([sys.executable, "-c", AT_ONCE], capture_output=True, text=True)
    assert (run.stdout, run.stderr) == ("[]\n", "")
