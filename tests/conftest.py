import numpy as np
import pytest


@pytest.fixture(scope="session", autouse=True)
def _user_folder(tmp_path_factory):
    """A user folder of the tests' own, so that a developer's choice of robot changes no test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROBSIM_DATA", str(tmp_path_factory.mktemp("user") / "data"))
        yield


@pytest.fixture
def user_folder(tmp_path, monkeypatch):
    """An empty user folder of this test's own."""
    monkeypatch.setenv("ROBSIM_DATA", str(tmp_path / "data"))
    return tmp_path / "data"


@pytest.fixture
def rng(request):
    """Random numbers of the test's own; a failing test prints the seed."""
    seed = sum(map(ord, request.node.name)) % 100_000
    print(f"seed of the test: {seed}")
    return np.random.default_rng(seed)
