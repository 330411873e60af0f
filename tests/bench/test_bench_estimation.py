"""What is timed does what it is timed for; how fast it is no test asks."""

import numpy as np
import pytest

from robsim.bench import _estimation as estimation

pytestmark = pytest.mark.kernels


def test_what_is_compared_estimates_the_same():
    recursive, batch = estimation.recursive_calls(400), estimation.batch_calls(300)
    np.testing.assert_allclose(recursive["ours"](), np.ones((3, 5)), atol=0.05)
    np.testing.assert_allclose(recursive["numpy"](), recursive["ours"]()[0], rtol=1e-9)
    np.testing.assert_allclose(batch["ours"]().theta, batch["numpy"]()[0], rtol=1e-10)
    np.testing.assert_allclose(batch["ours"]().theta, np.ones(5), atol=0.05)


def test_the_loops_run_what_they_say():
    traces = {name: simulation.run(60) for name, simulation in estimation.loops().items()}
    assert np.isfinite(traces["native"].parameters).any()
    assert (traces["controller"].u[:12] == [(1.0, 0.2)] * 10 + [(0.2, 1.0)] * 2).all()
    assert (traces["five_callbacks"].pose_estimated == (600, 600, 0)).all()
