"""Misspelled and misplaced arguments and names are told, with what may be meant."""

import re

import pytest

import robsim
from robsim import Scenario, Simulation


@pytest.mark.parametrize(
    ("call", "error", "named"),
    [
        (lambda: Simulation(mesure=True), TypeError, "'mesure'.*'measure'"),
        (lambda: Scenario(boundary="bonce"), ValueError, "'bounce'"),
        (lambda: setattr(Simulation(), "mesure", True), AttributeError, "'mesure'.*'measure'"),
        (lambda: robsim.nees, AttributeError, "robsim.estimation.nees"),
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
