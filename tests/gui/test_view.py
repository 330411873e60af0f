"""The thread that talks to browsers: floods, lines that are slow or gone, mistakes of its own."""

import gc
import math
import threading
import time
from typing import ClassVar

import pytest

import robsim
from browsers import FakeBrowser, panel_of, settled
from robsim.gui import _link
from robsim.gui._link import Link
from robsim.gui._panel import view as _panel_view
from robsim.gui._panel.run.pictures import Shot
from robsim.gui._panel.view import PanelView
from robsim.gui._view import View
from threads import together
from waiting import wait_for

pytestmark = pytest.mark.threads

SMALL = {"area": (300, 300), "resolution": (75, 75), "seed": 1}


def simulation(**options):
    return robsim.Simulation(control=robsim.DriveAround(), **SMALL, **options)


def robsim_threads():
    return {thread for thread in threading.enumerate() if thread.name.startswith("robsim")}


@pytest.fixture(autouse=True)
def no_thread_survives():
    before = robsim_threads()
    yield
    wait_for(lambda: robsim_threads() <= before)


@pytest.fixture
def panel():
    with panel_of(simulation(), speed=math.inf) as (view, browser):
        yield view, browser


@pytest.fixture
def mistakes(monkeypatch):
    """What Python is told of that nobody waits for."""
    told = []
    monkeypatch.setattr(threading, "excepthook", lambda about: told.append(about.exc_value))
    return told


def runs(view, steps=3):
    before = view.runner.n_steps
    wait_for(lambda: view.runner.n_steps >= before + steps)
    return True


# Floods

BAD = [
    *(None, 7, "x", [0] * 10**6, {"type": "set", "id": "a"}, {"type": "nothing", "id": "a"}),
    *({"type": "set", "id": "a", "name": "speed", "value": v} for v in (10**400, math.nan, [])),
    {"type": "path", "id": "a", "points": [[0, 0]] * 10**6},
]


def test_ten_thousand_bad_messages_are_refused_and_few_of_them_answered(panel):
    view, browser = panel
    browser.press("start")
    assert runs(view)
    began = time.monotonic()
    for _ in range(1000):
        for message in BAD:
            view.receive(browser, message)
    assert runs(view)
    settled(view)
    notes = browser.all_of("note")
    assert 0 < len(notes) <= 10 * (2 + time.monotonic() - began)  # ten a second
    assert {note["level"] for note in notes} == {"error"}
    browser.press("pause")
    browser.take("state", state="paused")


def test_what_waits_does_not_grow_for_ever_and_stop_is_heard_all_the_same(panel):
    view, browser = panel
    browser.press("start")
    browser.take("state", state="running")
    inside, may_go_on = threading.Event(), threading.Event()
    view.post(lambda: (inside.set(), may_go_on.wait(20)))
    inside.wait(20)
    for _ in range(10_000):
        browser.press("start")
    assert len(view._jobs) < 2000
    browser.press("stop")
    may_go_on.set()
    browser.take("state", state="paused")
    settled(view)
    time.sleep(0.02)
    assert view.driver.state == "paused"  # what was pressed before Stop is void


def test_messages_from_many_threads(panel):
    view, browser = panel
    together(*[lambda: [browser.say("grant", upto=10**9, late=False) for _ in range(200)]] * 4)
    settled(view)
    browser.press("step")
    browser.take("frame", k=0)


# Lines


class Cut(FakeBrowser):
    """Its other end goes after so many messages."""

    left = 5

    def transmit(self, head, buffers):
        self.left -= 1
        if self.left < 0:
            raise ConnectionResetError("gone")
        super().transmit(head, buffers)


@pytest.mark.long
def test_a_line_that_is_cut_is_forgotten_and_others_go_on(panel):
    view, browser = panel
    cut = Cut(view)
    browser.press("start")
    wait_for(lambda: cut not in view.links)
    for _ in range(5):
        browser.take("frame")
    assert view.links == [browser]
    assert view.driver.state == "running"


def test_the_last_line_that_is_cut_pauses_the_run(monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 0.01)
    view = PanelView(simulation(), speed=math.inf)
    Cut(view).press("start")
    assert runs(view)
    wait_for(lambda: view.driver.state == "paused")
    view.close()


