"""The pages of the documentation: programs, tables, sensitivity."""

import contextlib
import importlib.util
import io
import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

import robsim
from bench_campaign import dask_tasks, parent, scaling
from commands import command
from prose import PAGES, README, ROOT, SITE, blocks
from robsim.campaigns import CampaignSpec

SCRIPT = ROOT / "assets/draw_sensitivity.py"
pytestmark = pytest.mark.long

with_pages = pytest.mark.skipif(not SITE.is_dir(), reason="needs the sources")
with_script = pytest.mark.skipif(not SCRIPT.is_file(), reason="needs the sources")


# --- programs and tables


#: Of the grader and of a laboratory: test_readme.py runs them.
APART = ("def test_", "send=motors")


def programs(page):
    return [one for one in blocks(page) if not any(mark in one for mark in APART)]


WITH_PROGRAMS = [page for page in PAGES if programs(page)]


@with_pages
@pytest.mark.parametrize("page", WITH_PROGRAMS, ids=lambda page: page.stem)
def test_the_programs_of_a_page_print_its_tables(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = page.read_text(encoding="utf-8")
    for program in programs(page):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(program, {"__name__": "__main__"})
        rows = [line for line in printed.getvalue().splitlines() if line.startswith("|")]
        assert "\n".join(rows) in text


@with_script
def test_pages_show_pictures_and_pages_that_are_there():
    for page in (README, *PAGES):
        links = re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8"))
        links = [link for link in links if "://" not in link]
        made = [link for link in links if link.startswith("reference/")]  # by ./run docs
        assert [link for link in links if not (page.parent / link).is_file()] == made


@with_pages
def test_check_prints_the_json_of_the_page(tmp_path):
    (program,) = blocks(SITE / "check_json.md")
    (shown,) = blocks(SITE / "check_json.md", "json")
    (tmp_path / "control.py").write_text(program)
    run = command("check", "control.py", "--json", cwd=tmp_path)
    assert run.exit_code == 1
    printed, shown = json.loads(run.stdout), json.loads(shown)
    (problem,), (shown_problem,) = printed["problems"], shown["problems"]
    assert printed.keys() == shown.keys()
    assert (printed["verdict"], printed["callbacks"]) == (shown["verdict"], shown["callbacks"])
    assert problem.keys() == shown_problem.keys()
    assert {**problem, "sentence": ""} == {**shown_problem, "sentence": ""}
    text = (SITE / "check_json.md").read_text(encoding="utf-8")
    keys = [*printed, *(f"problems.{key}" for key in problem)]
    assert all(f"| `{key}` |" in text for key in keys)


@with_pages
@pytest.mark.slow
@pytest.mark.parametrize("library", ["filterpy", "stonesoup", "control"])
def test_the_program_with_another_library_works(library):
    pytest.importorskip(library)
    first, *programs = blocks(SITE / "other_libraries.md", "{code-cell} python")
    (program,) = (one for one in programs if f"from {library}" in one or f"import {library}" in one)
    *lines, last = program.rstrip().splitlines()
    names = {}
    exec(first + "\n".join(lines), names)
    result = eval(last, names)
    if library == "control":
        assert result.reached == 1
    else:  # while the robot is hidden, the prediction of a constant velocity errs by some px
        assert result.rmse == pytest.approx([0, 0, 0], abs=5)
        assert result.rmse[2] < 0.1  # rad


@pytest.fixture(scope="module")
def bounds():
    """The bounds of the lab robot for both cameras and some noise, at one pose in the light."""
    pose = (500.3, 600.6, 0.3)
    found = {}
    for size in (1200, 480):
        sim = robsim.Simulation(robot="lab", headings=None, resolution=(size, size), start=pose)
        sim.step()
        for noise in (robsim.GaussianNoise(2), robsim.GaussianNoise(10), robsim.UniformNoise(40)):
            found[size, noise] = robsim.estimation.measurement_bound(
                sim.frame, pose, sim.robot, noise=noise
            )
    return found


@with_pages
def test_the_table_of_bounds_is_that_of_the_function(bounds):
    text = (SITE / "measurement.md").read_text(encoding="utf-8")
    columns = {
        robsim.GaussianNoise(2): 1,
        robsim.GaussianNoise(10): 3,
        robsim.UniformNoise(40): 10,
    }
    for (size, noise), bound in bounds.items():
        (row,) = re.findall(rf"^\| {size} px \| (.*) \|$", text, re.MULTILINE)
        xy, heading = map(float, row.split(" | ")[columns[noise]].split(", "))
        assert bound.rmse_xy == pytest.approx(xy, rel=0.06)
        assert bound.rmse_heading_deg == pytest.approx(heading, rel=0.06)


@with_pages
def test_the_formula_for_round_markers_is_near_the_bound(bounds):
    best = {}
    exec(programs(SITE / "measurement.md")[1], best)
    layout = robsim.load_robot("lab").marker_layout()
    diameter = 2 * np.sqrt(layout.areas["right"] / np.pi)
    for (size, noise), bound in bounds.items():
        if noise != robsim.GaussianNoise(10):
            continue
        snr, least = best["best"](
            diameter * size / 1200, 10, marker=diameter, contrast=148, w=bound.edge_width
        )
        assert bound.signal_to_noise == pytest.approx(snr, rel=0.05)
        heading = np.deg2rad(bound.rmse_heading_deg)
        # Midway between the markers, from where the centre is `offset` px ahead.
        middle = np.sqrt(bound.rmse_xy**2 - (layout.offset * heading) ** 2)
        assert middle == pytest.approx(least, rel=0.08)
        assert heading == pytest.approx(np.sqrt(2) * least / layout.distance, rel=0.08)


def cells(text, begin):
    """The cells of the rows of the table whose heading begins with a text."""
    rows = text[text.index(f"| {begin}") :].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("| ").split("|")] for row in rows]


