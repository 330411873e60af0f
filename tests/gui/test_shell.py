"""The panel around the picture and the charts, with a fake host in Python's place."""

import numpy as np
import pytest

pytestmark = pytest.mark.slow


def choice(name, value, *values, **disabled):
    choices = [{"value": v, "disabled": disabled.get(v)} for v in values]
    card = "stages" if name == "tracking" else "world"
    return {"name": name, "kind": "choice", "card": card, "value": value, "choices": choices}


def span(name, value, low, high, step, unit):
    limits = {"low": low, "high": high, "step": step, "unit": unit}
    card = "drive" if name == "speed" else "world"
    return {"name": name, "kind": "range", "card": card, "value": value, **limits}


CONTROLS = [
    choice("tracking", "default", "off", "default", "mine", mine="No callback of yours fills it"),
    choice("noise", "gaussian", "none", "uniform", "gaussian"),
    span("noise_level", 20, 0, 60, 1, "%"),
    span("dropout", 0, 0, 1, 0.01, ""),
    choice("disturbance", "none", "none", "pose", "wheels"),
    span("disturbance_level", 0.2, 0, 1, 0.02, "px"),
    span("speed", 5, 0.2, 100, 0.1, "x"),
]
VALUES = {control["name"]: control["value"] for control in CONTROLS}
ERROR = {
    "slot": "measure",
    "k": 3,
    "text": "ZeroDivisionError: division by zero",
    "file": "/home/ada/robot/measurement.py",
    "line": 17,
    "code": "    heading = dy / dx\n",
    "traceback": "Traceback (most recent call last): ...",
}


@pytest.fixture
def shell(open_fake):
    """Return a function that opens a panel which Python has told something."""

    def opened(*, setup=None, state=None, **options):
        host = open_fake(**options)
        host.setup(**{"controls": CONTROLS, **(setup or {})})
        host.state(**{"values": VALUES, **(state or {})})
        host.forget()
        return host

    return opened


def pressed(host):
    return [message["button"] for message in host.sent("press")]


def box(host, selector):
    return host.tab.locator(selector).bounding_box()


# Layout.


def test_all_of_the_page_is_seen_in_a_small_window(shell):
    host = shell(size=(800, 600), setup={"motors": True})
    view, right = box(host, ".robsim-view"), box(host, ".robsim-right")
    assert right["x"] > view["x"] + view["width"]
    for name in ("start", "step", "step_stage", "reset", "finish", "stop"):
        button = box(host, f".robsim-transport [name={name}]")
        assert button["x"] + button["width"] <= view["x"] + view["width"] + 1
        assert button["y"] + button["height"] < 600
    tabs = host.tab.locator(".robsim-tabs")
    assert tabs.evaluate("one => one.scrollWidth <= one.clientWidth")


def test_nothing_jumps(shell):
    host = shell()
    places = (".robsim-view", "[name=step]", ".robsim-timeline input", ".robsim-controls")
    before = [box(host, place) for place in places]
    host.state(values=VALUES, state="running", k=0, steps=1)
    host.frame(9999)
    host.state(values=VALUES, state="failed", k=9999, steps=10000, error=ERROR)
    host.emit({"type": "note", "level": "error", "text": "no"})
    host.rest()
    assert [box(host, place) for place in places] == before


# Time line.


def test_the_time_line_counts_a_failed_step_as_the_header_does(shell):
    host = shell()
    host.frame(145)
    host.state(state="paused", k=144, steps=145)
    host.rest()
    assert host.tab.locator(".robsim-title-step").inner_text() == "step 145"
    assert host.tab.locator(".robsim-timeline-place").inner_text() == "145 / 145"


def test_the_time_line_shows_past_steps_and_the_newest_again(shell):
    host = shell()
    host.frame(99)
    host.rest()
    step = host.tab.locator(".robsim-title-step")
    slider = host.tab.locator(".robsim-timeline input")
    slider.fill("40")
    host.paint()
    assert host.sent("look") == [{"type": "look", "k": 40}]
    host.frame(40, past=True)
    host.rows({"pose_measured": np.ones((101, 3))})  # the run goes on: what is looked at stays
    host.rest()
    assert step.inner_text() == "step 40"
    assert slider.get_attribute("max") == "100"
    slider.press("ArrowLeft")
    host.paint()
    host.tab.click(".robsim-timeline [name=newest]")
    host.frame(100)
    host.tab.keyboard.press("ArrowLeft")
    host.tab.click("[name=step]")  # to move on goes back to the newest, too
    assert [message["k"] for message in host.sent("look")[1:]] == [39, None, 99, None]
    host.frame(101)
    host.rest()
    assert step.inner_text() == "step 101"
    assert slider.input_value() == "101"


