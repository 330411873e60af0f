"""How waits and runs end, and how runs begin again."""

import sys
import threading

import numpy as np
import pytest

import robsim
from browsers import Page, panel_of, settled
from small_runs import SOON, done, experiment, frames, robsim_threads, simulation
from threads import in_thread
from waiting import wait_for

pytestmark = pytest.mark.threads


# --- ends


@pytest.fixture(autouse=True)
def no_thread_survives():
    yield
    wait_for(lambda: not robsim_threads())


def test_ctrl_c_ends_a_wait_and_pauses(monkeypatch):
    def interrupted(page, patience):
        raise KeyboardInterrupt

    monkeypatch.setattr(Page, "wait", interrupted)
    with robsim.panel(simulation()) as panel:
        panel.start()
        panel.wait()
        assert panel.state == "paused"


@pytest.mark.long
def test_closing_in_another_thread_ends_a_wait():
    panel = robsim.panel(simulation())
    assert panel.url  # it is served from here on

    def is_waiting():
        frame = sys._current_frames()[threading.main_thread().ident]
        while frame is not None and frame.f_code is not Page.wait.__code__:
            frame = frame.f_back
        return frame is not None

    def close():
        wait_for(is_waiting)
        panel.close()

    with in_thread(close):
        panel.wait()  # nobody has opened its page
    assert panel.state == "closed"


def test_a_server_that_cannot_start_says_why(monkeypatch):
    def broken(host):
        raise OSError("too many open files")

    monkeypatch.setattr("robsim.gui.hosts.page.Server", broken)
    with panel_of(simulation()) as (view, _), pytest.raises(OSError, match="too many open files"):
        Page(view)


def test_motors_that_end_their_thread_do_not_keep_a_run_open(mistakes):
    def send(u):
        if not u.any():
            raise SystemExit

    sim = experiment(frames(), send=send, control=lambda step: (1, 2))
    with panel_of(sim) as (view, _):
        done(view.driver.step())
        assert view.driver.close(SOON)
        assert view.driver.state == "closed"
    assert [type(error) for error in mistakes] == [SystemExit]


def test_a_pause_is_told_though_its_last_step_cannot_be_had(mistakes, monkeypatch):
    with panel_of(simulation()) as (view, browser):
        browser.press("start")
        wait_for(lambda: view.runner.n_steps)
        monkeypatch.setattr(robsim.Simulation, "last_step", property(lambda sim: 1 / 0))
        browser.press("pause")
        browser.take("state", state="paused")
    assert [type(error) for error in mistakes] == [ZeroDivisionError]


# --- resets


def run_anew(view, steps):
    """Reset and run as many steps, while the panel has no time to look."""
    inside, may_go_on = threading.Event(), threading.Event()
    view.post(lambda: (inside.set(), may_go_on.wait(SOON)))
    assert inside.wait(SOON)
    done(view.driver.reset())
    for _ in range(steps):
        done(view.driver.step())
    may_go_on.set()


def seed_anew(view, steps):
    """Do the same in between two steps, as a cell of a notebook does while the run is paused."""

    def begin():
        view.runner.reset(seed=7)
        view.runner.run(steps)

    done(view.driver.call(begin))


def rows_of(head, buffers, name):
    entries = [entry["column"] for entry in head["rows"]]
    at = entries.index(name)
    block = np.frombuffer(buffers[at - len(entries)], "<f4")
    return head["rows"][at]["first"], block.reshape(-1, max(head["rows"][at]["width"], 1))


@pytest.mark.parametrize(("anew", "longer"), [(run_anew, -2), (seed_anew, 0), (seed_anew, 3)])
def test_rows_begin_with_the_first_one_however_many_there_are(anew, longer):
    sim = simulation()
    sim.run(5)
    with panel_of(sim) as (view, browser):
        browser.say("columns", names=["pose_true", "pose_measured"])
        browser.take_rows()
        anew(view, 5 + longer)
        browser.press("step")
        rows = ()
        while not len(rows):  # there may be none between the reset and the first step
            head, buffers = browser.take_rows()
            first, rows = rows_of(head, buffers, "pose_true")
    assert first == 0
    np.testing.assert_array_equal(rows, sim.trace.pose_true[: len(rows)].astype("f4"))
    assert "pose_measured" not in [entry["column"] for entry in head["rows"]]  # there was none


def test_a_column_that_the_new_run_lacks_is_empty():
    sim = simulation(measure=True)
    sim.run(5)
    with panel_of(sim) as (view, browser):
        browser.say("columns", names=["pose_measured"])
        browser.take_rows()

        def begin():
            sim.reset()
            sim.measure = None
            sim.run(8)

        done(view.driver.call(begin))
        browser.press("pause")
        head, buffers = browser.take_rows()
    assert head["rows"] == [{"column": "pose_measured", "first": 0, "width": 0}]
    assert buffers[-1] == b""


def test_who_looks_back_sees_the_newest_step_of_the_new_run():
    sim = simulation(measure=True)
    sim.run(6)
    with panel_of(sim) as (view, browser):
        browser.say("look", k=4)
        browser.take("frame", k=4, past=True)
        run_anew(view, 9)
        browser.take("state", resets=1, steps=9)
        browser.say("hello", width=300)
        browser.take("frame", k=8, past=False)


def test_what_is_told_of_the_whole_record_is_of_the_new_run():
    options = {"measure": True, "estimate_parameters": True, "noise": robsim.GaussianNoise(20)}
    sim = simulation(**options)
    sim.run(40)
    anew = simulation(**options)
    anew.reset(seed=7)
    wanted = anew.run(40).parameters[-1].ravel().tolist()
    with panel_of(sim) as (view, browser):
        before, _ = browser.take("statistics")
        browser.say("hello", width=300)  # again, as parameters may have come before
        browser.take("parameters")
        seed_anew(view, 40)
        browser.say("grant", upto=10**9, late=False)  # it looks again
        while browser.take("parameters")[0]["values"] != wanted:
            pass
        browser.say("hello", width=300)
        while browser.take("statistics")[0]["errors"] == before["errors"]:
            pass


def test_a_result_of_the_run_before_is_not_told_to_a_new_view():
    sim = simulation()
    sim.run(3)
    with panel_of(sim) as (view, browser):
        browser.press("finish")
        browser.take("result")
        seed_anew(view, 3)
        browser.say("hello", width=300)
        browser.take("setup")
        settled(view)
        done(view.driver.call(lambda: None))
        settled(view)
        assert browser.all_of("state")
        assert browser.all_of("result") == []


class Frames:
    """Frames that cannot be had again, but in a run from the first one on."""

    def __iter__(self):
        return iter(frames(20))


def test_pictures_that_were_kept_are_those_of_the_new_run():
    with panel_of(experiment(Frames())) as (view, browser):
        for k in range(3):
            browser.press("step")
            browser.take("frame", k=k)
        run_anew(view, 3)
        browser.take("frame", k=2)
        browser.say("look", k=0)  # which nobody has seen
        assert browser.take("frame", k=0, past=True)[1] == [b""]


def test_the_last_picture_before_a_reset_is_not_sent_after_it():
    with panel_of(experiment(frames())) as (_, browser):
        browser.press("step")
        browser.press("step")
        browser.take("frame", k=1)
        browser.press("reset")
        browser.take("state", steps=0, resets=1)
        browser.say("hello", width=300)
        browser.take("setup")
        browser.press("step")
        browser.take("state", steps=1)
        assert {head["k"] for head in browser.all_of("frame")} <= {0}
        browser.take("frame", k=0)
