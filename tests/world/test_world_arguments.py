"""What is no noise and nothing that can be drawn is refused in its name."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refusals import (
    BEYOND_INT,
    IMAGE,
    IN_WORDS,
    INF,
    NAN,
    NO_COUNT,
    NO_INT,
    NO_PAIR,
    NO_PIXELS,
    Refusal,
    options,
    refusals,
)
from robsim import GaussianNoise, UniformNoise, _core
from robsim.simulation import Renderer, Scene
from scenes import small_renderer

SPRITE = np.full((4, 4, 4), 200, np.uint8)
NO_IMAGES = (
    *(None, "ab", 5, IMAGE, (IMAGE,), (IMAGE,) * 3, (IMAGE, None), (IMAGE[:4], IMAGE)),
    *((IMAGE.astype(float), IMAGE), (IMAGE[:, ::-1], IMAGE)),
)
NO_SPRITE = (
    *(None, "x", SPRITE.tolist(), SPRITE[0], SPRITE[:0], SPRITE[..., :3], SPRITE.astype(">u2")),
    *map(SPRITE.astype, (float, object, bool, np.int8)),
)


@pytest.mark.long
@refusals(
    options(
        small_renderer,
        {
            "floor home": NO_IMAGES,
            "shadow_left": (*NO_INT, *BEYOND_INT),
            "shadow_factor": (None, "x", -1, NAN, INF, 1e308),
            "sprite": NO_SPRITE,
            "centre": (*NO_PAIR, (INF, 1), ["a", "b"], (1e9, 0)),
            "unit": (None, "x", 0, -1, NAN, INF, 1e9),
            "alignment": (None, "x", NAN, INF),
            "headings": NO_COUNT,
            "area": NO_PIXELS,
        },
    ),
    Refusal(lambda _: Renderer(), "scene", ("missing",), raises=TypeError),
    Refusal(lambda _: Scene(), "floor", ("missing",), raises=TypeError),
    Refusal(
        lambda value: small_renderer().render((5, 4, 0), value),
        "pan",
        (*NO_PAIR, (1.5, 1), (2**31, 0), (0, -(2**31) - 1)),
    ),
)
def test_what_cannot_be_drawn(refusal):
    refusal()


@refusals(
    Refusal(
        lambda value: _core.VisualNoise("uniform", value),
        "percent",
        (None, "40", 1j, [1], -1, NAN, INF),
    ),
    Refusal(lambda value: _core.VisualNoise("none", value), "percent", (-1,)),
    Refusal(lambda value: _core.VisualNoise(value, 5), "kind", (None, 5, ["none"], "white", "")),
    [
        Refusal(kind, "percent", (None, -1, -5e-324, NAN, INF, "40", [1], 1j, True), says=IN_WORDS)
        for kind in (UniformNoise, GaussianNoise)
    ],
    options(UniformNoise(5).add, {"seed index": (-1, 2**64, *NO_INT)}, IMAGE, seed=1),
)
def test_what_is_no_noise(refusal):
    refusal()


@pytest.mark.parametrize("percent", [5e-324, 1e-300, 1e308])
@pytest.mark.parametrize("kind", ["uniform", "gaussian"])
def test_extreme_noise_stays_within_the_picture(kind, percent):
    noisy = _core.VisualNoise(kind, percent).add(IMAGE, 1)
    assert noisy.shape == IMAGE.shape
    assert set(np.unique(noisy)) == ({100} if percent < 1 else {0, 255})


INT = st.integers(-(2**31), 2**31 - 1) | st.sampled_from([-(2**31), 2**31 - 1, -1, 0, 7])


@pytest.mark.long
@pytest.mark.parametrize("headings", [0, 4])
@settings(max_examples=100, deadline=None)
@given(
    x=st.floats(allow_nan=False, allow_infinity=False),
    y=st.floats(allow_nan=False, allow_infinity=False),
    heading=st.floats(allow_nan=False, allow_infinity=False),
    pan=st.tuples(INT, INT),
)
def test_any_finite_pose_and_view_can_be_drawn(headings, x, y, heading, pan):
    image = small_renderer(headings=headings).render((x, y, heading), pan)
    assert image.shape == IMAGE.shape
    if abs(x) > 100 and pan == (0, 0):
        np.testing.assert_array_equal(image, IMAGE)
