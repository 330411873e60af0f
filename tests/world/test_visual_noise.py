import math

import numpy as np
import pytest

import robsim
from robsim import _core


def added(kind, percent, value=128, seed=1, index=0, shape=(400, 401, 3)):
    clean = np.full(shape, value, np.uint8)
    noisy = _core.VisualNoise(kind, percent).add(clean, seed, index)
    assert (clean == value).all()
    return noisy.astype(int) - value


def gaussian_share(k, sigma):
    """Probability that Gaussian noise rounds to k."""
    cdf = [0.5 * math.erfc(-(k + d) / (sigma * math.sqrt(2))) for d in (-0.5, 0.5)]
    return cdf[1] - cdf[0]


@pytest.mark.parametrize("kind", ["uniform", "gaussian"])
def test_each_step_comes_as_often_as_theory_says(kind):
    noise = added(kind, 5)
    scale = 2.55 * 5
    for k in range(-12, 13):
        theory = gaussian_share(k, scale) if kind == "gaussian" else 1 / (2 * scale)
        deviation = math.sqrt(theory / noise.size)
        assert (noise == k).mean() == pytest.approx(theory, abs=5 * deviation)


def share(kind, k, scale):
    """Probability that noise rounds to k, or beyond it at the ends of what a pixel can show."""

    def cdf(x):
        if kind == "uniform":
            return min(1.0, max(0.0, 0.5 + x / (2 * scale)))
        return 0.5 * math.erfc(-x / (scale * math.sqrt(2)))

    return (cdf(k + 0.5) if k < 127 else 1.0) - (cdf(k - 0.5) if k > -128 else 0.0)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["uniform", "gaussian"])
@pytest.mark.parametrize("percent", [0.2, 0.5, 1, 1.7, 2.4, 3.7, 5, 7, 10, 14, 20, 40, 80, 300])
def test_the_whole_distribution_at_any_level(kind, percent):
    noise = added(kind, percent, shape=(1200, 1200, 3))
    found = np.bincount(noise.ravel() + 128, minlength=256) / noise.size
    steps = np.arange(-128, 128)
    theory = np.array([share(kind, k, 2.55 * percent) for k in steps])
    # of 4.3 million draws themselves: about 0.4 sqrt(256 / 4.3e6) = 0.003
    assert abs(found - theory).sum() / 2 < 0.005
    assert found @ steps == pytest.approx(theory @ steps, abs=0.1)
    assert found @ steps**2 == pytest.approx(theory @ steps**2, rel=0.006)
    assert (found[theory > 1 / 8192] > 0).all()  # the finest share that is drawn


@pytest.mark.long
@pytest.mark.parametrize("percent", [1, 1.7, 2.5, 3.7, 5, 7.5, 10, 12])
def test_gaussian_tails(percent):
    sigma = 2.55 * percent
    beyond = (np.abs(added("gaussian", percent, shape=(1200, 1200, 3))) > 3 * sigma).mean()
    theory = sum(share("gaussian", k, sigma) for k in range(-128, 128) if abs(k) > 3 * sigma)
    assert beyond == pytest.approx(theory, rel=0.1)


def beyond(limit, sigma):
    """Probability of Gaussian noise above `limit` standard deviations, both sides."""
    steps = range(math.floor(limit * sigma) + 1, 128)
    return 2 * sum(gaussian_share(k, sigma) for k in steps)


@pytest.mark.parametrize("percent", [2.35, 4, 5, 7])
def test_what_lies_beyond_four_standard_deviations(percent):
    sigma = 2.55 * percent
    noise = np.abs(added("gaussian", percent, seed=4, shape=(600, 600, 3)))
    expected = noise.size * beyond(4, sigma)  # some 70
    assert (noise > 4 * sigma).sum() == pytest.approx(expected, abs=5 * math.sqrt(expected))


@pytest.mark.long
def test_what_lies_beyond_five_standard_deviations():
    found = expected = 0
    for percent in (1, 2.35, 3.7, 5, 6.5, 8):
        sigma = 2.55 * percent
        noise = np.abs(added("gaussian", percent, seed=5, shape=(3000, 1200, 3)))
        found += (noise > 5 * sigma).sum()
        expected += noise.size * beyond(5, sigma)
    assert expected > 20
    assert found == pytest.approx(expected, abs=4 * math.sqrt(expected))


def test_gaussian_tails_and_uniform_limits():
    sigma = 2.55 * 5
    beyond = (np.abs(added("gaussian", 5)) > 3 * sigma).mean()
    theory = 2 * sum(gaussian_share(k, sigma) for k in range(39, 120))
    assert beyond == pytest.approx(theory, rel=0.1)
    assert np.abs(added("uniform", 5)).max() == 13


def test_clipped_shares_at_40_percent():
    noisy = added("gaussian", 40, value=200) + 200
    sigma = 102.0
    white = 0.5 * math.erfc((255 - 0.5 - 200) / (sigma * math.sqrt(2)))
    black = 0.5 * math.erfc((200 - 0.5) / (sigma * math.sqrt(2)))
    assert (noisy == 255).mean() == pytest.approx(white, abs=0.003)
    assert (noisy == 0).mean() == pytest.approx(black, abs=0.003)


@pytest.mark.parametrize("kind", ["uniform", "gaussian"])
def test_pixels_channels_frames_and_seeds_are_independent(kind):
    noise = added(kind, 10).astype(float)
    pairs = {
        "columns": (noise[:, 1:], noise[:, :-1]),
        "rows": (noise[1:], noise[:-1]),
        "channels": (noise[..., 0], noise[..., 1]),
        "the next bytes of the same generator": (
            noise.reshape(400, -1)[:, 32:],
            noise.reshape(400, -1)[:, :-32],
        ),
        "the generator beside it": (
            noise.reshape(400, -1)[:, 8:],
            noise.reshape(400, -1)[:, :-8],
        ),
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


@pytest.mark.parametrize(("kind", "percent"), [("none", 40), ("uniform", 0), ("gaussian", 0)])
def test_no_noise_changes_nothing(kind, percent):
    assert (added(kind, percent) == 0).all()


@pytest.mark.parametrize("percent", [-1, math.nan, math.inf])
def test_a_level_that_is_none_is_refused(percent):
    with pytest.raises(ValueError, match=r"\bpercent\b"):
        robsim.UniformNoise(percent)


def test_an_unknown_kind_is_refused():
    with pytest.raises(ValueError, match="'none', 'uniform', 'gaussian', got 'salt'"):
        _core.VisualNoise("salt", 1)


@pytest.mark.parametrize("kind", ["none", "uniform", "gaussian"])
def test_noise_in_place_and_into_an_array(rng, kind):
    noise = _core.VisualNoise(kind, 20)
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
    for out, message in (
        (fixed, "out must not be read-only"),
        (np.zeros((20, 31, 3), np.uint8), "out must have the shape of image"),
        (np.zeros((20, 30, 3)), "out must be a uint8 RGB array"),
        (np.zeros((20, 30, 3), np.uint8)[::-1], "out must have its rows one after the other"),
    ):
        with pytest.raises((TypeError, ValueError), match=message):
            noise.add(image, 1, out=out)
    with pytest.raises(ValueError, match="out must be image itself, or share no memory with it"):
        noise.add(image[:-1], 1, out=image[1:])