@pytest.mark.long
def test_a_slow_line_gets_fewer_frames_and_the_last_one_and_holds_up_nobody(panel, monkeypatch):
    monkeypatch.setattr(_link, "SLOW", 1000.0)
    view, browser = panel
    slow = FakeBrowser(view, name="slow", room=3)
    browser.press("start")
    seen = [browser.take("frame")[0] for _ in range(20)]
    browser.press("pause")
    browser.take("state", state="paused")
    last = view.runner.n_steps - 1
    while seen[-1]["k"] < last:
        seen.append(browser.take("frame")[0])
    slow.say("grant", upto=100, late=False)  # as a browser does when it is told of the pause
    few = [slow.take("frame")[0] for _ in range(4)]
    assert few[-1]["k"] == last
    assert slow.all_of("frame") == []
    for frames in (seen, few):
        assert [head["n"] for head in frames] == [*range(frames[0]["n"], frames[-1]["n"] + 1)]
        steps = [head["k"] for head in frames]
        assert steps == sorted(steps)
    assert few[0]["n"] == 1


@pytest.mark.long
def test_without_any_room_frames_go_on_slowly(panel, monkeypatch):
    monkeypatch.setattr("robsim.gui._panel.run.camera.SLOW", 0.02)
    monkeypatch.setattr(_link, "SLOW", 0.02)
    view, browser = panel
    deaf = FakeBrowser(view, name="deaf", room=0)
    browser.press("start")
    assert [deaf.take("frame")[0]["n"] for _ in range(4)] == [1, 2, 3, 4]


class Line(Link):
    def transmit(self, head, buffers):
        pass


