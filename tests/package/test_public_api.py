"""What is public: names at the top and, by subject, in the rooms; nothing else can be reached."""

import importlib
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import robsim

TESTS = Path(__file__).parents[1]
MODULES = ["robsim", *(f"robsim.{room}" for room in robsim._ROOMS)]


@pytest.mark.long
def test_the_list_of_public_names_is_up_to_date(tmp_path):
    script = TESTS / "support" / "write_public_api.py"
    subprocess.run([sys.executable, script, tmp_path / "api.txt"], check=True)
    written = (tmp_path / "api.txt").read_text()
    listed = (TESTS / "public_api.txt").read_text()
    assert written == listed, "look at the difference; ./run stubs writes the list anew"


def test_about_forty_names_stand_at_the_top():
    assert 35 <= len(robsim.__all__) <= 50


@pytest.mark.parametrize("module", MODULES)
def test_a_module_offers_what_it_says_and_nothing_else(module):
    module = importlib.import_module(module)
    assert module.__all__ == sorted(
        module.__all__, key=lambda name: (not name.isupper(), not name[0].isupper(), name)
    )
    # A room may hold other rooms, never a module of somebody else's.
    visible = {name for name in vars(module) if not name.startswith("_")} - set(robsim._ROOMS)
    inner = {"cli"} if module is robsim else {"templates"}  # imported by other tests, or data
    assert visible - inner <= set(module.__all__)


@pytest.mark.parametrize("module", MODULES)
def test_a_name_says_where_it_is_public(module):
    module = importlib.import_module(module)
    for name in module.__all__:
        value = getattr(module, name)
        if not isinstance(value, (str, tuple, Mapping)):
            home = "robsim" if name in robsim.__all__ else module.__name__
            assert value.__module__ == home, name


def test_help_and_errors_name_the_public_place():
    assert repr(robsim.Frame) == "<class 'robsim.Frame'>"
    assert "robsim._core" not in robsim.find_blobs.__doc__
    with pytest.raises(TypeError, match="step must be a Step, got 3") as caught:
        robsim.Spin()(3)
    assert "robsim._core" not in str(caught.value)


def test_what_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'plot_nothing'"):
        _ = robsim.plot_nothing
    assert {"Simulation", "vision", "plotting"} <= set(dir(robsim))
