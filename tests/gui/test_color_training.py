"""Colour classes while they are trained."""

import numpy as np
import pytest

from robsim import ColorClass
from robsim.gui._tools.colors.training import ColorTraining
from robsim.vision import color_histograms

RED, ORANGE, GREY = (210, 40, 30), (230, 120, 30), (120, 120, 120)


def picture(*colors):
    """Stripes of 10 px, one of each colour."""
    stripes = [np.full((40, 10, 3), color, np.uint8) for color in colors]
    return np.concatenate(stripes, axis=1)


IMAGE = picture(RED, ORANGE, GREY)
STRIPES = [(10 * n, 0, 10 * n + 9, 39) for n in range(3)]


def test_more_regions_add_up_and_show_their_drift():
    training = ColorTraining()
    training.train("red", IMAGE, STRIPES[0], picture="frame 0")
    before = training.value[0]
    training.adjust("red", margin=0, percentile=0)
    training.train("red", IMAGE, STRIPES[1], picture="frame 9", keep=1)
    both = sum(color_histograms(IMAGE, stripe) for stripe in STRIPES[:2])
    expected = ColorClass.from_histograms(both, name="red", percentile=0, margin=0)
    assert training.value == (expected,)
    assert training.value != (before,)
    (first, red, share_of_first), (second, orange, share_of_second) = training.drift("red")
    assert (first, second) == ("frame 0", "frame 9")
    assert share_of_first == share_of_second == 1
    assert orange[0] > red[0] + 30  # brighter
    training.put(ColorClass("red", y=(0, 100)))
    assert [share for _, _, share in training.drift("red")] == [1, 0]


def test_too_many_are_refused():
    training = ColorTraining(ColorClass(f"c{n}") for n in range(32))
    with pytest.raises(ValueError, match="at most 32 colours"):
        training.put(ColorClass("another"))
    with pytest.raises(ValueError, match="at most 32 colours"):
        training.train("another", IMAGE, STRIPES[0])
    before = training.value
    with pytest.raises(ValueError, match="at most 32 colours, got 33"):
        training.replace(ColorClass(f"d{n}") for n in range(33))
    assert training.value == before
    with pytest.raises(ValueError, match="grey"):
        training.train("c0", IMAGE, STRIPES[2])
    assert training.value == before
    for _ in range(100):
        training.train("c0", IMAGE, STRIPES[0], keep=100)
    with pytest.raises(ValueError, match="at most 100 regions"):
        training.train("c0", IMAGE, STRIPES[0], keep=100)


def test_ranges_by_hand_and_a_whole_file():
    training = ColorTraining([ColorClass("red"), ColorClass("blue")])
    training.train("red", IMAGE, STRIPES[0])
    training.put(ColorClass("red", v=(150, 250)))
    training.put(ColorClass("green"))
    assert [color.name for color in training.value] == ["red", "blue", "green"]
    assert training.value[0].v == (150, 250)
    training.replace([ColorClass("green"), ColorClass("red", u=(1, 2))])
    assert [color.name for color in training.value] == ["green", "red"]
    assert len(training.drift("red")) == 1  # what it was made from is still known
    training.remove("green")
    assert training.value == (ColorClass("red", u=(1, 2)),)