# Settings.


def test_a_control_shows_the_value_and_the_limits_of_python(shell):
    host = shell()
    tab = host.tab
    tab.get_by_label("Noise level").focus()
    host.state(values={**VALUES, "tracking": "off", "dropout": 0.25, "speed": 0.2})
    stage = tab.get_by_role("radiogroup", name="Tracking").get_by_role("radio", name="Off")
    assert stage.get_attribute("aria-checked") == "true"
    assert tab.get_by_label("Dropout").get_attribute("aria-valuetext") == "0.25"
    assert tab.get_by_label("Speed").input_value() == "0"
    wide = span("disturbance_level", 0.1, 0, 0.5, 0.01, "V")
    host.setup(controls=[wide if c["name"] == "disturbance_level" else c for c in CONTROLS])
    level = tab.get_by_label("Level of the disturbance")
    assert level.get_attribute("max") == "0.5"
    assert level.get_attribute("aria-valuetext") == "0.10\u202fV"
    assert tab.evaluate("document.activeElement.name") == "noise_level"  # the others stay


def test_what_is_not_possible_says_why(shell):
    host = shell()
    mine = host.tab.get_by_role("radiogroup", name="Tracking").get_by_text("Mine")
    mine.click(force=True)  # it is marked as disabled, but a finger has no tooltip
    host.paint()
    assert host.sent("set") == []
    assert host.tab.locator(".robsim-toast").inner_text() == "No callback of yours fills it"
    noise, disturbance = (
        host.tab.get_by_label(name) for name in ("Noise level", "Level of the disturbance")
    )
    assert (noise.is_enabled(), disturbance.is_enabled()) == (True, False)
    assert host.tab.locator(".robsim-field", has=disturbance).get_attribute("title")
    host.state(values={**VALUES, "noise": "none", "disturbance": "pose"})
    assert (noise.is_enabled(), disturbance.is_enabled()) == (False, True)


def test_a_live_camera_has_its_numbers_in_the_place_of_the_speed(shell):
    controls = [control for control in CONTROLS if control["name"] != "speed"]
    host = shell(setup={"live": True, "source": "experiment", "controls": controls})
    assert host.tab.get_by_label("Speed").count() == 0
    rate = host.tab.locator(".robsim-field", has_text="Camera").locator(".robsim-number")
    for camera, words in (
        ({"rate": None, "age": None, "dropped": 0}, ["\u2013 fps", "0 dropped", ""]),
        ({"rate": 29.96, "age": 0.031, "dropped": 2}, ["30.0 fps", "2 dropped", "31 ms old"]),
        ({"rate": 0.0, "age": 12.4, "dropped": 2}, ["0.0 fps", "2 dropped", "no frame for 12 s"]),
    ):
        host.state(values=VALUES, state="running", camera=camera)
        assert rate.locator("span").all_inner_texts() == words
    assert "robsim-hangs" in rate.get_attribute("class")


def test_an_older_state_does_not_move_what_is_being_dragged(shell):
    host = shell()
    slider = host.tab.get_by_label("Noise level")
    track = slider.bounding_box()
    y = track["y"] + track["height"] / 2
    host.stop_clock()  # Python has a second to answer
    host.tab.mouse.move(track["x"] + track["width"] / 3, y)
    host.tab.mouse.down()
    host.tab.mouse.move(track["x"] + track["width"] - 1, y)
    host.state(values=VALUES)
    assert slider.input_value() == "60"
    host.tab.mouse.up()
    host.state(values=VALUES)  # still on its way when it was let go
    assert slider.input_value() == "60"
    host.state(values={**VALUES, "noise_level": 60})
    host.state(values={**VALUES, "noise_level": 10})  # somebody else's
    assert slider.input_value() == "10"
    assert host.sent("set")[-1]["value"] == 60


# Errors and notes.


def test_an_error_appears_over_the_picture_with_its_line(shell):
    host = shell()
    host.frame(3)
    host.emit({"type": "callbacks", "slots": [{"slot": "measure", "can_edit": True}]})
    host.state(values=VALUES, state="failed", k=3, steps=4, error=ERROR)
    error = host.tab.get_by_role("alert").filter(has_text="measure failed in step 3")
    for words in ("division by zero", "measurement.py:17", "heading = dy / dx"):
        assert words in error.inner_text()
    host.tab.click(".robsim-error [name=edit]")
    host.tab.click(".robsim-error [name=to_callbacks]")
    host.tab.click(".robsim-error [name=go_on]")
    assert host.sent("edit") == [{"type": "edit", "slot": "measure"}]
    assert pressed(host) == ["start"]
    assert host.tab.get_by_role("tab", name="Callbacks").get_attribute("aria-selected") == "true"
    host.state(values=VALUES, state="running", k=4, steps=5)
    assert error.count() == 0


