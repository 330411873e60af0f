"""A cluster of Dask, and executors of others: the same bytes, and workers that die."""

import pickle
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import robsim
from campaign_code import Inline, deadly, failing_in_some, final, killed_once, steady
from clusters import local_cluster
from robsim.campaigns import campaign
from sizes import thorough

SCENARIO = robsim.Scenario(
    area=(300, 300), start="random", measure=True, noise=robsim.GaussianNoise(10)
)
VARY = {"motor_delay": [0, 1.5], "control": {"plain": steady, "native": robsim.DriveAround()}}


def run(**options):
    options = {"metrics": ["tracking", final, failing_in_some], "runs": 12} | options
    return campaign(SCENARIO, vary=VARY, steps=10, seed=3, progress=False, **options)


@pytest.fixture(scope="module")
def serial():
    return run()


@pytest.fixture
def client(tmp_path, monkeypatch):
    """A scheduler and two workers on loopback, which end with the test."""
    monkeypatch.setenv("ROBSIM_TEST_FOLDER", str(tmp_path))
    with local_cluster(tmp_path) as client:
        yield client


def gives_the_same_bytes(client, serial, folder):
    result = run(executor=client)
    assert result.checksum == serial.checksum
    assert result["error"].tolist() == serial["error"].tolist()
    assert result["line"].tolist() == serial["line"].tolist()
    assert run(executor=client.get_executor()).checksum == serial.checksum
    run(executor=client, runs=5, store=folder / "store.sqlite")
    assert run(executor=client, store=folder / "store.sqlite").checksum == serial.checksum
    assert client.submit(int, "3").result() == 3  # it is still the user's


def loses_nothing_with_a_worker_that_is_killed(client, serial, folder):
    code = {"metrics": {"number": killed_once, "final": final}, "runs": 40}
    workers = set(client.nthreads())
    result = run(executor=client, **code)
    assert set(client.nthreads()) != workers
    assert not result.failed.any()
    assert result["number"].tolist() == [*range(40)] * 4
    assert result.checksum == run(**code).checksum


def fails_a_run_that_kills_its_worker_again_and_no_other(client, serial, folder):
    code = {"metrics": [deadly, final], "runs": 36}
    result = campaign(SCENARIO, steps=10, seed=3, progress=False, executor=client, **code)
    assert (folder / "killed").exists()
    assert np.flatnonzero(result.failed).tolist() == [33]
    assert result["error"][33].startswith("WorkerDied")
    here = campaign(SCENARIO, steps=10, seed=3, progress=False, **code)
    for name in ("deadly", "final_x", "final_y"):
        np.testing.assert_array_equal(np.delete(result[name], 33), np.delete(here[name], 33))


DEATHS = (
    loses_nothing_with_a_worker_that_is_killed,
    fails_a_run_that_kills_its_worker_again_and_no_other,
)


@pytest.mark.slow
@pytest.mark.parametrize("promise", [gives_the_same_bytes, *thorough(DEATHS, ())])
def test_a_scheduler_of_dask(promise, client, serial, tmp_path):
    promise(client, serial, tmp_path)


@pytest.mark.slow
def test_a_loky_executor_gives_the_same_bytes(serial):
    loky = pytest.importorskip("loky")
    pool = loky.ProcessPoolExecutor(2)
    try:
        assert run(executor=pool).checksum == serial.checksum
    finally:
        pool.shutdown()


class FakeClient:
    """A client of a cluster that grows, and gives up the first chunks that it gets."""

    asynchronous = False
    status = "running"

    def __init__(self, n_given_up=0):
        self.n_given_up = n_given_up
        self.sizes = []

    def get_executor(self, *, pure):
        client = self

        class GivingUp(Inline):
            def submit(self, function, /, *args):
                client.sizes.append(len(pickle.loads(args[1])))
                given_up = len(client.sizes) <= client.n_given_up
                return super().submit(give_up) if given_up else super().submit(function, *args)

        return GivingUp()

    def submit(self, function, /, *args, pure):
        return function(*args)

    def nthreads(self):
        return {}  # its jobs still wait in the queue


def give_up():
    raise type("KilledWorker", (Exception,), {})("Attempted to run task on 4 workers")


@pytest.mark.long
def test_the_runs_of_chunks_that_a_cluster_gives_up_are_done_again_one_by_one(serial):
    client = FakeClient(2)
    assert run(executor=client).checksum == serial.checksum
    assert client.sizes[:4] == [1, 1, 1, 1]  # two, and both again
    assert sum(client.sizes) == 4 * 12 + 2


def test_dask_is_not_imported_for_a_client():
    before = set(sys.modules)
    run(executor=FakeClient(), runs=1)
    assert not {name for name in set(sys.modules) - before if name.startswith(("dask", "distrib"))}


def test_what_is_no_engine_is_told():
    for attribute, value in (("asynchronous", True), ("status", "closed")):
        client = FakeClient()
        setattr(client, attribute, value)
        with pytest.raises(ValueError, match=value if value == "closed" else attribute):
            run(executor=client)
    cluster = type("Cluster", (), {"get_client": print})()
    for wrong in (FakeClient, ThreadPoolExecutor, cluster):
        with pytest.raises(TypeError, match="get_client" if wrong is cluster else "executor"):
            run(executor=wrong)
