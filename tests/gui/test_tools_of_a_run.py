"""The tools in the panel of a run, with and without a browser."""

import dataclasses
import threading

import numpy as np
import pytest

import robsim
from robsim.vision import default_robot, load_robot, robot_names, set_default_robot
from waiting import wait_for

# --- without a browser


def simulation(**options):
    given = {"robot": "lab", "measure": True, "area": (400, 400), "seed": 1, "headings": None}
    return robsim.Simulation(**given | options)


@pytest.fixture
def watcher(watch, user_folder):
    return watch(simulation())  # which closes it


def opened(watcher, name):
    before = len(told(watcher, "state"))
    watcher.say("tool", name=name)
    watcher.settle()
    tell(watcher, "hello", width=200)
    wait_for(lambda: len(told(watcher, "state")) > before)
    return watcher.view.tools.tool


def tell(watcher, kind, **fields):
    name = watcher.newest("state")["tool"]
    watcher.say("tell_tool", name=name, message={"type": kind, **fields})


def told(watcher, kind):
    messages = [message["message"] for message in watcher.of("tool")]
    return [message for message in messages if message["type"] == kind]


def used(watcher):
    watcher.say("use_tool")
    wait_for(lambda: watcher.newest("state")["tool"] is None)
    watcher.settle()


def test_the_square_stands_on_the_robot_and_bare_floor_has_none(watch, user_folder):
    watcher = watch(simulation(start=(250, 120, 0.5)))
    watcher.press("step")
    tool = opened(watcher, "robots")
    tell(watcher, "resume")
    wait_for(lambda: told(watcher, "state")[-1]["square"])
    u, v, side = told(watcher, "state")[-1]["square"]
    assert (u, v) == pytest.approx((250, 120), abs=3)
    assert side == pytest.approx(1.2 * load_robot("lab").size, rel=0.01)
    tell(watcher, "square", at=[100, 300], side=60)
    tell(watcher, "capture")
    wait_for(lambda: told(watcher, "note"))
    assert told(watcher, "state")[-1]["mode"] == "draw"
    assert tool._view.drawing.sketch.problems()


def test_a_robot_can_be_used_in_this_run_alone(watcher):
    before = default_robot(), robot_names()
    opened(watcher, "robots")
    tell(watcher, "resize", size=100)
    watcher.say("use_here")
    wait_for(lambda: watcher.newest("state")["tool"] is None)
    watcher.settle()
    assert watcher.view.runner.robot.size == 100
    assert (default_robot(), robot_names()) == before


def test_a_tool_is_opened_for_all_and_closed_again(watcher):
    assert watcher.newest("setup")["tools"] == ["robots", "colors"]
    assert watcher.newest("state")["tool"] is None
    tool = opened(watcher, "robots")
    assert isinstance(tool, robsim.gui.RobotPanel)
    assert watcher.newest("state")["tool"] == "robots"
    other = opened(watcher, "colors")
    assert tool._is_closed
    watcher.say("tool", name=None)
    watcher.settle()
    assert other._is_closed
    assert watcher.newest("state")["tool"] is None
    assert watcher.view.runner.robot.name == "lab"


def test_what_a_tool_says_and_hears_goes_through_the_panel(watcher):
    opened(watcher, "robots")
    assert told(watcher, "state")[-1]["name"] == "lab"
    assert told(watcher, "state")[-1]["mode"] == "draw"
    tell(watcher, "load", name="sheep")
    wait_for(lambda: told(watcher, "state")[-1]["name"] == "sheep")
    tell(watcher, "grant", upto=99, late=False)
    wait_for(lambda: told(watcher, "frame"))
    tell(watcher, "nonsense")
    wait_for(lambda: told(watcher, "note"))


@pytest.mark.long
def test_the_run_goes_on_with_the_robot_that_is_drawn(watcher):
    sim = watcher.view.runner
    watcher.say("press", button="step")
    watcher.settle()
    opened(watcher, "robots")
    tell(watcher, "load", name="sheep")
    used(watcher)
    wait_for(lambda: sim.n_steps > 3)
    watcher.say("press", button="pause")
    watcher.settle()
    assert watcher.newest("setup")["robot"]["name"] == "sheep"
    assert sim.trace.info.changed == ("robot",)
    assert default_robot() == "sheep"
    assert sim.trace.seen.all()


@pytest.mark.long
def test_a_robot_that_is_changed_is_saved_and_survives(watcher):
    opened(watcher, "robots")
    tell(watcher, "turn", degrees=-30)
    used(watcher)
    assert watcher.view.runner.robot.alignment == load_robot("lab").alignment - 30
    assert default_robot() == "mine"
    assert load_robot() == watcher.view.runner.robot
    opened(watcher, "robots")
    tell(watcher, "turn", degrees=30)
    used(watcher)
    assert load_robot("mine").alignment == load_robot("lab").alignment
    assert robot_names().count("mine") == 1


