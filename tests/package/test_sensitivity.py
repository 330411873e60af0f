"""The sensitivity of identification: its campaigns, its figure, its page."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import robsim
from robsim.campaigns import CampaignSpec

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "assets/draw_sensitivity.py"
PAGE = ROOT / "notebooks/site/sensitivity.md"

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not SCRIPT.is_file(), reason="needs the sources"),
]


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