def test_notes_are_said_once_and_remarks_stand_where_they_belong(shell):
    host = shell()
    for text in ("one", "one", "two"):
        host.emit({"type": "note", "level": "warning", "text": text})
    notes = host.tab.locator(".robsim-toast")
    assert notes.all_inner_texts() == ["one", "two"]
    notes.first.get_by_role("button", name="Close").click()
    assert notes.all_inner_texts() == ["two"]
    host.frame(9)
    host.tab.keyboard.press("ArrowLeft")
    host.frame(8, past=True)
    host.emit({"type": "past", "k": 8, "reason": "the frames are not kept"})
    remark = host.tab.locator(".robsim-remark")
    assert "the frames are not kept" in remark.inner_text()
    host.frame(7, past=True)
    assert remark.is_hidden()


# Tabs and keys.


def test_a_new_result_takes_the_tab(shell):
    host = shell()
    shown = (
        "[...document.querySelectorAll('[role=tabpanel]')]"
        ".filter((e) => !e.hidden).map((e) => e.className)"
    )
    host.tab.get_by_role("tab", name="Parameters").click()
    host.tab.keyboard.press("ArrowRight")
    result = {"type": "result", "rows": [], "text": "", "verdict": ""}
    host.emit({**result, "again": True})  # from before
    assert host.tab.evaluate(shown) == ["robsim-callbacks"]
    host.emit({**result, "again": False}, [b""])
    assert host.tab.evaluate(shown) == ["robsim-result"]


def test_keys_of_the_page(shell):
    host = shell()
    host.frame(9)
    for key in (" ", ".", "ArrowRight", "s", "Escape"):  # a simulation has nothing to stop
        host.tab.keyboard.press(key)
    host.tab.click("[name=step]")
    host.tab.keyboard.press(" ")  # after a click it is the page's, after Tab the button's
    host.tab.locator("[name=step_stage]").focus()
    host.tab.keyboard.press(" ")
    expected = ["start", "step", "step", "step_stage", "step", "start", "step_stage"]
    assert pressed(host) == expected
    for role, name in (("radio", "Gaussian"), ("tab", "Callbacks")):
        host.tab.get_by_role(role, name=name).click()
        host.state(values={**VALUES, "noise": "gaussian"})
        host.forget()
        host.tab.keyboard.press(" ")
        host.tab.keyboard.press(".")
        assert pressed(host) == ["start", "step"], role


def test_in_a_notebook_keys_are_the_panels_only_under_the_pointer(shell):
    host = shell(body="")
    host.tab.evaluate("document.body.append(document.createElement('textarea'))")
    host.tab.mouse.move(1, 1)
    host.tab.evaluate("document.querySelector('main').style.marginTop = '60px'")
    host.tab.keyboard.press(".")
    assert pressed(host) == []
    view = box(host, ".robsim-view")
    host.tab.mouse.move(view["x"] + 5, view["y"] + 5)
    host.tab.keyboard.press(".")
    host.tab.locator("textarea").focus()
    host.tab.keyboard.type(". s")
    assert pressed(host) == ["step"]
    assert host.tab.locator("textarea").input_value() == ". s"


# Looks.


def test_the_theme_is_the_notebooks(shell):
    host = shell(body="", theme="light")
    host.tab.evaluate("document.documentElement.setAttribute('theme', 'light')")
    main = host.tab.locator("main")
    for name, dark, light in (
        ("documentElement.attributes.theme.value", "dark", ""),  # Colab
        ("body.dataset.vscodeThemeKind", "vscode-dark", "vscode-light"),
        ("body.dataset.jpThemeLight", "false", "true"),  # JupyterLab
    ):
        for value, theme in ((dark, "dark"), (light, "light")):
            host.tab.evaluate(f"document.{name} = '{value}'")
            host.paint()
            assert main.get_attribute("data-theme") == theme, name


def test_the_page_keeps_theme_colours_and_tab(shell):
    host = shell(theme="dark")
    host.tab.click(".robsim-title-looks [name=auto]")
    host.tab.click(".robsim-title-looks [name=palette]")
    host.tab.get_by_role("tab", name="Inspector").click()
    host.load()
    main = host.tab.locator("main")
    assert main.get_attribute("data-theme") == "light"
    assert main.get_attribute("data-palette") == "distinct"
    assert host.tab.get_by_role("tab", name="Inspector").get_attribute("aria-selected") == "true"


