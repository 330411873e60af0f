"""The benchmarks of grading, of limits and of the panel."""

import json
import sys
from contextlib import nullcontext
from dataclasses import replace

import pytest

import benches
from bench_grading import run as grading_run
from bench_limits import run as limits_run
from bench_panel import hosts
from bench_panel import run as panel_run
from bench_panel.figures import Painted, PanelBench, Watched, painted
from chromium_browser import running_chromium
from painted_frames import assert_order

# --- grading


@pytest.mark.long
def test_the_program_prints_numbers_for_scripts(monkeypatch, capsys):
    few = {"rounds": 1, "seconds": 0.01, "isolation": "auto"}
    monkeypatch.setattr(grading_run.run_grading_bench, "__kwdefaults__", few)
    benches.main(["grading", "--rounds", "1", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert list(found["steps"]) == [*grading_run.KINDS]
    for row in found["steps"].values():
        assert row["ratio"] == pytest.approx(row["worker"] / row["here"])
        assert row["more"] == pytest.approx(row["worker"] - row["here"])
    assert found["start"] > 0


# --- the panel


def test_figures_are_of_the_frames_that_were_seen():
    steps = {k: (100.0 * k, 0.025 * k) for k in range(-5, 30)}
    seen = [(k, 100.0 * k + (20 if k < 10 else 70)) for k in range(11)] + [(999, 0.0)]
    page = painted("page", Watched(seen=seen, began=0.0, ended=2000.0), steps)
    assert page.rate == 5.5
    assert page.latency_median == 20
    assert page.latency_p95 == pytest.approx(45)
    assert page.busy == 25
    assert page.per_frame == pytest.approx(1000 * 0.5 / 11)
    text = str(PanelBench(hosts=(page,), matplotlib=500.0))
    assert "page" in text
    assert "11.0" in text  # times as long with matplotlib


def test_nothing_painted_is_no_result():
    with pytest.raises(RuntimeError, match="the page painted no frames"):
        painted("page", Watched(seen=[(1, 2.0)], began=0.0, ended=9.0), {})


def test_the_program_prints_numbers_and_says_where_there_is_no_jupyterlab(monkeypatch, capsys):
    page = Painted(host="page", rate=30.0, latency_median=9.0, latency_p95=20.0, busy=20.0)
    monkeypatch.setattr(panel_run, "open_chromium", nullcontext)
    monkeypatch.setattr(panel_run, "measure_page", lambda browser, seconds: page)
    monkeypatch.setattr(panel_run, "measure_matplotlib", lambda: 500.0)
    monkeypatch.setattr(panel_run, "is_lab_there", lambda: False)
    benches.main(["panel"])
    assert "JupyterLab is left out" in capsys.readouterr().out
    monkeypatch.setattr(panel_run, "is_lab_there", lambda: True)
    lab = replace(page, host="JupyterLab")
    monkeypatch.setattr(panel_run, "measure_lab", lambda browser, seconds: lab)
    benches.main(["panel", "--json"])
    assert [*json.loads(capsys.readouterr().out)["hosts"]] == ["page", "JupyterLab"]


def test_what_is_missing_is_told_with_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "playwright", None)
    with pytest.raises(ImportError, match="pip install playwright"):
        panel_run.run_panel_bench()


@pytest.fixture(scope="module")
def chromium():
    yield from running_chromium()


@pytest.mark.slow
def test_frames_are_painted_in_their_order(chromium, monkeypatch):
    assert_order(monkeypatch, hosts, lambda s: hosts.measure_page(chromium, s))


# --- hostile files


@pytest.mark.slow
def test_hostile_files_take_what_is_promised(monkeypatch, capsys):
    few = {"names": ["trace, text", "TOML, keys", "store, view", "submission, notebook"]}
    monkeypatch.setattr(limits_run.run_limits_bench, "__kwdefaults__", {"seed": 1} | few)
    benches.main(["limits", "--json"])
    found = json.loads(capsys.readouterr().out)["files"]
    assert [*found] == few["names"]
    for name, row in found.items():
        assert row["within"] == "kept", (name, row)
