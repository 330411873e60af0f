"""The benchmark of campaigns runs and says what it found."""

import json
import re

import pytest

from commands import command
from robsim.bench._campaign import run
from robsim.bench._campaign.dask_tasks import TaskCost
from robsim.bench._campaign.parent import ParentCost, parent_cost
from robsim.bench._campaign.result import CampaignBench
from robsim.bench._campaign.scaling import scaling_of
from robsim.campaigns._engines.chunks import Chunks
from robsim.campaigns._runs import Row
from sizes import thorough

NUMBERS = {
    "serial": {"no_frames": (0.0002, 0.00025), "frames_240": (0.010, 0.011)},
    "parallel": {"campaign": 190.0, "separate": 200.0, "pool": 152.0},
    "growing": {100: 0.0004, 10_000: 0.0003},
    "memory": 3.25,
}
PARENT = ParentCost(submit=10e-6, receive=90e-6, row=10e-6, flying=0.0)
TASK = TaskCost(client=900e-6, scheduler=800e-6)


@pytest.fixture(scope="module")
def result():
    return CampaignBench(**NUMBERS, scaling=scaling_of(PARENT, TASK), left_out=("joblib is out",))


@pytest.mark.slow
def test_the_command_prints_numbers_for_scripts(tmp_path, monkeypatch):
    few = {"rounds": 1, "seconds": 0.01, "sizes": (20, 40), "tasks": 10}
    monkeypatch.setattr(run.run_campaign_bench, "__kwdefaults__", few)
    if not thorough(True, False):
        monkeypatch.setattr(run, "dask_task_cost", lambda tasks: TASK)
    ended = command("bench", "--campaign", "--rounds", "1", "--json", cwd=tmp_path)
    assert ended.exit_code == 0, ended.stderr
    found = json.loads(ended.stdout)
    assert list(found["serial"]) == ["no_frames", "frames_240"]
    for row in found["serial"].values():
        assert row["ratio"] == pytest.approx(row["campaign"] / row["bare"])
    rates = found["parallel"]
    assert list(rates)[:3] == ["campaign", "separate", "pool"]
    assert all(row["runs_per_second"] > 0 for row in rates.values())
    assert list(found["growing"]) == ["20", "40"]
    assert found["parent_receive"] > 0
    assert found["task_client"] > 0
    assert found["workers_rate"]["1"]["chunk_1"] > 0


@pytest.mark.long
def test_the_table(result):
    text = str(result)
    assert re.search(r"memory over 10000 runs \(MB\) +3\.2", text)
    assert re.search(r"no_frames +0\.200 +0\.250 +1\.25 +0\.050", text)
    assert re.search(r"pool +152 +1\.25", text)
    assert re.search(r"10000 +0\.300 +0\.75", text)
    assert "joblib is out" in text


@pytest.mark.long
def test_what_many_workers_would_give_follows_from_the_costs(result):
    found = result.to_dict()
    # A chunk costs the calling process 1 ms, a row 10 us; the scheduler is quicker.
    assert found["workers_rate"]["1000"]["chunk_1"] == pytest.approx(1 / 1.01e-3, rel=0.02)
    assert found["workers_rate"]["10"]["chunk_1"] == pytest.approx(10, rel=0.03)
    assert found["workers_parent"]["1000"]["chunk_100"] == pytest.approx(0.02, rel=0.03)
    # Chunks of 500 runs of 1 ms: 6 ms for each
    short = found["durations"]["0.001_s"]
    assert (short["chunk"], short["most"], short["chunk_needed"]) == (500, 83, None)
    assert short["rate"] == pytest.approx(500 / 6e-3, rel=0.02)
    # 25 s for a chunk of two runs of 10 s: 50 chunks a second
    assert found["durations"]["10_s"]["parent"] == pytest.approx(50 * 1.02e-3, rel=0.05)
    # 1 ms over 0.1 ms less 10 us
    assert found["durations"]["1_s"]["chunk_needed"] == 12
    assert "chunks of 12 " in " ".join(str(result).split())


@pytest.mark.long
def test_the_costs_of_the_calling_process_are_measured():
    found = parent_cost(200)
    assert found.submit > 0
    assert min(found) >= 0


def test_chunks_are_longer_while_enough_is_left_for_all():
    chunks = Chunks(((0, run) for run in range(10_000)), 10_000)
    first = chunks.take(25, 2000)
    chunks.note([Row(*job, None, None, 1.0, {}) for job in first])
    sizes = [len(first)]
    while chunk := chunks.take(25, 100):
        sizes.append(len(chunk))
    assert sum(sizes) == 10_000
    assert sizes[1] == 25
    assert sizes[1:] == sorted(sizes[1:], reverse=True)
    assert sizes[-150:] == [1] * 150  # a hundred workers come to the end together
