import pytest

import fuzzing


@pytest.fixture(autouse=True)
def _counted():
    """Some inputs of each test get past the checks, or it tests nothing but these."""
    fuzzing.taken.clear()
    fuzzing.refused.clear()
    yield
    for name, refused in fuzzing.refused.items():
        taken = fuzzing.taken[name]
        # Fewer say nothing, and other versions of hypothesis try others.
        assert refused + taken < 100 or taken >= 0.03 * refused, (name, taken, refused)
