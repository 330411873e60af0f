"""The benchmark of campaigns runs and says what it found."""

import json

import pytest

import benches
from bench_campaign import dask_tasks, parent, run, scaling
from sizes import thorough

PARENT = parent.ParentCost(submit=10e-6, receive=90e-6, row=10e-6, flying=0.0)
TASK = dask_tasks.TaskCost(client=900e-6, scheduler=800e-6)


@pytest.mark.slow
def test_the_program_prints_numbers_for_scripts(monkeypatch, capsys):
    few = {"rounds": 1, "seconds": 0.01, "sizes": (20, 40), "tasks": 10}
    monkeypatch.setattr(run.run_campaign_bench, "__kwdefaults__", few)
    if not thorough(True, False):
        monkeypatch.setattr(run, "dask_task_cost", lambda tasks: TASK)
    benches.main(["campaign", "--rounds", "1", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert list(found["serial"]) == ["no_frames", "frames_240"]
    for row in found["serial"].values():
        assert row["ratio"] == pytest.approx(row["campaign"] / row["bare"])
    rates = found["parallel"]
    assert list(rates)[:3] == ["campaign", "separate", "pool"]
    assert all(row["runs_per_second"] > 0 for row in rates.values())
    assert list(found["growing"]) == ["20", "40"]
    assert found["parent_receive"] > 0
    assert found["workers_rate"]["1"]["chunk_1"] > 0


@pytest.mark.long
def test_what_many_workers_would_give_follows_from_the_costs():
    found = run.CampaignBench(
        serial={"no_frames": (0.0002, 0.00025)},
        parallel={"campaign": 190.0},
        growing={100: 0.0004},
        memory=3.25,
        scaling=scaling.scaling_of(PARENT, TASK),
    ).to_dict()
    # A chunk costs the calling process 1 ms, a row 10 us; the scheduler is quicker.
    assert found["workers_rate"]["1000"]["chunk_1"] == pytest.approx(1 / 1.01e-3, rel=0.02)
    assert found["workers_rate"]["10"]["chunk_1"] == pytest.approx(10, rel=0.03)
    assert found["workers_parent"]["1000"]["chunk_100"] == pytest.approx(0.02, rel=0.03)
    # Chunks of 250 runs of 1 ms: 3.5 ms for each
    short = found["durations"]["0.001_s"]
    assert (short["chunk"], short["most"], short["chunk_needed"]) == (250, 71, None)
    assert short["rate"] == pytest.approx(250 / 3.5e-3, rel=0.02)
    # 1 ms over 0.1 ms less 10 us
    assert found["durations"]["1_s"]["chunk_needed"] == 12
