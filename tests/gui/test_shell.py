"""The panel around the picture and the charts, with a fake host in Python's place."""

import json

import numpy as np
import pytest

from fake_host import STATE

pytestmark = pytest.mark.slow


def choice(name, value, *values, **disabled):
    choices = [{"value": v, "disabled": disabled.get(v)} for v in values]
    return {"name": name, "kind": "choice", "value": value, "choices": choices}


def span(name, value, low, high, step, unit):
    limits = {"low": low, "high": high, "step": step, "unit": unit}
    return {"name": name, "kind": "range", "value": value, **limits}


STAGES = ("off", "default", "mine")
DRIVES = ("spin", "drive-around", "chirp", "mine")
CONTROLS = [
    choice("tracking", "default", *STAGES, mine="No callback of yours fills it"),
    choice("parameters", "off", *STAGES),
    choice("state", "off", *STAGES),
    choice("control", "spin", *DRIVES),
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


def stays(host, *selectors):
    return [box(host, selector) for selector in selectors]


def rows_with_gaps(count, *gaps):
    rows = np.ones((count, 3))
    for first, last in gaps:
        rows[first:last] = np.nan
    return rows


# Layout.


@pytest.mark.parametrize("size", [(1440, 900), (800, 600)])
def test_the_page_fills_the_window_and_all_of_it_is_seen(shell, size):
    host = shell(size=size, setup={"motors": True})
    page = host.tab.evaluate(
        "(({scrollHeight, scrollWidth}) => [scrollWidth, scrollHeight])(document.documentElement)"
    )
    assert tuple(page) == size
    panel = box(host, ".robsim-panel")
    assert (panel["width"], panel["height"]) == size
    view, right = box(host, ".robsim-view"), box(host, ".robsim-right")
    assert right["x"] > view["x"] + view["width"]
    for name in ("start", "step", "step_stage", "reset", "finish", "stop"):
        button = box(host, f".robsim-transport [name={name}]")
        assert button["x"] + button["width"] <= view["x"] + view["width"] + 1
        assert button["y"] + button["height"] < size[1]
    for width in (size[0], 700):
        host.tab.set_viewport_size({"width": width, "height": 600})
        host.paint()
        tabs = host.tab.locator(".robsim-tabs")
        assert tabs.evaluate("one => one.scrollWidth <= one.clientWidth")


def test_the_width_of_the_panel_decides_not_that_of_the_window(shell):
    host = shell(body="", size=(1440, 900))
    place = "document.querySelector('main').style.width = "
    for width, is_beside in ((1200, True), (720, True), (650, False)):
        host.tab.evaluate(f"{place}'{width}px'")
        host.paint()
        view, right = box(host, ".robsim-view"), box(host, ".robsim-right")
        assert (right["x"] > view["x"] + view["width"]) == is_beside
        assert right["x"] + right["width"] <= box(host, ".robsim-panel")["width"] + 8
        start, finish = box(host, "[name=start]"), box(host, "[name=finish]")
        assert finish["x"] + finish["width"] <= view["x"] + view["width"] + 1
        assert start["y"] == finish["y"]


def test_nothing_jumps(shell):
    host = shell()
    places = (".robsim-view", "[name=step]", ".robsim-timeline input", ".robsim-controls")
    before = stays(host, *places)
    host.state(values=VALUES, state="running", k=0, steps=1)
    host.frame(0)
    host.rest()
    assert stays(host, *places) == before
    host.frame(9999)
    host.state(values=VALUES, state="failed", k=9999, steps=10000, error=ERROR)
    host.emit({"type": "note", "level": "error", "text": "no"})
    host.rest()
    assert stays(host, *places) == before


# Transport.


def test_buttons_speak_and_what_cannot_be_done_cannot_be_pressed(shell):
    host = shell()
    tab = host.tab
    assert tab.locator("[name=finish]").is_disabled()
    assert tab.locator("[name=reset]").is_disabled()
    tab.click(".robsim-first button")
    host.state(values=VALUES, state="running", k=5, steps=6)
    assert tab.locator(".robsim-first").is_hidden()
    for name in ("pause", "step", "step_stage", "reset", "finish"):
        tab.click(f".robsim-transport [name={name}]")
    assert pressed(host) == ["start", "pause", "step", "step_stage", "reset", "finish"]
    assert tab.locator("[name=stop]").is_hidden()
    host.state(values=VALUES, state="ended", k=5, steps=6)
    assert tab.locator("[name=finish]").is_enabled()
    assert tab.locator(".robsim-transport [name=start]").is_disabled()
    assert tab.locator(".robsim-remark").is_visible()


def test_stop_is_there_for_motors_by_button_and_key(shell):
    host = shell(setup={"motors": True, "source": "experiment"})
    host.tab.click(".robsim-transport [name=stop]")
    host.tab.keyboard.press("Escape")
    assert pressed(host) == ["stop", "stop"]
    host.state(values=VALUES, stopped=True, k=3, steps=4)
    assert host.tab.locator(".robsim-title-state").inner_text() == "Stopped"
    assert host.tab.locator(".robsim-remark").is_visible()


# Time line.


def test_the_time_line_shows_past_steps_and_the_newest_again(shell):
    host = shell()
    host.frame(99)
    host.rest()
    slider = host.tab.locator(".robsim-timeline input")
    slider.fill("40")
    host.paint()
    assert host.sent("look") == [{"type": "look", "k": 40}]
    host.frame(40, past=True)
    host.rest()
    assert host.tab.locator(".robsim-title-step").inner_text() == "step 40"
    host.rows({"pose_measured": np.ones((101, 3))})  # the run goes on: what is looked at stays
    host.rest()
    assert host.tab.locator(".robsim-title-step").inner_text() == "step 40"
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
    assert host.tab.locator(".robsim-title-step").inner_text() == "step 101"
    assert slider.input_value() == "101"


def test_a_run_that_goes_on_does_not_take_the_slider_away(shell):
    host = shell()
    host.frame(99)
    host.rest()
    put = """async (value) => {
      const paints = [];
      window.requestAnimationFrame = (paint) => paints.push(paint);
      host.emit({ ...STATE, k: 100 }, []);
      await new Promise((done) => setTimeout(done, 101));  // it is to be painted anew
      const slider = document.querySelector(".robsim-timeline input");
      for (let k = 0; k < 20; k++) {
        slider.value = k;
        slider.dispatchEvent(new Event("input"));
      }
      slider.value = value;
      slider.dispatchEvent(new Event("input"));
      paints.forEach((paint) => paint());
    }""".replace("STATE", json.dumps(STATE | {"values": VALUES, "state": "running"}))
    host.tab.evaluate(put, 40)
    host.tab.evaluate(put, 100)
    assert [message["k"] for message in host.sent("look")] == [40, None]  # once a paint


def test_ticks_show_where_the_robot_was_not_seen(shell):
    host = shell()
    measured = rows_with_gaps(201, (0, 5), (50, 60), (100, 120), (150, 151))
    held = rows_with_gaps(201, (0, 5), (100, 120))  # there nothing measures
    host.frame(200, rows={"pose_measured": measured, "pose_held": held})
    host.rest()
    inked = host.tab.evaluate(
        """(() => {
          const canvas = document.querySelector(".robsim-timeline-ticks");
          const pen = canvas.getContext("2d");
          const { data } = pen.getImageData(0, 1, canvas.width, 1);
          return Array.from({ length: canvas.width }, (_, x) => data[4 * x + 3] > 0);
        })()"""
    )
    edges = np.flatnonzero(np.diff(np.array([False, *inked, False], int)))
    expected = np.array([0, 5, 50, 60, 150, 151]) / 200 * len(inked)
    assert edges == pytest.approx(expected, abs=4)


def test_a_trace_that_is_played_back_moves_the_time_line(shell):
    host = shell(setup={"source": "trace"})
    host.state(state="running", k=99, steps=100)
    host.frame(30, past=True)
    host.rest()
    assert host.tab.locator(".robsim-timeline input").input_value() == "30"
    host.state(state="ended", k=99, steps=100)
    assert host.tab.locator(".robsim-transport [name=start]").is_enabled()


# Settings.


def test_every_kind_of_control_sets_its_value_and_shows_that_of_python(shell):
    host = shell()
    tab = host.tab
    tab.get_by_role("radiogroup", name="Parameter estimation").get_by_text("Default").click()
    tab.get_by_label("Robot drives").select_option("chirp")
    tab.get_by_label("Noise level").fill("37")
    tab.get_by_label("Speed").fill("17")
    host.paint()
    assert [(m["name"], m["value"]) for m in host.sent("set")] == [
        ("parameters", "default"),
        ("control", "chirp"),
        ("noise_level", 37),
        ("speed", 0),
    ]
    assert tab.get_by_label("Speed").get_attribute("aria-valuetext") == "max"
    host.rest(1000)  # ms, in which Python may answer
    host.state(values={**VALUES, "tracking": "off", "dropout": 0.25, "speed": 0.2})
    stage = tab.get_by_role("radiogroup", name="Tracking").get_by_role("radio", name="Off")
    assert stage.get_attribute("aria-checked") == "true"
    assert tab.get_by_label("Robot drives").input_value() == "spin"
    assert tab.get_by_label("Dropout").get_attribute("aria-valuetext") == "0.25"
    assert tab.get_by_label("Speed").input_value() == "0"


def test_what_is_not_possible_says_why(shell):
    host = shell()
    mine = host.tab.get_by_role("radiogroup", name="Tracking").get_by_text("Mine")
    assert mine.get_attribute("aria-description") == "No callback of yours fills it"
    mine.click(force=True)  # it is marked as disabled, but a finger has no tooltip
    host.paint()
    assert host.sent("set") == []
    assert host.tab.locator(".robsim-toast").inner_text() == "No callback of yours fills it"
    noise, disturbance = (
        host.tab.get_by_label(name) for name in ("Noise level", "Level of the disturbance")
    )
    assert noise.is_enabled()
    assert disturbance.is_disabled()
    field = host.tab.locator(".robsim-field", has=disturbance)
    assert field.get_attribute("title")
    host.state(values={**VALUES, "noise": "none", "disturbance": "pose"})
    assert noise.is_disabled()
    assert disturbance.is_enabled()
    assert field.get_attribute("title") == ""


def test_new_limits_change_their_control_alone_and_unknown_ones_are_shown(shell):
    host = shell()
    host.tab.get_by_label("Noise level").focus()
    wide = span("disturbance_level", 0.1, 0, 0.5, 0.01, "V")
    host.setup(controls=[wide if c["name"] == "disturbance_level" else c for c in CONTROLS])
    level = host.tab.get_by_label("Level of the disturbance")
    assert level.get_attribute("max") == "0.5"
    assert level.get_attribute("aria-valuetext") == "0.10\u202fV"
    assert host.tab.evaluate("document.activeElement.name") == "noise_level"
    host.setup(controls=[*CONTROLS, {"name": "rain", "kind": "switch", "value": True}])
    rain = host.tab.get_by_role("switch", name="rain")
    assert rain.is_checked()
    rain.uncheck()
    host.paint()
    assert host.sent("set") == [{"type": "set", "name": "rain", "value": False}]


@pytest.mark.parametrize("size", [(1440, 900), (700, 900)])
def test_a_live_camera_has_its_numbers_in_the_place_of_the_speed(shell, size):
    controls = [control for control in CONTROLS if control["name"] != "speed"]
    setup = {"live": True, "source": "experiment", "controls": controls}
    host = shell(size=size, setup=setup)
    assert host.tab.get_by_label("Speed").count() == 0
    parts = (".robsim-rate", ".robsim-dropped", ".robsim-age")
    rate = host.tab.locator(".robsim-field", has_text="Camera").locator(".robsim-number")
    seen = []
    for camera, words in (
        ({"rate": None, "age": None, "dropped": 0}, ["\u2013 fps", "0 dropped", ""]),
        ({"rate": 29.96, "age": 0.031, "dropped": 2}, ["30.0 fps", "2 dropped", "31 ms old"]),
        ({"rate": 119.9, "age": 0.987, "dropped": 9999}, None),
        ({"rate": 0.0, "age": 12.4, "dropped": 2}, ["0.0 fps", "2 dropped", "none for 12 s"]),
    ):
        host.state(values=VALUES, state="running", camera=camera)
        if camera["age"] is not None:
            places = stays(host, ".robsim-card-drive", *parts)
            seen.append([(place["x"], place["y"], place["height"]) for place in places])
        numbers = host.tab.locator(".robsim-camera-rate")
        assert numbers.evaluate("one => one.scrollWidth - one.clientWidth") <= 0
        assert words in (None, rate.locator("span").all_inner_texts())
        hangs = camera["age"] is not None and camera["age"] > 1
        assert ("robsim-hangs" in rate.get_attribute("class")) == hangs
    assert seen == seen[:1] * len(seen)


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
    host.state(values=VALUES, state="failed", error={**ERROR, "k": None})  # a file with a typo
    assert host.tab.locator(".robsim-error-title strong").inner_text() == "measure failed"
    host.frame(3)
    slots = [{"slot": "measure", "can_edit": True}]
    host.emit({"type": "callbacks", "slots": slots})
    host.state(values=VALUES, state="failed", k=3, steps=4, error=ERROR)
    error = host.tab.get_by_role("alert").filter(has_text="measure failed in step 3")
    assert "division by zero" in error.inner_text()
    assert "measurement.py:17" in error.inner_text()
    assert host.tab.locator(".robsim-error-code").inner_text() == "heading = dy / dx"
    inner, outer = error.bounding_box(), box(host, ".robsim-view")
    assert inner["y"] > outer["y"]
    assert inner["y"] + inner["height"] < outer["y"] + outer["height"]
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
    host.state(values=VALUES, state="closed")
    assert "cell" not in remark.inner_text()  # of a notebook: this is a page
    lost = host.tab.locator(".robsim-lost")
    assert lost.is_hidden()
    for state, words in (("gone", "start it again"), ("lost", "Trying again")):
        host.tab.evaluate(f"document.querySelector('main').dataset.state = '{state}'")
        assert words in lost.inner_text()


# Tabs and keys.


def test_tabs_show_their_sheets_by_mouse_and_by_keys(shell):
    host = shell()
    sheets = "[...document.querySelectorAll('[role=tabpanel]')]"
    shown = f"{sheets}.filter((e) => !e.hidden).map((e) => e.className)"
    assert host.tab.evaluate(shown) == ["robsim-traces"]
    host.tab.get_by_role("tab", name="Parameters").click()
    host.tab.keyboard.press("ArrowRight")
    assert host.tab.evaluate(shown) == ["robsim-callbacks"]
    result = {"type": "result", "rows": [], "text": "", "verdict": ""}
    host.emit({**result, "again": True})  # from before: it does not take the tab
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
    assert pressed(host) == ["step"]
    host.tab.locator("textarea").focus()
    host.tab.keyboard.type(". s")
    assert pressed(host) == ["step"]
    assert host.tab.locator("textarea").input_value() == ". s"


# Looks.


def test_the_theme_is_the_notebooks(shell):
    host = shell(body="", theme="light")
    host.tab.evaluate("document.documentElement.setAttribute('theme', 'light')")
    main = host.tab.locator("main")
    assert host.tab.locator(".robsim-title-looks [name=auto]").is_hidden()
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
    main = host.tab.locator("main")
    assert main.get_attribute("data-theme") == "dark"
    host.tab.click(".robsim-title-looks [name=auto]")
    assert main.get_attribute("data-theme") == "light"
    host.tab.click(".robsim-title-looks [name=palette]")
    host.tab.get_by_role("tab", name="Inspector").click()
    host.load()
    assert main.get_attribute("data-theme") == "light"
    assert main.get_attribute("data-palette") == "distinct"
    assert host.tab.get_by_role("tab", name="Inspector").get_attribute("aria-selected") == "true"


def test_every_control_has_a_name_and_fingers_find_room(shell):
    touch = {"has_touch": True, "is_mobile": True, "size": (900, 700)}
    host = shell(**touch, setup={"motors": True}, state={"k": 5, "steps": 6})
    small, nameless = host.tab.evaluate(
        """(() => {
          const all = [...document.querySelectorAll("button, select, input, [role=radiogroup]")]
            .filter((e) => e.checkVisibility());
          const text = (e) => e.ariaLabel || (e.labels?.[0] ?? e).textContent.trim();
          return [all.filter((e) => e.role != "radio")
            .map((e) => [e.name || e.className, (e.labels?.[0] ?? e).getBoundingClientRect()])
            .filter(([, { width, height }]) => width < 36 || height < 36)
            .map(([name]) => name), all.filter((e) => !text(e)).map((e) => e.outerHTML)];
        })()"""
    )
    assert (small, nameless) == ([], [])
    host.tab.evaluate("host.end()")  # a view that ends leaves nothing behind
    host.forget()
    host.tab.keyboard.press("Escape")
    host.tab.keyboard.press(" ")
    assert host.sent() == []
