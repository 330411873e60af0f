"""The robustness score of a colour: what it counts, on pictures made by hand."""

import numpy as np
import pytest

import robsim
from robsim import ColorClass, find_blobs, load_colors
from robsim.vision import score_color

RED, FLOOR = (198, 36, 40), (150, 148, 146)
REGION = (30, 40, 49, 59)
COLOR = ColorClass("red", u=(0, 150), v=(156, 255))


def scene(*boxes, rgb=RED):
    """A grey floor of 100 x 100 px with coloured boxes."""
    image = np.full((100, 100, 3), FLOOR, np.uint8)
    for left, top, right, bottom in boxes:
        image[top : bottom + 1, left : right + 1] = rgb
    return image


def rates(score, *names):
    return {sweep.name: sweep.rates for sweep in score.sweeps if not names or sweep.name in names}


def test_a_good_colour_is_always_found():
    score = score_color(scene(REGION), COLOR, [REGION], repeats=2)
    assert (score.rate, score.margin, score.widened_rate) == (1, 0, 1)
    assert score.color is COLOR
    names = ["brightness", "shadow", "uniform noise", "gaussian noise", "gaussian noise in shadow"]
    assert list(rates(score)) == names
    for sweep in score.sweeps:
        assert sweep.rates == sweep.widened_rates == (1,) * len(sweep.levels)


def test_brightness_and_shadow_by_hand():
    # RED has 80 levels of V beyond neutral: with 0.6 of the light 48, with 0.4 32
    narrow = ColorClass("red", v=(170, 255))
    score = score_color(scene(REGION), narrow, [REGION], repeats=1)
    sweeps = {sweep.name: sweep for sweep in score.sweeps}
    assert sweeps["brightness"].levels == (0.4, 0.6, 0.8, 1, 1.25, 1.6)
    assert sweeps["brightness"].rates == (0, 1, 1, 1, 1, 1)
    # Half of the marker lies in the shadow: what is left is half as large, and lies aside.
    assert sweeps["shadow"].levels == (0.8, 0.6, 0.4)
    assert sweeps["shadow"].rates == (1, 1, 1)
    assert 10 <= score.margin <= 25
    assert sweeps["brightness"].widened_rates == (1,) * 6
    assert score.proposed.v == (170 - score.margin, 255)
    assert score.widened_rate > score.rate


def test_a_wide_colour_is_narrowed():
    # A brownish floor: V is 141, and 136 at 0.6 of the light
    image = scene(REGION)
    image[(image == FLOOR).all(axis=2)] = (150, 132, 120)
    wide = ColorClass("red", v=(135, 255))
    score = score_color(image, wide, [REGION], repeats=1)
    assert score.margin < 0
    assert score.widened_rate > score.rate
    assert f"narrowed by {-score.margin}" in str(score)


def test_the_right_place_and_area():
    for boxes, is_found in (
        ([(32, 42, 47, 57)], True),  # a little smaller
        ([(25, 35, 54, 64)], True),  # a little larger
        ([(36, 46, 43, 53)], False),  # less than a third
        ([(20, 30, 59, 69)], False),  # more than three times
        ([(41, 40, 60, 59)], False),  # elsewhere
        ([REGION, (70, 10, 89, 29)], False),  # another one
        ([REGION, (70, 10, 79, 19)], True),  # a small one
        ([REGION, (62, 5, 99, 42)], True),  # too large
    ):
        score = score_color(scene(*boxes), COLOR, [REGION], smoothing=1, repeats=1)
        assert rates(score, "brightness")["brightness"] == (float(is_found),) * 6


def test_several_regions_of_a_colour():
    other = (70, 10, 89, 29)
    image = scene(REGION, other)
    assert score_color(image, COLOR, [REGION, other], repeats=1).rate == 1
    assert score_color(image, COLOR, [REGION], repeats=1).rate == 0
    assert score_color(scene(REGION), COLOR, [REGION, other], repeats=1).rate == 0


def test_the_rate_is_that_of_find_blobs():
    image, weak = scene(REGION), ColorClass("red", v=(201, 255))
    score = score_color(image, weak, [REGION], repeats=20, seed=3)
    for sweep in score.sweeps[2:4]:
        kind = robsim.UniformNoise if "uniform" in sweep.name else robsim.GaussianNoise
        noise = [kind(level) for level in sweep.levels]
        expected = []
        for source in noise:
            frames = [source.add(image, 3, i) for i in range(20)]
            blobs = [
                find_blobs(frame, [weak], minimum_area=133, smoothing=7)["red"] for frame in frames
            ]
            expected.append(np.mean([len(found) == 1 for found in blobs]))
        assert sweep.rates == pytest.approx(expected, abs=0.05)
        assert 0 < sum(sweep.rates) < 4


def test_the_same_seed_gives_the_same_score():
    image, weak = scene(REGION), ColorClass("red", v=(180, 255))
    first, second, other = (
        score_color(robsim.Frame(image), weak, [REGION], repeats=3, seed=seed) for seed in (5, 5, 6)
    )
    assert first.sweeps == second.sweeps
    assert [sweep.rates for sweep in first.sweeps[:2]] == [s.rates for s in other.sweeps[:2]]


def test_what_is_refused():
    given = {"image": scene(REGION), "color": COLOR, "regions": [REGION]}
    for name, values in {
        "regions": ([], REGION, [(9, 9, 100, 99)], [(5, 5, 4, 4)]),
        "smoothing": (0, 2, 17),
        "repeats": (0,),
        "seed": (-1, 2**64),
    }.items():
        for value in values:
            with pytest.raises((TypeError, ValueError), match=name.removesuffix("s")):
                score_color(**given | {name: value})


def test_a_region_beside_the_colour_is_suspected():
    image = scene((40, 40, 60, 60))
    red = load_colors()[0]
    assert not score_color(image, red, [(40, 40, 60, 60)], repeats=1).remarks
    (doubt,) = score_color(image, red, [(5, 5, 20, 20)], repeats=1).remarks
    assert "red" in doubt
