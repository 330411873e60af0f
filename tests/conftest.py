import numpy as np
import pytest


@pytest.fixture
def rng(request):
    """Random numbers of the test's own; a failing test prints the seed."""
    seed = sum(map(ord, request.node.nodeid)) % 100_000
    print(f"seed of the test: {seed}")
    return np.random.default_rng(seed)
