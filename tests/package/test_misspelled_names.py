"""Misspelled and misplaced arguments and names are told, with what may be meant."""

import pickle
import re

import pytest

import robsim
from robsim import Dropout, Experiment, GoToPoint, Scenario, Simulation


@pytest.mark.parametrize(
    ("call", "error", "named"),
    [
        (lambda: Simulation(mesure=True), TypeError, "'mesure'.*'measure'"),
        (lambda: Dropout(p=0.1), TypeError, "'p'.*probability"),
        (lambda: Simulation(frames=[]), TypeError, "frames.*robsim.Experiment"),
        (lambda: Experiment([], boundary="bounce"), TypeError, "boundary.*robsim.Simulation"),
        (lambda: Scenario("lab"), TypeError, "without a name"),
        (lambda: GoToPoint(1, 2, 3), TypeError, "x, y.*3"),
        (lambda: Experiment(), TypeError, "frames"),
        (lambda: Scenario(boundary="bonce"), ValueError, "'bounce'"),
        (lambda: setattr(Simulation(), "mesure", True), AttributeError, "'mesure'.*'measure'"),
        (lambda: setattr(Simulation(), "area", (9, 9)), AttributeError, "area"),
        (lambda: setattr(Simulation(), "model", 3), AttributeError, "model.*define_model"),
        (lambda: robsim.nees, AttributeError, "robsim.evaluation.nees"),
        (lambda: robsim.goToPoint, AttributeError, "'GoToPoint'"),
    ],
)
def test_what_may_be_meant_is_told(call, error, named):
    with pytest.raises(error) as caught:
        call()
    assert re.search(named, str(caught.value))


def test_a_misspelled_file(tmp_path):
    robsim.vision.save_colors(tmp_path / "mine.toml", robsim.load_colors())
    with pytest.raises(FileNotFoundError, match=r"mine\.toml.*main\.toml"):
        robsim.load_colors(tmp_path / "main.toml")


def test_an_error_within_the_call_is_left_as_it_is():
    class Own(GoToPoint):
        def __init__(self):
            super().__init__(1, "b")

    with pytest.raises(TypeError, match=r"\by must be"):
        Own()
    assert pickle.loads(pickle.dumps(Dropout(0.5))) == Dropout(0.5)
