import math

import numpy as np
import pytest

import robsim
from sizes import thorough

KINDS = {"uniform": robsim.UniformNoise, "gaussian": robsim.GaussianNoise}


def added(kind, percent, value=128, seed=1, index=0, shape=(400, 401, 3)):
    clean = np.full(shape, value, np.uint8)
    noisy = KINDS[kind](percent).add(clean, seed, index)
    assert (clean == value).all()
    return noisy.astype(int) - value


def share(kind, k, scale):
    """Probability that noise rounds to k, or beyond it at the ends of what a pixel can show."""

    def cdf(x):
        if kind == "uniform":
            return min(1.0, max(0.0, 0.5 + x / (2 * scale)))
        return 0.5 * math.erfc(-x / (scale * math.sqrt(2)))

    return (cdf(k + 0.5) if k < 127 else 1.0) - (cdf(k - 0.5) if k > -128 else 0.0)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:a noise of")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("percent", [0.2, 1.7, 5, 10, 40, 100])
def test_the_whole_distribution_at_any_level(kind, percent):
    size = thorough(1200, 600)
    noise = added(kind, percent, shape=(size, size, 3))
    found = np.bincount(noise.ravel() + 128, minlength=256) / noise.size
    steps = np.arange(-128, 128)
    theory = np.array([share(kind, k, 2.55 * percent) for k in steps])
    # of n draws themselves: about 0.4 sqrt(256 / n), 0.003 or 0.006
    assert abs(found - theory).sum() / 2 < thorough(0.005, 0.009)
    assert found @ steps == pytest.approx(theory @ steps, abs=thorough(0.1, 0.2))
    assert found @ steps**2 == pytest.approx(theory @ steps**2, rel=thorough(0.006, 0.012))
    assert (found[theory > 1 / 8192] > 0).all()  # the finest share that is drawn
    if kind == "uniform" and percent == 5:
        assert np.abs(noise).max() == 13


@pytest.mark.parametrize("kind", KINDS)
def test_pixels_channels_frames_and_seeds_are_independent(kind):
    noise = added(kind, 10).astype(float)
    rows = noise.reshape(400, -1)
    pairs = {
        "columns": (noise[:, 1:], noise[:, :-1]),
        "rows": (noise[1:], noise[:-1]),
        "channels": (noise[..., 0], noise[..., 1]),
        "the next bytes of the same generator": (rows[:, 32:], rows[:, :-32]),
        "the generator beside it": (rows[:, 8:], rows[:, :-8]),
        "spread of columns": (noise[:, 1:] ** 2, noise[:, :-1] ** 2),
        "spread of frames": (noise**2, added(kind, 10, index=1).astype(float) ** 2),
        "frames": (noise, added(kind, 10, index=1)),
        "seeds": (noise, added(kind, 10, seed=2)),
    }
    for name, (a, b) in pairs.items():
        correlation = np.corrcoef(a.ravel(), b.ravel())[0, 1]
        assert abs(correlation) < 5 / math.sqrt(a.size), name


def test_the_same_seed_and_index_give_the_same_bytes():
    np.testing.assert_array_equal(added("gaussian", 40), added("gaussian", 40))
    assert (added("gaussian", 40) != added("gaussian", 40, index=1)).any()


@pytest.mark.filterwarnings("ignore:a noise of")
def test_the_level_has_limits():
    for kind, make in KINDS.items():
        assert (added(kind, 0) == 0).all()
        assert (added(kind, 5e-324) == 0).all()
        for percent in (-5e-324, 100.1, math.nan, math.inf):
            with pytest.raises(ValueError, match=r"\bpercent\b"):
                make(percent)


@pytest.mark.parametrize("kind", KINDS)
def test_noise_in_place_and_into_an_array(rng, kind):
    noise = KINDS[kind](20)
    image = rng.integers(0, 256, (11, 37, 3), dtype=np.uint8)
    expected = noise.add(image, 5, 3)
    wide = np.full((11, 40, 3), 7, np.uint8)
    part = wide[:, :37]
    assert noise.add(image, 5, 3, out=part) is part
    np.testing.assert_array_equal(wide[:, :37], expected)
    np.testing.assert_array_equal(wide[:, 37:], 7)
    assert noise.add(image, 5, 3, out=image) is image
    np.testing.assert_array_equal(image, expected)


def test_where_noise_cannot_be_written():
    noise, image = robsim.UniformNoise(20), np.zeros((20, 30, 3), np.uint8)
    fixed = np.zeros_like(image)
    fixed.setflags(write=False)
    for out in (fixed, image[:, 1:], image.astype(float), np.zeros_like(image)[::-1]):
        with pytest.raises((TypeError, ValueError), match=r"\bout\b"):
            noise.add(image, 1, out=out)
    with pytest.raises(ValueError, match=r"\bout\b.*memory"):
        noise.add(image[:-1], 1, out=image[1:])
    for name in ("seed", "index"):
        for value in (-1, 2**64):
            with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
                noise.add(image, **{"seed": 1, name: value})
