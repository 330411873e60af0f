"""Callbacks that hang, a silent Python, and the end of a panel."""

import math
import threading
import time

import pytest

import robsim
from browsers import FakeBrowser, PanelView, Watcher, panel_of
from small_runs import SOON, simulation
from waiting import wait_for

pytestmark = pytest.mark.threads


# --- a callback that does not end


class Hanging:
    """A controller that hangs in step 2, as long as it is to."""

    def __init__(self, hang):
        self.hang, self.may_go_on = hang, threading.Event()
        self.is_there = threading.Event()

    def __call__(self, step):
        if step.k == 2 and not self.may_go_on.is_set():
            self.is_there.set()
            self.hang(self.may_go_on)
        return 0.1, 0.1


def loops(may_go_on):
    while not may_go_on.is_set():
        pass


def waits(may_go_on):
    may_go_on.wait(SOON)


def is_debugged(may_go_on):
    exec(  # as the frames of a debugger that waits
        "def interaction(event): event.wait()", names := {"__name__": "pdb"}
    )
    names["interaction"](may_go_on)


@pytest.fixture
def hang(clock):
    """Return a function that opens a panel, and runs it into a callback that hangs."""
    opened = []

    def open_it(how, **options):
        control = Hanging(how)
        view = PanelView(simulation(control=control, **options), speed=math.inf)
        opened.append((view, control))
        here = Watcher(view)
        here.say("press", button="start")
        assert control.is_there.wait(SOON)
        return view, here, control

    yield open_it
    for view, control in opened:
        control.may_go_on.set()
        assert view.close(SOON)


def stuck(here, clock, after, **fields):
    """Let time pass, and wait until the page shows the callback so."""
    clock.advance(here.view, after)

    def is_shown():
        clock.advance(here.view, 0.0)
        told = here.newest("state")["stuck"]
        return told and fields.items() <= told.items() and told

    wait_for(is_shown)
    return here.newest("state")["stuck"]


def test_it_is_told_after_2_s_with_its_line_and_ended_when_asked(hang, clock):
    view, here, _ = hang(loops)
    clock.advance(view, 1.9)
    assert here.newest("state")["stuck"] is None
    told = stuck(here, clock, 0.2, how="runs", slot="control", seconds=2, limit=30.0)
    assert told["file"] == __file__
    assert told["code"] in ("while not may_go_on.is_set():", "pass")
    here.say("press", button="end")
    wait_for(lambda: view.driver.state == "failed")
    assert "button" in str(view.driver.error)
    wait_for(lambda: here.newest("state")["stuck"] is None)
    assert here.newest("state")["error"]["slot"] == "control"
    here.say("press", button="reset")
    wait_for(lambda: view.driver.state == "paused" and view.runner.n_steps == 0)


def test_a_message_of_a_program_ends_it_too(hang, clock):
    view, here, _ = hang(loops)
    stuck(here, clock, 3, how="runs")
    panel = object.__new__(robsim.gui.Panel)
    panel._view = view
    assert panel.message("press", button="end") == []
    wait_for(lambda: view.driver.state == "failed")


def test_it_ends_by_itself_after_30_s_or_at_the_limit_of_the_run(hang, clock):
    for options, limit in (({}, 30.0), ({"time_limit": 5.0}, 5.0)):
        view, here, _ = hang(loops, **options)
        stuck(here, clock, limit - 1, how="runs", limit=limit)
        assert view.driver.state == "running"
        clock.advance(view, 1.5)
        wait_for(lambda view=view: view.driver.state == "failed")
        assert isinstance(view.driver.error, TimeoutError)


@pytest.mark.parametrize("button", ["pause", "reset"])
def test_pause_and_reset_end_it_after_a_while(hang, clock, button):
    view, here, _ = hang(loops)
    stuck(here, clock, 3, how="runs")
    here.say("press", button=button)
    clock.advance(view, 1.0)
    assert here.newest("state")["stuck"]["how"] == "runs"
    clock.advance(view, 2.1)
    wait_for(lambda: view.driver.state == {"pause": "failed", "reset": "paused"}[button])


def test_one_that_cannot_be_ended_is_said_as_such_and_no_method_hangs(hang, clock):
    view, here, control = hang(waits)
    stuck(here, clock, 31, how="ends")
    stuck(here, clock, 3, how="native")
    panel = object.__new__(robsim.gui.Panel)
    panel._view = view
    for method in (panel.pause, panel.reset, panel.step):
        with pytest.raises(TimeoutError, match="control has not ended for 34 s"):
            method()
    control.may_go_on.set()
    wait_for(lambda: view.driver.state == "paused")


def test_nothing_is_ended_while_a_debugger_waits(hang, clock):
    view, here, control = hang(is_debugged)
    stuck(here, clock, 100, how="debugged")
    here.say("press", button="end")
    time.sleep(0.2)  # the watchdog looks every 0.05 s
    stuck(here, clock, 29, how="debugged")
    control.may_go_on.set()
    wait_for(lambda: view.runner.n_steps > 3)
    assert view.driver.error is None


def test_a_file_that_is_mended_ends_it_and_the_run_goes_on(folder, clock):
    file = folder / "control.py"
    file.write_text("def control(step):\n    while step.k == 2:\n        pass\n    return 0, 0\n")
    view = PanelView(robsim.Simulation.from_folder(folder), speed=math.inf)
    here = Watcher(view)
    here.say("press", button="start")
    wait_for(lambda: view.runner.n_steps == 2)
    stuck(here, clock, 3, how="runs", file=str(file))
    file.write_text("def control(step):\n    return 0, 0\n")
    wait_for(lambda: clock.advance(view, 0.5) or view.runner.n_steps > 5)
    assert view.driver.state == "running"
    assert view.close(SOON)


