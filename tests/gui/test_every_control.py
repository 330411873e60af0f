"""Every control of the panel, used in a browser with Python behind it; and none is left out."""

import os
import re
import threading

import numpy as np
import pytest

import robsim
from panel_mouse import Mouse, number
from robsim.trace import PARAMETER_NAMES
from small_runs import experiment, frames
from waiting import wait_for

pytestmark = pytest.mark.slow

DRIVES = {
    "off": "Spin",  # with 0 V
    "spin": "Spin",
    "drive-around": "DriveAround",
    "pseudo-random-binary": "PseudoRandomBinary",
    "multi-sine": "MultiSine",
    "chirp": "Chirp",
    "go-to-point": "GoToPoint",
    "follow-path": "FollowPath",
    "mine": "function",
}

#: Names what is used, and what there is: each choice of a group by itself.
_USED = """(() => {
  window.used = new Set();
  window.keyOf = (e) => {
    const sheet = e.closest("[role=tabpanel]")?.className.replace("robsim-", "") ?? "";
    const group = e.closest("[role=radiogroup]")?.ariaLabel ?? (e.role == "tab" ? "tab" : "");
    const own = e.name || e.value || e.className || e.tagName;
    return [sheet, group, own].filter(Boolean).join(" ");
  };
  const note = ({ target, type }) => {
    const e = target.closest?.("button, input, select, summary");
    if (e && (type == "click") == !/range|select/.test(e.type)) used.add(keyOf(e));
  };
  for (const type of ["click", "input"]) document.addEventListener(type, note, true);
})()"""
_LEFT_OUT = """(except) => [...document.querySelectorAll("button, input, select, summary")]
  .filter((e) => !e.closest(except)).map(keyOf).filter((key) => !used.has(key))"""


def measure(step):
    return robsim.locate(step.blobs, step.markers, step.frame.plane_map)


def estimate_parameters(step):
    return np.zeros((3, 5))


def estimate_state(step):
    x, y, heading = (300, 300, 0) if step.measurement is None else step.measurement.pose
    return robsim.Estimate((x, y, heading), np.eye(3))


def control(step):
    return 0.1, 0.2


@pytest.fixture
def editor(tmp_path, monkeypatch):
    """The file into which the user's editor writes what it is to open."""
    said = tmp_path / "said"
    program = tmp_path / "code"
    program.write_text(f'#!/bin/sh\necho "$@" > {said}\n')
    program.chmod(0o755)
    monkeypatch.setenv("VISUAL", str(program))
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    return said


@pytest.fixture
def mouse(open_panel):
    """The panel of a simulation with callbacks of the user's."""
    own = (measure, estimate_parameters, estimate_state, control)
    simulation = robsim.Simulation(
        robot="lab", area=(600, 600), seed=1, **{function.__name__: function for function in own}
    )
    mouse = Mouse(*open_panel(simulation))
    mouse.tab.evaluate(_USED)
    return mouse


def told(mouse, name):
    """Return what Python tells of its state."""
    return mouse.view._gathered("state")[name]


def wait_for_value(mouse, name, value):
    """Wait until a control has a value in Python."""
    wait_for(lambda: told(mouse, "values")[name] == pytest.approx(value))


def use_settings(mouse):
    stages = {
        "Tracking": "tracking",
        "Parameter estimation": "parameters",
        "State estimation": "state",
    }
    for label, name in stages.items():
        for choice in ("Off", "Mine", "Default"):
            mouse.choose(label, choice)
            wait_for_value(mouse, name, choice.lower())
    drives = mouse.tab.get_by_label("Robot drives")
    values = [one.get_attribute("value") for one in drives.locator("option").all()]
    assert sorted(values) == sorted(DRIVES)
    for value in [*values, "drive-around"]:
        drives.select_option(value)
        wait_for_value(mouse, "control", value)
        assert type(mouse.view.runner._callbacks["control"]).__name__ == DRIVES[value]
    kinds_of = {"Noise": ("Uniform", "Gaussian"), "Disturbance": ("Pose", "Wheels")}
    for group, kinds in kinds_of.items():
        for kind in (*kinds, "None", kinds[0]):
            mouse.choose(group, kind)
            wait_for_value(mouse, group.lower(), kind.lower())
    sliders = {
        "Noise level": ("noise_level", 12, 12),
        "Level of the disturbance": ("disturbance_level", 0.1, 0.1),
        "Dropout": ("dropout", 0.25, 0.25),
        "Speed": ("speed", 16, 100),
    }
    for label, (name, at, value) in sliders.items():
        mouse.tab.get_by_role("slider", name=label, exact=True).fill(str(at))
        wait_for_value(mouse, name, value)