@pytest.mark.long
def test_another_picture_never_takes_the_place_of_a_robot_of_the_users(watcher):
    lab, sheep = load_robot("lab"), load_robot("sheep")
    robsim.vision.add_robot("mine", sheep)
    tool = opened(watcher, "robots")
    image = np.array(lab.image)
    for expected in ("mine2", "mine3"):
        take = tool._view.loading(image, "mine.png")
        tool._view.ask(take)
        used(watcher)
        assert watcher.view.runner.robot.name == expected
        tool = opened(watcher, "robots")
    assert load_robot("mine").image.shape == sheep.image.shape
    tool._view.ask(tool._view.loading(image, "photo of it.png"))
    tool.turn(10)
    used(watcher)
    assert watcher.view.runner.robot.name not in ("mine", "mine2", "mine3")


def test_the_run_goes_on_with_the_colours_that_are_trained(watcher):
    sim = watcher.view.runner
    before = sim.colors
    tool = opened(watcher, "colors")
    assert tool.value == before
    tell(watcher, "choose", name="red")
    tell(watcher, "ranges", ranges=[[0, 255], [0, 100], [200, 255]], goes_on=False)
    used(watcher)
    assert next(color for color in sim.colors if color.name == "red").u == (0, 100)


def test_colours_that_the_measurement_cannot_do_without_are_kept(watcher):
    sim = watcher.view.runner
    before = sim.colors
    opened(watcher, "colors")
    tell(watcher, "choose", name="red")
    tell(watcher, "remove")
    watcher.say("use_tool")
    wait_for(watcher.notes)
    assert "colors must have red and blue" in watcher.notes()[-1]
    assert sim.colors == before
    assert sim.trace.info.changed == ()
    assert watcher.newest("state")["tool"] == "colors"


def test_what_a_closed_tool_still_says_does_not_reach_the_next_one(watcher):
    tool = opened(watcher, "robots")
    goes_on = threading.Event()
    tool._view.post(goes_on.wait)
    tool._view.post(tool._view.tell_state)
    opened_before = len(told(watcher, "state"))
    watcher.say("tool", name="colors")
    watcher.settle()
    goes_on.set()
    wait_for(lambda: not tool._view._thread.is_alive())
    watcher.settle()
    watcher.settle()
    assert len(told(watcher, "state")) == opened_before
    watcher.say("tell_tool", name="robots", message={"type": "load", "name": "sheep"})
    watcher.settle()
    assert watcher.notes() == []


def test_a_robot_that_stays_or_is_refused_is_neither_saved_nor_the_default(watcher):
    set_default_robot("sheep")
    opened(watcher, "robots")
    used(watcher)
    assert default_robot() == "sheep"
    assert watcher.view.runner.robot.name == "lab"
    opened(watcher, "robots")
    tell(watcher, "resize", size=900)
    watcher.say("use_tool")
    wait_for(watcher.notes)
    assert "area must be wider than the robot" in watcher.notes()[-1]
    assert "mine" not in robot_names()
    assert default_robot() == "sheep"
    assert watcher.newest("state")["tool"] == "robots"


@pytest.mark.long
def test_another_robot_of_the_same_name_is_not_written_over(watch, user_folder):
    robsim.vision.add_robot("mine", "sheep")
    other = dataclasses.replace(load_robot("lab"), name="mine")
    watcher = watch(simulation(robot=other))
    opened(watcher, "robots")
    tell(watcher, "turn", degrees=10)
    used(watcher)
    assert load_robot("mine").image.shape == load_robot("sheep").image.shape
    assert watcher.view.runner.robot.name == "mine2"
    assert "saved as mine2; mine2 is now the default robot" in watcher.notes()


