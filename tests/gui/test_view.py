"""The thread that talks to browsers: floods, lines that are slow or gone, mistakes of its own."""

import gc
import math
import threading

import pytest

from browsers import FakeBrowser, Link, PanelView, panel_of, settled
from robsim.gui import _link
from robsim.gui.panels.run.camera import Shot
from small_runs import SOON, done, robsim_threads, simulation
from waiting import wait_for

pytestmark = pytest.mark.threads


@pytest.fixture(autouse=True)
def no_thread_survives():
    before = robsim_threads()
    yield
    wait_for(lambda: robsim_threads() <= before)


@pytest.fixture
def panel():
    with panel_of(simulation(), speed=math.inf) as (view, browser):
        yield view, browser


def runs(view, steps=3):
    before = view.runner.n_steps
    wait_for(lambda: view.runner.n_steps >= before + steps)
    return True


def held(view):
    """Keep the thread of a view busy; return the event that lets it go on."""
    inside, may_go_on = threading.Event(), threading.Event()
    view.post(lambda: (inside.set(), may_go_on.wait(SOON)))
    assert inside.wait(SOON)
    return may_go_on


# Floods

BAD = [
    *(None, 7, "x", [0] * 10**6, {"type": "set", "id": "a"}, {"type": "nothing", "id": "a"}),
    *({"type": "set", "id": "a", "name": "speed", "value": v} for v in (10**400, math.nan, [])),
    {"type": "path", "id": "a", "points": [[0, 0]] * 10**6},
]


def test_thousands_of_bad_messages_are_refused_and_few_of_them_answered(panel, monkeypatch):
    now = [0.0]
    monkeypatch.setattr("robsim.gui._link.time.monotonic", lambda: now[0])
    view, browser = panel
    browser.press("start")
    assert runs(view)
    for seconds in range(3):
        now[0] = 1.5 * seconds
        for _ in range(100):
            for message in BAD:
                view.receive(browser, message)
        settled(view)
    notes = browser.all_of("note")
    assert len(notes) == 3 * 10  # ten a second
    assert {note["level"] for note in notes} == {"error"}
    assert runs(view)
    browser.press("pause")
    browser.take("state", state="paused")


def test_what_waits_does_not_grow_for_ever_and_stop_is_heard_all_the_same(panel):
    view, browser = panel
    browser.press("start")
    browser.take("state", state="running")
    may_go_on = held(view)
    for _ in range(10_000):
        browser.press("start")
    assert len(view._jobs) < 2000
    browser.press("stop")
    may_go_on.set()
    browser.take("state", state="paused")
    settled(view)
    done(view.driver.call(lambda: None))
    assert view.driver.state == "paused"  # what was pressed before Stop is void


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
    for _ in range(2):
        browser.take("frame")
    assert view.links == [browser]
    assert view.driver.state == "running"


def test_the_last_line_that_is_cut_pauses_the_run(patience):
    patience(0.01)
    view = PanelView(simulation(), speed=math.inf)
    is_busy, may_go_on = threading.Event(), threading.Event()
    view.driver.call(lambda: (is_busy.set(), may_go_on.wait(SOON)))
    assert is_busy.wait(SOON)
    cut = Cut(view)
    cut.press("start")
    wait_for(lambda: view.driver.n_waiting)
    cut.left = 0
    view.post(view.tell_state)
    wait_for(lambda: not view.links and view.driver.n_waiting > 1)  # the start, and the pause
    may_go_on.set()
    done(view.driver.call(lambda: None))
    wait_for(lambda: view.driver.state == "paused")
    view.close()


@pytest.mark.long
def test_a_slow_line_gets_fewer_frames_and_the_last_one_and_holds_up_nobody(panel, monkeypatch):
    monkeypatch.setattr(_link, "SLOW", 1000.0)
    view, browser = panel
    slow = FakeBrowser(view, name="slow", room=3)
    browser.press("start")
    seen = [browser.take("frame")[0] for _ in range(8)]
    done(view.driver.pause())
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


@pytest.mark.long
def test_without_any_room_frames_go_on_slowly(panel, monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.run.camera.SLOW", 0.02)
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
    for number in range(100):
        line.greet(str(number))
    assert len(line._grants) == 20


@pytest.mark.long
def test_while_the_view_is_busy_only_the_newest_frame_is_kept():
    def shots():
        return [one for one in gc.get_objects() if type(one) is Shot]

    before = shots()  # of other tests
    with panel_of(simulation()) as (view, browser):
        browser.take("frame")
        may_go_on = held(view)
        for _ in range(30):
            done(view.driver.step())
        kept = {shot.k for shot in shots() if not any(shot is old for old in before)}
        may_go_on.set()
        browser.take("frame", k=29)
    assert 29 in kept
    assert len(kept) < 10


# Coming and going


def test_a_page_that_is_loaded_anew_finds_the_run_going_on(clock, panel):
    view, browser = panel

    def later(seconds):
        settled(view)
        clock.advance(view, seconds)
        done(view.driver.call(lambda: None))

    browser.press("start")
    assert runs(view)
    browser.say("bye")
    later(1.9)
    browser.say("hello", width=300)
    later(3.0)
    assert view.driver.state == "running"
    browser.say("bye")
    later(1.9)
    assert view.driver.state == "running"
    later(0.2)
    wait_for(lambda: view.driver.state == "paused")


def test_the_run_goes_on_while_others_look(panel, patience):
    patience(0.0)
    view, browser = panel
    browser.press("start")
    other, stranger = FakeBrowser(view, name="other"), Line()
    view.connect(stranger)
    other.say("bye")
    view.disconnect(stranger)
    view.receive(stranger, {"type": "bye", "id": "stranger"})
    settled(view)
    assert runs(view)
    assert view.driver.state == "running"


def test_while_nobody_looks_no_pictures_are_made_and_whoever_comes_sees_the_newest(
    panel, patience, monkeypatch
):
    patience(math.inf)
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
    monkeypatch.setattr("robsim.gui.panels.view.RETRY", 0.0)
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
    assert "ZeroDivisionError: division by zero" in note["text"]
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
    closed = []
    view.post(lambda: closed.append(view.close()))
    browser.take("state", state="closed")
    wait_for(lambda: closed == [False])  # in the thread itself: it ends after that
    assert view.close(SOON)
    assert not view.post(lambda: None)
    view.receive(browser, {"type": "press", "id": "fake", "button": "start"})