def use_transport(mouse):
    tab = mouse.tab
    tab.click("button[name=first]")
    wait_for(lambda: mouse.n_steps > 5)
    mouse.pause()
    n = mouse.n_steps
    mouse.press("step")
    wait_for(lambda: mouse.n_steps == n + 1)
    before = mouse.view.runner.stage
    mouse.press("step_stage")
    wait_for(lambda: mouse.view.runner.stage != before)
    mouse.press("reset")
    wait_for(lambda: mouse.n_steps == 0)
    for is_on in ("true", "false"):
        mouse.press("slowly")
        tab.locator(f"button[name=slowly][aria-pressed={is_on}]").wait_for()
    mouse.open("Traces")
    mouse.press("start")
    wait_for(lambda: mouse.n_steps > 60)
    mouse.pause()
    place = tab.locator(".robsim-title-step")
    slider = tab.locator("input[name=timeline]").bounding_box()
    tab.mouse.click(slider["x"] + slider["width"] / 2, slider["y"] + slider["height"] / 2)
    wait_for(lambda: 20 < int(place.inner_text().split()[1]) < mouse.n_steps - 20)
    tab.click("button[name=newest]")
    wait_for(lambda: place.inner_text() == f"step {mouse.n_steps - 1}")
    tab.mouse.click(slider["x"] + 10, slider["y"] + slider["height"] / 2)
    tab.click("button[name=past_step]")


def use_picture(mouse):
    tab = mouse.tab
    canvas = tab.locator(".robsim-camera > canvas")
    box = canvas.bounding_box()
    scale = box["width"] / 600

    def at(x, y):
        return {"x": scale * x, "y": scale * y}

    tab.click("button[name=go_to]")
    canvas.click(position=at(150, 450))
    wait_for(lambda: told(mouse, "goal"))
    assert told(mouse, "goal") == pytest.approx([150, 450], abs=2)
    tab.click("button[name=draw_path]")
    canvas.click(position=at(100, 300))
    canvas.click(position=at(300, 300))
    tab.click("button[name=path_cancel]")
    tab.click("button[name=draw_path]")
    for point in ((100, 300), (300, 300), (450, 500)):
        canvas.click(position=at(*point))
    tab.click("button[name=path_done]")
    path = wait_for(lambda: told(mouse, "path"))
    np.testing.assert_allclose([path[0], path[-1]], [(100, 300), (450, 500)], atol=2)
    tab.select_option("select[name=control]", "go-to-point")
    wait_for_value(mouse, "control", "go-to-point")
    canvas.click(position=at(400, 200))  # without the button
    wait_for(lambda: told(mouse, "goal") == pytest.approx([400, 200], abs=2))
    tab.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    tab.mouse.wheel(0, -400)
    whole = tab.locator("button[name=zoom_reset]")
    assert whole.inner_text() > "1.5"
    whole.click()
    assert whole.is_hidden()
    tab.click("button[name=show]")
    for switch in tab.locator(".robsim-show-list input").all():
        was, name = switch.is_checked(), switch.get_attribute("name")
        is_seen = name in ("show_truth", "show_planned", "show_object_trace", "show_covariance")
        before = mouse.picture() if is_seen else None
        switch.click()
        assert switch.is_checked() != was
        if is_seen:
            mouse.paint()
            assert (mouse.picture() != before).any(), name
        switch.click()
    tab.click("button[name=show]")


