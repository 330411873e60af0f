"""What is timed does what it is timed for; how fast it is no test asks."""

import numpy as np
import pytest

from robsim.bench import _estimation as estimation
from robsim.bench._estimation import TextbookRecursiveLeastSquares

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize("forgetting", [1.0, 0.95])
def test_the_textbook_filter_gives_the_weighted_ridge_solution(rng, forgetting):
    """After so many samples, too: at 0.95 a P that is not symmetric has grown beyond 1e30."""
    samples = 2000
    phi, y = rng.normal(size=(samples, 3)), rng.normal(size=samples)
    filter_ = TextbookRecursiveLeastSquares(3, forgetting=forgetting, initial_covariance=100)
    for row, output in zip(phi, y, strict=True):
        theta = filter_.update(row, output)
    weights = forgetting ** np.arange(samples - 1, -1, -1)
    information = (phi.T * weights) @ phi + forgetting**samples / 100 * np.eye(3)
    np.testing.assert_allclose(theta, np.linalg.solve(information, phi.T @ (weights * y)))
    np.testing.assert_allclose(filter_.P, np.linalg.inv(information), atol=1e-15)


def test_the_recursive_calls_estimate_what_they_should():
    calls = estimation.recursive_calls(400)
    assert calls["ours"]().shape == (3, 5)
    assert calls["numpy"]().shape == (5,)
    np.testing.assert_allclose(calls["ours"](), np.ones((3, 5)), atol=0.05)
    np.testing.assert_allclose(calls["numpy"](), calls["ours"]()[0], rtol=1e-9)
    np.testing.assert_array_equal(calls["ours"](), calls["ours"]())


def test_the_batch_calls_estimate_what_they_should():
    calls = estimation.batch_calls(300)
    np.testing.assert_allclose(calls["ours"]().theta, calls["numpy"]()[0], rtol=1e-10)
    np.testing.assert_allclose(calls["ours"]().theta, np.ones(5), atol=0.05)


def test_estimates_that_differ_are_no_comparison(monkeypatch):
    lstsq = np.linalg.lstsq
    monkeypatch.setattr(np.linalg, "lstsq", lambda *a, **k: [1.001 * lstsq(*a, **k)[0]])
    with pytest.raises(RuntimeError, match="must find the same theta"):
        estimation.batch_calls(50)


def test_the_loops_run_what_they_say():
    loops = estimation.loops()
    assert set(loops) == {"native", "controller", "five_callbacks"}
    traces = {name: simulation.run(60) for name, simulation in loops.items()}
    for name in ("native", "controller"):
        assert np.isfinite(traces[name].parameters).any()
        assert not traces[name].seen.any()
    assert (traces["controller"].u[:12] == [(1.0, 0.2)] * 10 + [(0.2, 1.0)] * 2).all()
    assert (traces["five_callbacks"].u == 0).all()
    assert (traces["five_callbacks"].pose_estimated == (600, 600, 0)).all()


def test_the_speed_of_a_loop():
    simulation = estimation.loops()["native"]
    assert estimation.steps_per_second(simulation, steps=20, rounds=2) > 0
    # One step with all that comes once, and twenty that are timed.
    assert len(simulation.trace) == 21