def test_a_call_of_another_area_is_told_and_ended(clock):
    control = Hanging(loops)
    view = PanelView(simulation(control=control), speed=math.inf)
    here = Watcher(view)
    here.say("set_option", name="area", value=[320, 240])
    wait_for(lambda: view.runner.scenario.area == (320, 240))
    here.say("press", button="start")
    assert control.is_there.wait(SOON)
    stuck(here, clock, 3, how="runs", slot="control")
    here.say("press", button="end")
    wait_for(lambda: view.driver.state == "failed")
    assert view.close(SOON)


def test_the_button_ends_no_later_call_than_the_one_that_was_told(clock):
    there, may_go_on = ([threading.Event() for _ in range(2)] for _ in range(2))

    def control(step):
        if step.k < 2:
            there[step.k].set()
            loops(may_go_on[step.k])
        return 0.1, 0.1

    view = PanelView(simulation(control=control), speed=math.inf)
    here = Watcher(view)
    here.say("press", button="start")
    assert there[0].wait(SOON)
    stuck(here, clock, 3, how="runs")
    view.stuck.look = lambda now: now + 1  # it has not looked again
    may_go_on[0].set()
    assert there[1].wait(SOON)
    here.say("press", button="end")
    time.sleep(0.2)  # the watchdog looks every 0.05 s
    may_go_on[1].set()
    wait_for(lambda: view.runner.n_steps > 3)
    assert view.driver.error is None
    assert view.close(SOON)


def test_the_limit_goes_with_the_panel():
    sim = simulation()
    with panel_of(sim):
        assert sim._time_limit.seconds == 30
    assert sim._time_limit is None


# --- a sign of life


def test_python_says_something_every_2_s_while_somebody_looks(clock):
    with panel_of(simulation()) as (view, browser):
        browser.take("frame")
        clock.advance(view, 1.9)
        assert not browser.all_of("alive")
        for _ in range(3):
            clock.advance(view, 2.1)
            browser.take("alive")
        browser.say("bye")
        clock.advance(view, 10)
        assert not browser.all_of("alive")


# --- the end


def test_the_last_state_goes_out_with_the_close():
    view = PanelView(simulation(measure=True))
    browser = FakeBrowser(view, room=0)
    browser.say("columns", names=["pose_true"])
    browser.take("frame")
    for _ in range(6):
        view.driver.step().result(SOON)
    view.close(SOON)
    heads = {}
    rows = {}
    for head, _ in browser._told:
        heads[head["type"]] = head
        rows |= {entry["column"]: entry for entry in head.get("rows", ())}
    assert (heads["state"]["state"], heads["state"]["k"]) == ("closed", 5)
    assert heads["frame"]["k"] == 5
    assert browser._told[-1][0] == {"type": "closed"}
    assert "pose_true" in rows


@pytest.mark.parametrize("steps", [0, 3])
def test_who_comes_late_gets_the_last_state_without_the_run(steps):
    view = PanelView(simulation(measure=True))
    early = FakeBrowser(view)
    early.take("frame")
    for _ in range(steps):
        view.driver.step().result(SOON)
    view.close(SOON)
    late = FakeBrowser(view)
    assert late.take("setup")[0]["title"]
    assert late.take("state")[0]["state"] == "closed"
    head, (picture, *_) = late.take("frame")
    assert head["k"] == max(0, steps - 1)
    assert picture
    late.take("closed")
    late.say("press", button="start")
    assert "closed" in late.take("note")[0]["text"]


def test_a_panel_that_hangs_is_closed_all_the_same_for_those_who_look(hang, clock):
    view, here, control = hang(waits)
    assert not view.close(0.1)
    wait_for(lambda: here.of("closed"))
    assert here.newest("state")["state"] == "closed"
    control.may_go_on.set()


class Notebook(FakeBrowser):
    """A line that keeps a picture."""

    keeps_still = True

    def keep(self, picture):
        self.transmit({"type": "kept"}, [picture])


@pytest.mark.slow  # figures are drawn
def test_a_notebook_keeps_a_picture_from_time_to_time_while_it_runs(clock):
    view = PanelView(simulation(measure=True), speed=math.inf)
    notebook = Notebook(view)
    notebook.press("start")
    pictures = []
    for _ in range(2):
        clock.advance(view, 15.1)
        wait_for(lambda: view.still._due < math.inf)
        clock.advance(view, 0.6)
        pictures += notebook.take("kept")[1]
    assert view.driver.state == "running"
    assert len({*pictures}) == 2
    assert view.close(SOON)


# --- in a browser


@pytest.mark.slow
def test_a_silent_python_is_shown_then_covers_the_buttons_and_comes_back(open_fake):
    host = open_fake()
    host.setup()
    host.state()
    strip, cover = host.tab.locator(".robsim-silent"), host.tab.locator(".robsim-lost")
    host.tab.evaluate(
        """() => {
            const [emit, now] = [host.emit, performance.now.bind(performance)];
            Object.assign(host, { mute: true, late: 0 });
            host.emit = (head, texts) => !host.mute && emit(head, texts);
            performance.now = () => now() + host.late;
            setInterval(() => (host.late += 350), 250);
        }"""
    )
    strip.wait_for(state="visible")
    assert cover.is_hidden()
    host.tab.locator("button[name=start]").first.click()
    assert host.sent("press")
    cover.wait_for(state="visible")
    assert host.tab.evaluate("document.querySelector('.robsim-panel').inert")
    host.tab.evaluate("host.mute = false")
    cover.wait_for(state="hidden")
    assert not host.tab.evaluate("document.querySelector('.robsim-panel').inert")
    host.emit({"type": "closed"})
    assert host.tab.locator("main[data-state=closed]").count() == 1
    assert strip.is_visible()
