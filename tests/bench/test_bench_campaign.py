"""The benchmark of campaigns runs and says what it found."""

import json
import re

import pytest

from commands import command
from robsim.bench._campaign import run
from robsim.bench._campaign.result import CampaignBench
from robsim.campaigns._engines.chunks import SECONDS, size_for

NUMBERS = {
    "serial": {"no_frames": (0.0002, 0.00025), "frames_240": (0.010, 0.011)},
    "parallel": {"campaign": 190.0, "separate": 200.0, "pool": 152.0},
    "growing": {100: 0.0004, 10_000: 0.0003},
    "memory": 3.25,
    "row": 10e-6,
    "chunk": 300e-6,
}


@pytest.mark.long
def test_the_command_prints_numbers_for_scripts(tmp_path, monkeypatch):
    few = {"rounds": 1, "seconds": 0.01, "sizes": (20, 40)}
    monkeypatch.setattr(run.run_campaign_bench, "__kwdefaults__", few)
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
    assert found["parent_row"] >= 0
    assert found["parent_chunk"] >= 0


def test_the_table():
    text = str(CampaignBench(**NUMBERS, left_out=("joblib is left out: pip install joblib",)))
    assert re.search(r"memory over 10000 runs \(MB\) +3\.2", text)
    assert re.search(r"no_frames +0\.200 +0\.250 +1\.25 +0\.050", text)
    assert re.search(r"pool +152 +1\.25", text)
    assert re.search(r"10000 +0\.300 +0\.75", text)
    assert "joblib is left out" in text
    assert max(map(len, text.splitlines())) <= 100


def test_what_many_workers_would_give_follows_from_the_costs():
    rows = CampaignBench(**NUMBERS).to_dict()["workers"]
    # 1000 workers with runs of 10 ms bring 10^5 rows a second; in chunks of 25 each costs 22 us.
    short = rows["0.01_s"]
    assert short["chunk"] == 25
    assert short["busy"] == pytest.approx(1000 / (1e5 * (10e-6 + 300e-6 / 25)))
    assert (short["parent"], short["chunk_needed"]) == (1, None)
    # With runs of 1 s each may cost 100 us: 90 us a row for the chunks.
    long = rows["1_s"]
    assert long["parent"] == pytest.approx(1000 * 310e-6)
    assert (long["busy"], long["chunk_needed"]) == (1000, 4)


def test_chunks_take_a_time_but_have_not_too_many_runs():
    assert size_for(SECONDS / 10.5) == 10
    assert (size_for(0), size_for(60)) == (500, 1)


def test_other_benchmarks_are_not_run_with_it(tmp_path):
    ended = command("bench", "--campaign", "--panel", cwd=tmp_path)
    assert ended.exit_code != 0
    assert "--panel and --campaign are two benchmarks: give one of them" in ended.stderr
