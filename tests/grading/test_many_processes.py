"""Graded runs in threads, processes and a cluster: the same numbers, and nothing is left."""

import logging
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import numpy as np
import pytest

import robsim
from graded import honest, where
from robsim.grading import Key, Submission
from waiting import wait_for

pytestmark = pytest.mark.long

SLOTS = ("estimate_state", "control")
SCENARIO = robsim.Scenario(
    resolution=(200, 200), measure=True, noise=robsim.GaussianNoise(5), start="random"
)


@contextmanager
def of_dask(folder):
    """A client of Dask, with two processes on loopback."""
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            local_directory=str(folder),
            silence_logs=logging.CRITICAL,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@contextmanager
def of_the_library(folder):
    with ThreadPoolExecutor(2) as pool:
        yield pool


@contextmanager
def given(value):
    yield value


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return honest(tmp_path_factory.mktemp("handed_in") / "s", SLOTS)


def runs(folder, executor, *, key=None, seed=None):
    submission = Submission(folder, slots=SLOTS, key=key)
    options = {"runs": 12, "steps": 10, "metrics": "pose_errors", "test": "ekf"}
    result = submission.runs(SCENARIO, seed=seed, executor=executor, **options)
    assert not result.failed.any(), result["error"]
    return result


@pytest.mark.slow
@pytest.mark.parametrize("options", [{"key": Key(bytes(32))}, {"seed": 3}], ids=["key", "seed"])
@pytest.mark.parametrize(
    "executor",
    [lambda folder: given("threads"), lambda folder: given(2), of_the_library, of_dask],
    ids=["threads", "processes", "library", "dask"],
)
def test_the_numbers_are_the_same_whatever_did_the_runs(folder, executor, options, tmp_path):
    here = runs(folder, None, **options)
    with executor(tmp_path) as engine:
        assert runs(folder, engine, **options).checksum == here.checksum
    assert len(np.unique(here["pose_errors_x_rmse"])) == 12


def test_without_a_key_and_a_seed_no_two_are_the_same(folder):
    options = {"runs": 2, "steps": 3, "metrics": "pose_errors"}
    one, other = (Submission(folder, slots=SLOTS).runs(SCENARIO, **options) for _ in range(2))
    assert one.checksum != other.checksum


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux")
def test_each_process_has_workers_of_its_own_and_leaves_nothing(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", str(tmp_path))  # of the processes
    submission = Submission(folder, slots=SLOTS)
    result = submission.runs(SCENARIO, runs=24, steps=3, metrics=where, executor=2)
    assert not result.failed.any(), result["error"]
    pairs = set(zip(result["where_grader"], result["where_zygote"], strict=True))
    graders, zygotes = (set(map(int, ids)) for ids in zip(*pairs, strict=True))
    assert len(pairs) == len(graders) == len(zygotes)
    assert os.getpid() not in graders
    wait_for(lambda: not any(os.path.exists(f"/proc/{process}") for process in graders | zygotes))
    assert not list(tmp_path.glob("robsim-*"))