def test_a_colour_file_that_was_not_opened_is_not_written_over(watcher, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mine = [robsim.ColorClass("red", u=(0, 100), v=(150, 255))]
    robsim.vision.save_colors("colors.toml", mine)
    opened(watcher, "colors").save()
    assert robsim.load_colors("colors.toml")[0] == mine[0]
    assert len(robsim.load_colors("colors2.toml")) == 2


def test_stop_is_heard_while_a_tool_is_busy(watcher):
    tool = opened(watcher, "robots")
    goes_on = threading.Event()
    tool._view.post(goes_on.wait)
    watcher.say("use_tool")
    watcher.say("press", button="step")
    wait_for(lambda: watcher.view.runner.n_steps == 1)
    assert watcher.newest("state")["tool"] == "robots"
    goes_on.set()
    wait_for(lambda: watcher.newest("state")["tool"] is None)


def test_a_line_that_is_gone_is_gone_for_the_tool(watcher):
    tool = opened(watcher, "robots")
    wait_for(lambda: tool._view.links)
    watcher.view.disconnect(watcher)
    wait_for(lambda: not tool._view.links)


@pytest.mark.long
def test_another_robot_from_a_cell_is_shown(watcher):
    watcher.view.runner.robot = "sheep"
    wait_for(lambda: watcher.newest("setup")["robot"]["name"] == "sheep")


def test_a_recorded_run_has_no_tools(watch):
    sim = simulation()
    watcher = watch(sim.run(3))
    assert watcher.newest("setup")["tools"] == []
    watcher.say("tool", name="robots")
    wait_for(watcher.notes)
    assert "no tool" in watcher.notes()[-1]


def test_an_experiment_trains_on_its_frames_and_waits_for_start(watch, user_folder):
    frames = [simulation(seed=seed).step().frame for seed in range(3)]
    watcher = watch(robsim.Experiment(frames, robot="lab", area=(400, 400)))
    tool = opened(watcher, "colors")
    watcher.say("press", button="step")
    wait_for(lambda: tool._view.picture is not None)
    np.testing.assert_array_equal(tool._view.picture.frame.image, frames[0].image)
    used(watcher)
    assert watcher.newest("state")["state"] == "paused"


def test_the_tool_of_a_panel_can_be_scripted(user_folder):
    with robsim.panel(simulation()) as panel:
        assert panel.tool is None
        panel._view.post(lambda: panel._view.tools.begin("robots"))
        wait_for(lambda: panel.tool is not None)
        panel.tool.turn(30)
        assert panel.tool.value.alignment == load_robot("lab").alignment + 30
        tool = panel.tool
    assert tool._is_closed


# --- in Chromium


@pytest.mark.slow
def test_a_robot_from_the_list_drives_on(open_panel, user_folder):
    sim = simulation()
    view, tab = open_panel(sim, theme="dark")
    tab.click("[name=define_robot]")
    tab.wait_for_selector(".robsim-tool")
    assert not tab.is_visible(".robsim-transport")
    tab.select_option(".robsim-tool [name=robot]", "sheep")
    wait_for(lambda: view.tools.tool._view.name == "sheep")
    tab.click("[name=use_tool]")
    tab.wait_for_selector(".robsim-title-name:has-text('sheep')")
    assert tab.is_visible(".robsim-transport")
    wait_for(lambda: sim.n_steps > 2)
    assert default_robot() == "sheep"


@pytest.mark.slow
def test_keys_in_a_tool_are_the_tools(open_panel, user_folder):
    sim = simulation()
    view, tab = open_panel(sim)
    tab.click("[name=define_robot]")
    tab.wait_for_selector(".robsim-tool [value=outline][aria-checked=true]")
    tab.focus(".robsim-tool canvas")
    tab.keyboard.press("Enter")
    tab.wait_for_selector(".robsim-tool [value=red][aria-checked=true]")
    tab.keyboard.press("Space")
    tab.keyboard.press("ArrowRight")
    tab.mouse.click(1400, 850)  # beside the tool, the run does not hear them either
    for key in (" ", ".", "s"):
        tab.keyboard.press(key)
    tab.click(".robsim-tool [name=clear]")
    tab.wait_for_selector(".robsim-problems:visible")
    tab.click("[name=use_tool]")
    tab.locator(".robsim-toast:has-text('red marker needs at least 3 corners')").wait_for()
    tab.click("[name=discard_tool]")
    tab.wait_for_selector(".robsim-tool", state="detached")
    assert view.driver.state == "paused"
    assert sim.n_steps == 0


@pytest.mark.slow
def test_motors_are_stopped_beside_a_tool(open_panel, user_folder):
    sent = []
    frames = [robsim.Frame(np.zeros((64, 64, 3), np.uint8))] * 2000
    options = {"area": (64, 64), "measure": False, "identify_from": "truth"}
    experiment = robsim.Experiment(
        frames, send=lambda u: sent.append(tuple(u)), control=lambda step: (1, 2), **options
    )
    view, tab = open_panel(experiment, speed=0.2)
    tab.click(".robsim-transport [name=start]")
    tab.click("[name=train_colors]")
    tab.wait_for_selector(".robsim-tool")
    wait_for(lambda: (1, 2) in sent)
    tab.click(".robsim-tool-bar [name=stop]")
    wait_for(lambda: sent[-1:] == [(0, 0)])
    wait_for(lambda: view.driver.is_stopped)