def test_every_control_has_a_name_and_a_view_that_ends_leaves_nothing_behind(shell):
    host = shell(setup={"motors": True}, state={"k": 5, "steps": 6})
    nameless = host.tab.evaluate(
        """[...document.querySelectorAll("button, select, input, [role=radiogroup]")]
          .filter((e) => e.checkVisibility())
          .filter((e) => !(e.ariaLabel || (e.labels?.[0] ?? e).textContent.trim()))
          .map((e) => e.outerHTML)"""
    )
    assert nameless == []
    host.tab.evaluate("host.end()")
    host.forget()
    host.tab.keyboard.press("Escape")
    host.tab.keyboard.press(" ")
    assert host.sent() == []


# Odd moments: while it runs, after a reload, a reset.


def disabled(host):
    buttons = host.tab.locator(".robsim-transport button >> visible=true").all()
    return {one.get_attribute("name") for one in buttons if one.is_disabled()}


def test_what_cannot_be_done_cannot_be_pressed(open_fake):
    host = open_fake()
    host.setup()
    host.state()
    assert disabled(host) == {"reset", "finish"}
    host.state(state="running")  # told before its first step
    assert disabled(host) == set()
    host.state(state="failed")  # in the first step
    assert disabled(host) == {"finish"}
    host.state(state="ended", k=9, steps=10)
    assert disabled(host) == {"start", "step", "step_stage"}
    host.state(state="closed", k=9, steps=10)
    assert disabled(host) == {"start", "step", "step_stage", "reset", "finish"}


def test_who_looks_back_while_nothing_runs_grants_room_too(open_fake):
    host = open_fake()
    host.setup()
    host.tab.evaluate("performance.now = () => 0; Date.now = () => 0")
    host.state(k=99, steps=100)
    host.tab.evaluate("performance.now = () => 6000")
    host.forget()
    for k in range(40, 34, -1):  # the room is for 8
        host.frame(k, past=True)
    assert host.sent("grant") == [{"type": "grant", "upto": 6 + 8, "late": False}]


@pytest.mark.parametrize(("sent", "room"), [(1000, 120), (-1000, 30)])
def test_room_is_for_less_on_a_line_that_fills(open_fake, sent, room):
    host = open_fake()
    host.setup()
    host.tab.evaluate("Date.now = () => 1000")
    host.tab.evaluate("performance.now = () => 0")
    host.frame(0, sent=1000)
    host.state(k=0, steps=1)
    host.tab.evaluate("performance.now = () => 200")  # 6 frames in 0.2 s: 30 a second
    host.forget()
    for k in range(1, 20):
        host.frame(k, sent=sent)
    assert host.sent("grant") == [{"type": "grant", "upto": 7 + room, "late": False}]


DRAWN = """
(at) => { // something other than the gray picture, in a column of it
  const canvas = document.querySelector(".robsim-camera canvas");
  const side = Math.min(canvas.width, canvas.height);
  const x = (canvas.width - side) / 2 + (at / 600) * side;
  const { data } = canvas.getContext("2d").getImageData(x - 4, canvas.height / 2, 8, 40);
  return data.some((value, i) => i % 4 < 3 && Math.abs(value - 190) > 20);
}
"""


def test_a_run_as_long_as_the_one_before_has_a_trail_of_its_own(open_fake):
    host = open_fake()
    host.setup(columns=[{"name": "pose_measured", "fields": ["x"] * 3, "units": [""] * 3}])
    before, after = ([[x, y, 0] for y in range(20, 580, 14)] for x in (150, 450))

    def drawn():
        host.rest(150)
        return [host.tab.evaluate(DRAWN, x) for x in (150, 450)]

    host.state(k=39, steps=40)
    host.frame(39, rows={"pose_measured": before})
    assert drawn() == [True, False]
    host.state(k=39, steps=40, resets=1)
    host.frame(39, rows={"pose_measured": after})
    assert drawn() == [False, True]


def test_a_reset_lets_the_charts_follow_and_ends_a_look_at_the_past(open_fake):
    host = open_fake()
    host.setup(columns=[{"name": "pose_true", "fields": ["x"] * 3, "units": [""] * 3}])
    host.state(k=299, steps=300)
    host.frame(299, rows={"pose_true": [[k, k, 0] for k in range(300)]})
    host.tab.keyboard.press("ArrowLeft")
    follow = host.tab.locator(".robsim-traces button[name=follow]")
    assert follow.get_attribute("aria-pressed") == "false"
    host.forget()
    host.state(k=349, steps=350, resets=1)
    assert host.sent("look") == [{"type": "look", "k": None}]
    assert follow.get_attribute("aria-pressed") == "true"
