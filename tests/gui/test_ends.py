"""How waits and runs end: by Ctrl-C, by closing, by what goes wrong at the end."""

import sys
import threading

import pytest

import robsim
from browsers import Page, panel_of
from small_runs import SOON, done, experiment, frames, robsim_threads, simulation
from threads import in_thread
from waiting import wait_for

pytestmark = pytest.mark.threads


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

    sim = experiment(frames(), send=send, control=lambda step: (1, 2), frame_timeout=1000)
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
