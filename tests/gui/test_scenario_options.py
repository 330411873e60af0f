"""All options of a scenario, set in the panel, and its files."""

import numpy as np
import pytest

import robsim
from panel_mouse import Mouse
from robsim import Scenario
from robsim.simulation.options import OPTIONS
from robsim.simulation.scenario_file import data_of
from scenarios import FULL
from small_runs import experiment, frames
from waiting import wait_for

pytestmark = pytest.mark.long

SIZE = (240, 240)


COLORS = [robsim.ColorClass("red", v=(150, 255)), robsim.ColorClass("blue", u=(150, 255))]
# One that can be run: no scenario has a state estimator.
FULL = FULL.replace(seed=7, identify_from="measurement", colors=COLORS)


def options(watcher):
    return {option["name"]: option for option in watcher.newest("options")["options"]}


def ask(watcher, kind, **fields):
    """Say something; return the notes that come."""
    said = len(watcher.of("note"))
    watcher.say(kind, **fields)
    watcher.settle()
    watcher.settle()
    return watcher.of("note")[said:]


def set_option(watcher, name, value):
    notes = ask(watcher, "set_option", name=name, value=value)
    assert [note for note in notes if note["level"] == "error"] == []


def saved(watcher):
    ask(watcher, "save_scenario")
    return watcher.newest("scenario_file")["text"]


