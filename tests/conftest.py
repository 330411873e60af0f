import gc
import os
import sys
from functools import partial
from ipaddress import ip_address

import hypothesis
import numpy as np
import pytest

from skips import fail_if_unlisted

# Other random numbers for all tests that draw any: `ROBSIM_TEST_SEED=1 ./run test`. Those that are
# marked `random` draw them from the fixture `rng`; hypothesis, too, repeats itself only by default.
SEED = int(os.environ.get("ROBSIM_TEST_SEED", "0"))

# Without a deadline: how long an example takes says nothing where other tests run beside it.
hypothesis.settings.register_profile("robsim", deadline=None, derandomize=SEED == 0)
hypothesis.settings.load_profile("robsim")


def pytest_collection_modifyitems(items):
    """Mark what draws random numbers by the fixture that it draws them from."""
    for item in items:
        if "rng" in getattr(item, "fixturenames", ()):
            item.add_marker("random")


def pytest_collection():
    """Collect no garbage while the tests are collected: nearly all that is made lives on."""
    gc.disable()


def pytest_collection_finish():
    """Leave what lives till the end out of each garbage collection: a tenth of the tests' time."""
    gc.enable()
    gc.collect()
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport():
    """Fail a test that is left out for a reason that is not on the list."""
    return fail_if_unlisted((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report():
    """Fail a file that is left out for a reason that is not on the list."""
    return fail_if_unlisted((yield))


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
def undrawn(monkeypatch):
    """The figures of a run are empty files: to draw them takes longer than all else."""
    monkeypatch.setattr("robsim.cli.results.save_figure", lambda file, figure: file.touch())


@pytest.fixture
def closed_page(monkeypatch):
    """A page that is closed as soon as it is shown: nobody is there to look at it."""
    monkeypatch.setattr("robsim.gui.hosts.page.Page.open", lambda page: True)
    monkeypatch.setattr("robsim.gui.hosts.page.Page.wait", lambda page, patience: None)


@pytest.fixture
def small_bench(monkeypatch):
    """Let ``robsim bench`` measure with small images, in a sixth of the time."""
    from robsim.cli.simulated.bench import run_bench

    small = partial(run_bench, sizes=(480,), frames=3, steps=20)
    monkeypatch.setattr("robsim.cli.simulated.bench.run_bench", small)


@pytest.fixture
def unhurried(monkeypatch):
    """Let the doctor count the work of a call, without its waits for a processor."""
    monkeypatch.setattr("robsim.teach.doctor._trial._slowdown", lambda: 1e9)


@pytest.fixture
def rng(request):
    """Random numbers of the test's own; a failing test prints the seed."""
    seed = sum(map(ord, request.node.name)) % 100_000
    print(f"seed of the test: {seed}, ROBSIM_TEST_SEED={SEED}")
    return np.random.default_rng((seed, SEED) if SEED else seed)


def _stay_on_this_machine(event, arguments):
    """Fail what reaches for another machine."""
    if event == "socket.connect" and isinstance(arguments[1], tuple):
        host = arguments[1][0]
    elif event == "socket.getaddrinfo":
        host = arguments[0]
    else:
        return
    if host not in (None, "", "localhost") and not _is_loopback(host):
        raise RuntimeError(f"a test must not reach beyond this machine: {host}")


def _is_loopback(host):
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


sys.addaudithook(_stay_on_this_machine)