def test_views_that_say_nothing_while_others_do_are_forgotten(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("robsim.gui._link.time.monotonic", lambda: now[0])
    line = Line()
    line.greet("old")
    line.greet("new")
    line.grant("new", 100)
    line.sent = 5
    assert not line.has_room(0.0)  # for the old one
    now[0] = 11.0
    line.grant("new", 100)
    line._last_frame = 11.0
    assert line.has_room(11.0)
    line.part("new")
    assert not line.is_watched
    for number in range(1000):
        line.greet(str(number))
    assert len(line._grants) == 20


@pytest.mark.long
def test_while_the_view_is_busy_only_the_newest_frame_is_kept():
    before = [shot for shot in gc.get_objects() if isinstance(shot, Shot)]  # of other tests
    with panel_of(simulation()) as (view, browser):
        browser.take("frame")
        is_busy, may_go_on = threading.Event(), threading.Event()
        view.post(lambda: (is_busy.set(), may_go_on.wait(20)))
        assert is_busy.wait(20)
        for _ in range(50):
            view.driver.step().result()
        shots = [shot for shot in gc.get_objects() if isinstance(shot, Shot)]
        kept = {shot.k for shot in shots if not any(shot is old for old in before)}
        may_go_on.set()
        browser.take("frame", k=49)
    assert 49 in kept
    assert len(kept) < 10


# Coming and going


def test_a_page_that_is_loaded_anew_finds_the_run_going_on(panel, monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 1000.0)
    view, browser = panel

    def later():
        view.post(lambda: view._look_for_watchers(time.monotonic() + 1001))
        settled(view)
        view.driver.call(lambda: None).result(20)

    browser.press("start")
    assert runs(view)
    browser.say("bye")
    browser.say("hello", width=300)
    later()
    assert view.driver.state == "running"
    browser.say("bye")
    settled(view)
    assert view.driver.state == "running"
    later()
    assert view.driver.state == "paused"


def test_one_of_two_views_may_go_and_a_stranger_too(panel, monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 0.0)
    view, browser = panel
    browser.press("start")
    other, stranger = FakeBrowser(view, name="other"), Line()
    view.connect(stranger)
    other.say("bye")
    view.disconnect(stranger)
    settled(view)
    assert runs(view)
    assert view.driver.state == "running"


def test_a_run_that_nobody_has_looked_at_yet_goes_on(monkeypatch):
    monkeypatch.setattr(_panel_view, "_PATIENCE", 0.0)
    view, stranger = PanelView(simulation(), speed=math.inf), Line()
    view.driver.start()
    view.connect(stranger)
    view.disconnect(stranger)
    view.receive(stranger, {"type": "bye", "id": "stranger"})
    settled(view)
    assert runs(view)
    assert view.driver.state == "running"
    view.close()


def test_while_nobody_looks_no_pictures_are_made_and_whoever_comes_sees_the_newest(
    panel, monkeypatch
):
    monkeypatch.setattr(_panel_view, "_PATIENCE", math.inf)
    view, browser = panel
    made, shot = [], view.record.shot
    monkeypatch.setattr(view.record, "shot", lambda step: made.append(step.k) or shot(step))
    browser.press("start")
    wait_for(lambda: made)
    browser.say("bye")
    settled(view)
    assert runs(view)  # the step under way has been seen
    before = len(made)
    assert runs(view, 50)
    assert len(made) == before
    newest = view.runner.n_steps - 1
    again = FakeBrowser(view, name="again")
    assert again.take("frame")[0]["k"] >= newest


# Mistakes


def test_a_mistake_in_a_part_is_told_once_and_nothing_ends(panel, mistakes, monkeypatch):
    view, browser = panel
    monkeypatch.setattr(_panel_view, "RETRY", 0.0)
    for method in ("take", "look", "state", "changed", "greet"):
        monkeypatch.setattr(view._parts[-1], method, lambda *_, name=method: {}[name])
    browser.press("start")
    for _ in range(3):
        browser.take("frame")
    browser.say("hello", width=300)
    browser.press("pause")
    browser.take("state", state="paused")
    settled(view)
    assert {type(error) for error in mistakes} == {KeyError}
    assert len(mistakes) == 1  # all from one line
    assert view._thread.is_alive()


def test_a_mistake_in_a_handler_is_told_to_those_who_look(panel, mistakes):
    view, browser = panel
    view._handlers["look"] = lambda link, message: 1 / 0
    browser.say("look", k=3)
    note, _ = browser.take("note")
    assert note["text"] == "A mistake in the panel itself: ZeroDivisionError: division by zero"
    assert [type(error) for error in mistakes] == [ZeroDivisionError]
    browser.press("step")
    browser.take("frame", k=0)


def test_a_message_that_cannot_be_written_is_a_mistake_and_the_line_stays(panel, mistakes):
    view, _ = panel

    class Strict(FakeBrowser):
        def transmit(self, head, buffers):
            if head["type"] == "note" and head["text"] == "bad":
                raise ValueError("Out of range float values are not JSON compliant")
            super().transmit(head, buffers)

    strict = Strict(view, name="strict")
    view.note("bad")
    view.note("good")
    strict.take("note", text="good")
    assert [str(error)[:12] for error in mistakes] == ["Out of range"]


# Life


def test_a_panel_that_cannot_be_made_leaves_no_thread():
    before = robsim_threads()
    for shown, options, error in [
        (simulation(), {"speed": -1}, ValueError),
        (simulation(), {"speed": "fast"}, TypeError),
        (7, {}, TypeError),
    ]:
        with pytest.raises(error):
            PanelView(shown, **options)
    PanelView(simulation())  # one that nobody looks at
    assert robsim_threads() == before


def test_closing_tells_the_browsers_and_ends_both_threads(panel):
    view, browser = panel
    browser.press("start")
    assert runs(view)
    assert view.close()
    browser.take("state", state="closed")
    assert not view.post(lambda: None)
    view.receive(browser, {"type": "press", "id": "fake", "button": "start"})
    assert view.close()


def test_closing_from_the_thread_of_the_view(panel):
    view, browser = panel
    browser.press("start")
    assert runs(view)
    view.post(lambda: closed.append(view.close()))
    closed = []
    browser.take("state", state="closed")
    wait_for(lambda: closed == [False])  # it ends after that


def test_urgent_messages_come_first():
    class Letters(View):
        kind = "letters"
        messages: ClassVar = {"press": {"button": str}}

        def __init__(self):
            super().__init__()
            self.read = []

        def handlers(self):
            return {"press": lambda link, message: self.read.append(message["button"])}

        def is_urgent(self, message):
            return message["button"] == "urgent"

        def tell(self, link):
            pass

        def parted(self):
            pass

        def snapshot(self):
            return b""

    view, line, may_go_on = Letters(), Line(), threading.Event()
    view.post(lambda: may_go_on.wait(20))
    for button in ("a", "b", "urgent"):
        view.receive(line, {"type": "press", "id": "", "button": button})
    may_go_on.set()
    assert view.close()
    assert view.read == ["urgent", "a", "b"]