def use_charts(mouse):
    tab = mouse.tab
    x = mouse.chart("x px")
    for name in ("true", "measured", "estimated", "held"):
        button = tab.locator(f".robsim-traces button[name=show_{name}]")
        shown = x.count(name)
        assert shown
        button.click()
        mouse.paint()
        assert x.count(name) < shown / 2
        button.click()
    tab.locator("[name=objects]").check()
    wait_for(lambda: x.count("blue"))
    tab.locator("[name=objects]").uncheck()
    tab.select_option("select[name=add_column]", "u1")
    assert wait_for(lambda: mouse.chart("u1").count("true") == 0)
    tab.click("button[name=remove_u1]")
    assert tab.locator("canvas[aria-label^=u1]").count() == 0
    tab.click("button[name=keep]")
    tab.click("button[name^=drop_]")
    tab.wait_for_selector("button[name^=drop_]", state="detached")
    tab.select_option("select[name=compare]", "reference")
    tab.click("button[name=drop_reference]")
    for sheet in ("Traces", "Parameters"):
        mouse.open(sheet)
        follow = tab.locator("button[name=follow]:visible")
        follow.click()
        assert follow.get_attribute("aria-pressed") == "false"
        for steps in ("200", "2000", "0", "600"):
            tab.select_option("select[name=window]:visible", steps)
            assert follow.get_attribute("aria-pressed") == "true"


def use_callbacks(mouse, editor):
    tab = mouse.tab
    mouse.choose("Tracking", "Mine")
    mouse.open("Callbacks")
    switch = tab.get_by_role("switch", name="Animate")
    for is_on in (True, False):
        switch.click()
        wait_for(lambda wanted=is_on: mouse.view.driver.animates == wanted)
    sources = tab.locator(".robsim-slot button[name^=source_]:visible")
    assert sources.count() >= 7
    for source in sources.all():
        source.click()
        tab.locator(".robsim-source li").first.wait_for()
        tab.click(".robsim-source button[name=copy]")
        tab.click("button[name=close_source]")
    for edit in tab.locator(".robsim-slot button[name^=edit_]:visible").all():
        edit.click()
        slot = edit.get_attribute("name").removeprefix("edit_")
        place = f"{__file__}:{globals()[slot].__code__.co_firstlineno}"
        wait_for(lambda place=place: editor.exists() and place in editor.read_text())


def use_inspector_and_result(mouse):
    tab = mouse.tab
    mouse.open("Scenario")
    mouse.open("Inspector")
    for name in ("estimate", "pose"):  # the robot may be hidden in this step
        tab.locator(".robsim-tree").get_by_text(name, exact=True).click()
    assert tab.inner_text(".robsim-inspector-path") == "step.estimate.pose"
    tab.click(".robsim-inspector button[name=copy]")
    mouse.open("Estimate")
    tab.click("button[name=finish_result]")
    tab.locator(".robsim-result tbody tr").first.wait_for()
    assert tab.locator(".robsim-result tbody tr").count() == 15
    mouse.open("Traces")
    mouse.press("finish")  # nothing new: it shows what there is
    tab.locator(".robsim-result table").wait_for()


def use_title(mouse):
    tab = mouse.tab
    main = tab.locator("main")
    for name, theme in (("auto", "light"), ("light", "dark"), ("dark", "light")):
        tab.click(f".robsim-title-looks [name={name}]")
        assert main.get_attribute("data-theme") == theme
    tab.click("button[name=palette]")
    assert main.get_attribute("data-palette") == "distinct"
    tab.click("button[name=palette]")
    tab.click("button[name=keys]")
    assert tab.get_by_role("dialog", name="Keys").is_visible()
    tab.click(".robsim-keys button[name=close]")
    tab.click("button[name=share]")
    dialog = tab.get_by_role("dialog", name="Share")
    assert dialog.locator("a[download]").first.get_attribute("download").startswith("run.")
    dialog.locator("button[name=close]").click()
    assert dialog.is_hidden()
    assert tab.get_by_role("dialog", name="Keys").is_hidden()


def use_tools(mouse):
    tab = mouse.tab
    for button, name in (("define_robot", "robots"), ("train_colors", "colors")):
        tab.click(f"button[name={button}]")
        tab.wait_for_selector(".robsim-tool")
        assert told(mouse, "tool") == name
        tab.click("button[name=discard_tool]")
        tab.wait_for_selector(".robsim-tool", state="detached")


