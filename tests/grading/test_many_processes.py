"""Graded runs in threads, processes and a cluster: the same numbers, and nothing is left."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np
import pytest

import robsim
from clusters import local_cluster
from graded import PATIENT, honest, where
from robsim.teach import Key, Submission
from waiting import wait_for

pytestmark = pytest.mark.long

SLOTS = ("estimate_state", "control")
SCENARIO = robsim.Scenario(
    resolution=(200, 200), measure=True, noise=robsim.GaussianNoise(5), start="random"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return honest(tmp_path_factory.mktemp("handed_in") / "s", SLOTS)


def runs(folder, executor, **options):
    submission = Submission(folder, slots=SLOTS, key=options.pop("key", None), limits=PATIENT)
    options |= {"runs": 4, "steps": 6, "metrics": "pose_errors", "test": "ekf"}
    result = submission.runs(SCENARIO, executor=executor, **options)
    assert not result.failed.any(), result["error"]
    return result


BY_KEY, BY_SEED = {"key": Key(bytes(32))}, {"seed": 3}


@pytest.fixture(scope="module")
def here(folder):
    """What this process computes."""
    return [runs(folder, None, **options) for options in (BY_KEY, BY_SEED)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "executor",
    [
        lambda folder: nullcontext("threads"),
        lambda folder: nullcontext(2),
        lambda folder: ThreadPoolExecutor(2),
        local_cluster,
    ],
    ids=["threads", "processes", "library", "dask"],
)
def test_the_numbers_are_the_same_whatever_did_the_runs(folder, here, executor, tmp_path):
    with executor(tmp_path) as engine:
        there = [runs(folder, engine, **options) for options in (BY_KEY, BY_SEED)]
    for one, other in zip(here, there, strict=True):
        assert one.checksum == other.checksum
        assert len(np.unique(one["pose_errors_x_rmse"])) == 4


def test_without_a_key_and_a_seed_no_two_are_the_same(folder):
    one, other = (runs(folder, None) for _ in range(2))
    assert one.checksum != other.checksum


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="zygotes are for Linux")
def test_each_process_has_workers_of_its_own_and_leaves_nothing(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", str(tmp_path))  # of the processes
    submission = Submission(folder, slots=SLOTS, limits=PATIENT)
    result = submission.runs(SCENARIO, runs=8, steps=3, metrics=where, executor=2)
    assert not result.failed.any(), result["error"]
    pairs = set(zip(result["where_grader"], result["where_zygote"], strict=True))
    graders, zygotes = (set(map(int, ids)) for ids in zip(*pairs, strict=True))
    assert len(pairs) == len(graders) == len(zygotes)
    assert os.getpid() not in graders
    wait_for(lambda: not any(os.path.exists(f"/proc/{process}") for process in graders | zygotes))
    assert not list(tmp_path.glob("robsim-*"))