def same(one, other):
    assert len(one) == len(other)
    for name in ("pose_true", "u", "pose_measured"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def sent(name):
    """Return another valid value of an option, as a browser sends it."""
    value = getattr(FULL, name)
    return None if value is None else str(value) if name == "seed" else data_of(name, value)


@pytest.mark.filterwarnings("ignore::robsim.vision.SmallMarkersWarning")
def test_all_options_go_into_a_file_that_gives_the_same_run(watch):
    sim = robsim.Simulation(seed=1)
    watcher = watch(sim)
    for name in OPTIONS:
        set_option(watcher, name, sent(name))
    assert {name for name, option in options(watcher).items() if not option["changed"]} == set()
    text = saved(watcher)
    assert Scenario.from_toml(text) == FULL
    for _ in range(4):
        watcher.press("step")
    watcher.view.close()
    same(sim.trace, robsim.Simulation(FULL).run(4))
    again = robsim.Simulation()
    other = watch(again)
    assert ask(other, "load_scenario", text=text) == []
    assert again.scenario == FULL
    other.view.close()
    same(again.run(4), sim.trace)


WRONG = {
    "robot": ["no robot", 3, {}],
    "area": [[10, 10], [600], "wide", None],
    "resolution": [[0, 5], [1.5, 2]],
    "boundary": ["open", None],
    "headings": [0, 361, 3.5],
    "noise": [{"kind": "GaussianNoise", "percent": 101}, {"percent": 3}, True],
    "dropout": [{"probability": 1.5}],
    "process_noise": [{"kind": "PoseNoise", "covariance": [[1, 2], [3, 4]]}],
    "mismatch": [{"sigma": "big"}],
    "motor_delay": [-1, 1001, "late", 10**400, [[[]]]],
    "camera_delay": [0.5],
    "start": [[5000, 0, 0], "left", [1, 2]],
    "seed": [-1, "one"],
    "smoothing": [2, 17],
    "markers": ["/etc", "no robot"],
    "model": [{"kind": "RobotParameters", "mass": -1}, {"kind": "Car"}],
    "control": [{"kind": "Spin", "voltage": "fast"}],
    "measure": ["yes"],
    "speed": [1],
}


def test_a_wrong_value_is_refused_beside_its_field_and_changes_nothing(watch):
    sim = robsim.Simulation(resolution=SIZE, seed=1)
    watcher = watch(sim)
    watcher.press("step")
    before, told = sim.scenario, options(watcher)
    for name, values in WRONG.items():
        for value in values:
            notes = ask(watcher, "set_option", name=name, value=value)
            assert [(note["level"], note["option"]) for note in notes] == [("error", name)], value
    assert sim.scenario == before
    assert options(watcher) == told
    assert sim.n_steps == 1


def test_what_cannot_change_in_a_run_waits_for_the_next_one(watch):
    sim = robsim.Simulation(resolution=SIZE, seed=1, control=lambda step: (0.1, 0.2))
    sim.run(3)
    watcher = watch(sim)
    set_option(watcher, "resolution", [120, 120])
    set_option(watcher, "seed", "5")
    set_option(watcher, "noise", {"kind": "UniformNoise", "percent": 7})
    set_option(watcher, "measure", True)
    waiting = {name for name, option in options(watcher).items() if option["waits"]}
    assert waiting == {"resolution", "seed"}
    assert sim.scenario.seed == 1
    assert len(sim.trace) == 3
    assert sim.noise == robsim.UniformNoise(7)
    values = watcher.newest("state")["values"]
    assert (values["noise"], values["tracking"]) == ("uniform", "default")
    ask(watcher, "keep_options")
    assert not any(option["waits"] for option in options(watcher).values())
    set_option(watcher, "area", [900, 600])
    set_option(watcher, "resolution", None)
    watcher.press("reset")
    watcher.settle()
    assert (sim.n_steps, sim.area, sim.resolution) == (0, (900, 600), (900, 600))
    assert watcher.newest("setup")["area"] == (900, 600)
    assert watcher.newest("state")["values"]["control"] == "mine"
    watcher.press("step")
    assert sim.last_step.frame.image.shape == (600, 900, 3)
    np.testing.assert_array_equal(sim.trace.u, [(0.1, 0.2)])


def test_a_scenario_that_is_loaded_waits_as_a_whole_and_leaves_callbacks(watch, folder):
    sim = robsim.Simulation.from_folder(folder, slots="control", resolution=SIZE, seed=1)
    watcher = watch(sim)
    watcher.press("step")
    loaded = Scenario(noise=robsim.GaussianNoise(5), boundary="unlimited", seed=4)
    assert ask(watcher, "load_scenario", text=loaded.to_toml()) == []
    assert (sim.noise, sim.n_steps) == (None, 1)
    watcher.press("reset")
    watcher.settle()
    assert sim.scenario == loaded
    assert watcher.newest("state")["values"]["control"] == "mine"
    assert {note["level"] for note in ask(watcher, "save_scenario")} == {"info"}
    for text in ("noise = 3", 7, None):
        (wrong,) = ask(watcher, "load_scenario", text=text)
        assert wrong["level"] == "error"
    assert sim.scenario == loaded


def test_identification_from_measurements_brings_tracking(watch):
    sim = robsim.Simulation(resolution=SIZE, estimate_parameters=True, seed=1)
    watcher = watch(sim)
    set_option(watcher, "identify_from", "measurement")
    assert sim.identify_from == "measurement"
    assert watcher.newest("state")["values"]["tracking"] == "default"
    watcher.press("step")
    assert watcher.newest("state")["state"] == "paused"


def test_each_form_that_is_offered_can_be_taken(watch):
    watcher = watch(robsim.Simulation(resolution=SIZE, seed=1))
    for name, option in options(watcher).items():
        for form in option["forms"]:
            set_option(watcher, name, form["data"])
            assert options(watcher)[name]["form"] == form["name"]
            set_option(watcher, name, option["default"])
            assert not options(watcher)[name]["changed"]


def test_a_run_of_another_kind_has_no_options(watch):
    watcher = watch(experiment(frames(3)))
    assert "has_options" not in watcher.newest("setup")
    assert watcher.of("options") == []
    notes = ask(watcher, "set_option", name="area", value=[600, 600])
    assert [note["level"] for note in notes] == ["error"]


@pytest.mark.slow
def test_options_by_mouse(open_panel, tmp_path):
    sim = robsim.Simulation(resolution=SIZE, seed=1)
    mouse = Mouse(*open_panel(sim))
    tab = mouse.tab
    mouse.open("Scenario")
    rows = tab.locator(".robsim-option:visible")
    tab.get_by_role("searchbox").fill("poses in the samples")
    assert rows.count() == 1
    mouse.choose("Identify from", "Measurement")
    wait_for(lambda: sim.identify_from == "measurement")
    tab.get_by_role("searchbox").fill("")
    tab.locator(".robsim-options summary", has_text="World").click()
    assert tab.get_by_label("Area 1").is_hidden()
    mouse.run(3)
    mouse.choose("Headings", "Continuous")  # a change that waits
    begin = tab.locator("button[name=new_run]")
    begin.wait_for()
    delay = tab.get_by_label("Motor delay")
    delay.get_by_role("textbox").fill("late")
    tab.keyboard.press("Enter")
    tab.get_by_role("alert").get_by_text("motor_delay must be").wait_for()
    assert sim.n_steps >= 3
    tab.keyboard.press("Escape")
    wait_for(lambda: delay.get_by_role("textbox").input_value() == "0")
    begin.click()
    wait_for(lambda: sim.n_steps == 0 and sim.scenario.headings is None)
    begin.wait_for(state="hidden")
    tab.click("button[name=changed_options]")
    wait_for(lambda: rows.count() == 4)  # resolution, headings, seed, identify_from
    with tab.expect_download() as saved:
        tab.click("button[name=save_scenario]")
    saved.value.save_as(tmp_path / "saved.toml")
    assert Scenario.load(tmp_path / "saved.toml") == sim.scenario
    headings = tab.get_by_label("Headings", exact=True).first
    headings.get_by_role("button", name="Back to default").click()
    wait_for(lambda: sim.scenario.headings == 36)
    with tab.expect_file_chooser() as chooser:
        tab.click("button[name=load_scenario]")
    chooser.value.set_files(tmp_path / "saved.toml")
    wait_for(lambda: sim.scenario.headings is None)