def test_every_control_does_something_and_none_is_left_out(mouse, editor):
    use_settings(mouse)
    use_transport(mouse)
    use_charts(mouse)
    mouse.open("Traces")
    use_picture(mouse)
    use_callbacks(mouse, editor)
    use_inspector_and_result(mouse)
    use_title(mouse)
    use_tools(mouse)
    # An error, notes and motors are not there. Only code of files has Edit. Options: their test.
    elsewhere = ".robsim-scenario, .robsim-error, .robsim-slot-error, .robsim-toasts, [name=stop]"
    elsewhere += ", [name=home], .robsim-challenge *, [name=check]"
    elsewhere += ", [name^=make_mine]"  # which writes files: test_callbacks_part
    assert mouse.tab.evaluate(_LEFT_OUT, f"{elsewhere}, [name^=edit_][hidden]") == []


def test_the_picture_fits_the_window_also_while_frames_come(open_panel):
    sim = robsim.Simulation(control=robsim.DriveAround(), seed=1)
    view, tab = open_panel(sim, speed=5.0)
    Mouse(view, tab).press("start")
    (link,) = view.links
    wait_for(lambda: link.sent > 10)
    wide = link.width
    tab.set_viewport_size({"width": 900, "height": 500})
    wait_for(lambda: link.width < wide)
    tab.evaluate("document.querySelector('.robsim-camera').style.display = 'none'")
    sent = link.sent
    wait_for(lambda: link.sent > sent + 20)
    assert link.width > 1


def test_stop_stops_the_motors_while_a_callback_hangs(open_panel):
    sent, inside, may_go_on = [], threading.Event(), threading.Event()

    def control(step):
        inside.set()
        may_go_on.wait(300)
        return 1, 2

    runner = experiment(frames(10**6), send=lambda u: sent.append(tuple(u)), control=control)
    view, tab = open_panel(runner)
    for stop in (lambda: tab.keyboard.press("Escape"), lambda: tab.click("button[name=stop]")):
        may_go_on.set()
        tab.click("button[name=step]")
        wait_for(lambda: sent[-1:] == [(1, 2)])
        may_go_on.clear()
        inside.clear()
        tab.click(".robsim-transport [name=start]")
        assert inside.wait(300)
        tab.wait_for_selector("main[data-state=running]")
        sent.clear()
        stop()
        wait_for(lambda: (0, 0) in sent)
        may_go_on.set()
        tab.locator(".robsim-title-state").get_by_text("Stopped").wait_for()
        assert view.driver.is_stopped


#: As the manual of 2008 prints them.
TRUE_VALUES = {
    **{"a1X": 1.9375, "a2X": -0.9375, "b1X": 0.20833, "b2X": 0.20833, "d1X": 8.3333e-6},
    **{"a1Y": 1.9375, "a2Y": -0.9375, "b1Y": 0.20833, "b2Y": 0.20833, "d1Y": 8.3333e-6},
    **{"a1P": 1.8333, "a2P": -0.83333, "b1P": 0.030556, "b2P": -0.030556, "d1P": 0},
}


def parameters_shown(mouse):
    """Return what is read off at the newest step in each of the 15 charts."""
    charts = {name: mouse.chart(name) for name in PARAMETER_NAMES}
    assert charts["a1X"].count("true") > 8  # the crosses
    assert charts["a1X"].count("estimated") > 20
    return {name: number(chart.read(0.995)[1]["estimate"]) for name, chart in charts.items()}


def not_excited(verdict):
    """Return how many parameters are said not to be excited."""
    found = re.search(r"(\d+) not excited", verdict.inner_text())
    return int(found[1]) if found else 0


def test_the_online_estimate_needs_a_robot_that_drives(open_panel):
    """Figures 2.3 and 2.4 of the manual of 2008."""
    mouse = Mouse(*open_panel(robsim.Simulation(robot="lab", seed=1), speed=100.0))
    mouse.choose("Parameter estimation", "Default")
    mouse.open("Parameters")
    mouse.run(100)
    verdict = mouse.tab.locator(".robsim-verdict")
    wait_for(lambda: not_excited(verdict) >= 9)  # all of x and y but the decay
    spinning = parameters_shown(mouse)
    far = [name for name, true in TRUE_VALUES.items() if abs(spinning[name] - true) > 0.01]
    assert len(far) >= 8
    mouse.tab.get_by_label("Robot drives").select_option("drive-around")
    mouse.run(300)
    wait_for(lambda: not_excited(verdict) == 0)
    for name, value in parameters_shown(mouse).items():
        assert value == pytest.approx(TRUE_VALUES[name], abs=2e-3), name
