"""How waits and runs end: by Ctrl-C, by closing, by what goes wrong at the end."""

import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import robsim
from browsers import panel_of
from robsim.gui._driver import Driver
from robsim.gui._hosts import page as _page
from robsim.gui._hosts.page import Page
from robsim.gui._panel.view import PanelView
from waiting import wait_for

pytestmark = pytest.mark.threads

SMALL = {"area": (300, 300), "resolution": (75, 75), "seed": 1}
SOON = 20  # s


def simulation(**options):
    return robsim.Simulation(**SMALL, **options)


@pytest.fixture(autouse=True)
def no_thread_survives():
    yield
    wait_for(lambda: not [t for t in threading.enumerate() if t.name.startswith("robsim")])


@pytest.fixture
def mistakes(monkeypatch):
    """What Python is told of that nobody waits for."""
    told = []
    monkeypatch.setattr(threading, "excepthook", lambda about: told.append(about.exc_value))
    return told


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
    timer = threading.Timer(0.05, panel.close)
    timer.start()
    panel.wait()  # nobody has opened its page
    assert panel.state == "closed"
    timer.join()


def test_a_server_that_cannot_start_says_why(monkeypatch):
    def broken(host):
        raise OSError("too many open files")

    monkeypatch.setattr(_page, "Server", broken)
    view = PanelView(simulation())
    with pytest.raises(OSError, match="too many open files"):
        Page(view)
    view.close()


def test_motors_that_end_their_thread_do_not_keep_a_run_open(mistakes):
    def send(u):
        if not u.any():
            raise SystemExit

    frames = [robsim.Frame(np.zeros((64, 64, 3), np.uint8))] * 5
    options = {"control": lambda step: (1, 2), "area": (64, 64), "measure": False}
    driver = Driver(robsim.Experiment(frames, send=send, frame_timeout=1000, **options))
    driver.step().result(SOON)
    assert driver.close()
    assert driver.state == "closed"
    assert [type(error) for error in mistakes] == [SystemExit]


def test_a_pause_is_told_though_its_last_step_cannot_be_had(mistakes, monkeypatch):
    with panel_of(simulation()) as (view, browser):
        browser.press("start")
        wait_for(lambda: view.runner.n_steps)
        monkeypatch.setattr(robsim.Simulation, "last_step", property(lambda sim: 1 / 0))
        browser.press("pause")
        browser.take("state", state="paused")
    assert [type(error) for error in mistakes] == [ZeroDivisionError]


WAIT = """
import signal, sys, threading, time
import robsim
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a job in the background
panel = robsim.panel(robsim.Simulation(area=(300, 300)), speed=float("inf"))
panel.start()
panel.url  # is served from here on

def tell():
    main = threading.main_thread().ident
    while sys._current_frames()[main].f_code.co_filename != threading.__file__:
        time.sleep(0.01)
    print("waits", flush=True)

threading.Timer(0.2, tell).start()
panel.wait()
print(panel.state, len(panel.trace) > 0)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there Ctrl-C is no signal to one process")
def test_a_script_goes_on_after_ctrl_c():
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-c", WAIT], **pipes) as script:
        try:
            script.stdout.readline()
            script.send_signal(signal.SIGINT)
            out, complaints = script.communicate(timeout=60)
        finally:
            script.kill()
    assert (script.returncode, out, complaints) == (0, "paused True\n", "")