@with_pages
def test_what_many_workers_give_follows_from_the_costs_of_the_page():
    text = (SITE / "campaigns.md").read_text(encoding="utf-8")
    costs = [1e-6 * float(cost.removesuffix(" us")) for _, cost in cells(text, "cost of")]
    submit, receive, row, flying, client, scheduler = costs
    found = scaling.scaling_of(
        parent.ParentCost(submit=submit, receive=receive, row=row, flying=flying),
        dask_tasks.TaskCost(client=client, scheduler=scheduler),
    )
    for workers, *shown in cells(text, "workers"):
        for one, cell in zip(found.by_workers[int(workers)].values(), shown, strict=True):
            rate, busy = cell.removesuffix(" %").split(", ")
            assert one.rate == pytest.approx(float(rate), rel=0.03, abs=0.5)
            assert 100 * one.parent == pytest.approx(float(busy), rel=0.05, abs=0.05)
    for (seconds, one), shown in zip(
        found.by_duration.items(), cells(text, "a run takes"), strict=True
    ):
        assert f"{seconds:g} s" == shown[0]
        assert one.rate == pytest.approx(float(shown[2]), rel=0.03)
        needed = found.chunk_needed(seconds)
        assert shown[-1] == ("none" if needed is None else str(needed))


# --- the page of sensitivity


PAGE = ROOT / "notebooks/site/sensitivity.md"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location(SCRIPT.stem, SCRIPT)
    module = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, SCRIPT.stem, module)  # where dataclasses look for it
        spec.loader.exec_module(module)
        yield module


@pytest.fixture
def errors_in(script, monkeypatch):
    """The errors of a setting in two short runs."""

    def errors_in(name):
        short = replace(script.SETTINGS[name], steps=80)
        monkeypatch.setitem(script.SETTINGS, name, short)
        return script.errors_of(name, runs=2)

    return errors_in


@with_script
def test_every_setting_is_a_campaign_and_stands_on_the_page(script):
    page = PAGE.read_text(encoding="utf-8")
    for name, setting in script.SETTINGS.items():
        spec = CampaignSpec(
            scenario=setting.scenario,
            vary=setting.vary,
            metrics=setting.metrics,
            runs=1,
            steps=setting.steps,
        )
        labels = {" ".join(map(str, case.labels.values())) for case in spec.cases}
        assert setting.base in {"", *labels, *setting.metrics}
        assert f"**{name}**" in page
    assert f"{script.RUNS} runs" in page


@with_script
def test_the_marked_value_is_the_base_itself(script):
    """What the panels have in common is one case: there the same seeds give the same errors."""
    for name in ("drawn headings", "voltages", "lost frames", "hold of a voltage"):
        setting = script.SETTINGS[name]
        spec = CampaignSpec(
            scenario=setting.scenario, vary=setting.vary, metrics=setting.metrics, runs=1, steps=5
        )
        (case,) = (one for one in spec.cases if str(*one.labels.values()) == setting.base)
        marked = robsim.Simulation(spec._scenario_of(case), seed=3).run(30)
        base = robsim.Simulation(script.BASE, seed=3).run(30)
        np.testing.assert_array_equal(marked.pose_measured, base.pose_measured)


@with_script
def test_more_noise_means_larger_errors_in_the_figure_and_the_table(script, errors_in):
    found = {"camera noise": errors_in("camera noise")}
    values, errors, _ = found["camera noise"]
    assert (errors[:, -1] > 3 * errors[:, 1]).all()
    figure = script.figure_of(found)
    (axes,) = figure.axes
    assert axes.get_title(loc="left") == "camera noise"
    assert [tick.get_text() for tick in axes.get_xticklabels()] == list(values)
    lines = {line.get_label(): line for line in axes.lines}
    for group, drawn in zip(script.GROUPS, errors, strict=True):
        np.testing.assert_allclose(lines[group].get_ydata(), np.clip(drawn, *script._LIMITS))
    assert f"{errors[0, -1]:.2g} (" in script.table("camera noise", found["camera noise"])
