"""The table of states and events in ARCHITECTURE.md, row by row."""

import math
import re
import threading
from pathlib import Path

import pytest

import robsim
import robsim.gui
from browsers import FakeBrowser, PanelView, Watcher
from small_runs import SOON, experiment, frames, simulation
from waiting import wait_for

pytestmark = pytest.mark.threads

PAGE = Path(robsim.gui.__file__).with_name("ARCHITECTURE.md").read_text("utf-8")
TABLE = PAGE.partition("| state | event | shown |")[2].partition("\n\n")[0]
FAILING = "def control(step):\n    return 0, 1 // (step.k < 1)\n"
ROWS = re.findall(r"^\| ([a-z].*?) \| (.*?) \| (.*?) \|$", TABLE, re.MULTILINE)


class Case:
    """A panel in a state, and one who looks."""

    def __init__(self, clock, folder):
        self.file = folder / "control.py"
        self.clock, self.may_go_on = clock, threading.Event()
        self.does = "drive"

    def control(self, step):
        if self.does == "fail":
            raise ValueError("wrong")
        while self.does == "hang" and step.k >= 2 and not self.may_go_on.is_set():
            pass
        return 0.1, 0.1

    def bring(self, state, *, ends, has_file):
        """Bring a panel into a state; `ends`: its frames have an end."""
        runner = simulation(control=self.control)
        if has_file:
            self.file.write_text(FAILING)
            runner = robsim.Simulation.from_folder(self.file.parent)
        if ends:
            runner = experiment(frames(3), control=lambda step: (0, 0))
        self.view = PanelView(runner, speed=1.0)
        self.here = Watcher(self.view)
        self.until(lambda: self.here.of("state"))
        if state != "closed":
            self.view.driver.step().result(SOON)
        {"failed": self.fail, "stuck": self.hang, "closed": self.close}.get(state, list)()
        if state in ("running", "ended"):
            self.here.say("press", button="start")
        self.until(lambda: self.is_shown(state))
        self.steps = self.view.record.n_steps

    def fail(self, button="start"):
        self.does = "fail"
        self.here.say("press", button=button)

    def hang(self):
        self.does = "hang"
        self.view.driver.speed = math.inf
        self.here.say("press", button="start")
        self.until(lambda: self.view.driver.limit.call)
        self.clock.advance(self.view, 3)

    def close(self):
        self.view.close(SOON if self.does != "hang" else 0.1)

    def do(self, event):
        """Let something happen."""
        if event in ("start", "pause", "step", "reset", "end"):
            self.here.say("press", button=event)
            self.clock.advance(self.view, 0.0) if not self.view.is_over else None
            if self.does == "hang":
                self.clock.advance(self.view, 2.1)
        elif event == "a new page":
            self.here = FakeBrowser(self.view)
            self.here.messages = [head for head, _ in self.here._told]
            self.here.of = self.here.all_of
        elif event == "the last page goes":
            self.here.say("bye")
            if not self.view.is_over:
                self.clock.advance(self.view, 0.0)
                self.clock.advance(self.view, 2.1)
            self.here = Watcher(self.view)
        elif event == "an error":
            self.does = "fail"
        elif event == "a step with an error":
            self.fail("step")
        elif event == "30 s":
            self.clock.advance(self.view, 30)
        elif event == "its file changes":
            self.file.write_text(FAILING.replace("1 //", "1 +"))
        elif event == "close":
            self.close()

    def until(self, is_so):
        """Wait, and let the clock go on a little."""

        def look():
            if not self.view.is_over:
                self.clock.advance(self.view, 0.02)
            return is_so()

        wait_for(look)

    def is_shown(self, shown):
        """Whether the newest state that a page got is this one."""
        states = self.here.of("state")
        if not states:
            return False
        told, (state, *more) = states[-1], shown.split(", ")
        if (told["state"] == "running" and told["stuck"] is not None) != (state == "stuck"):
            return False
        wanted = {
            "one step more": lambda: told["steps"] == self.view.record.n_steps > self.steps,
            "no steps": lambda: told["steps"] == 0,
            "the error": lambda: told["error"]["slot"] == "control",
        }
        is_state = told["state"] == ("running" if state == "stuck" else state)
        return is_state and all(wanted[one]() for one in more)


@pytest.fixture
def case(clock, tmp_path):
    case = Case(clock, tmp_path)
    yield case
    case.may_go_on.set()
    case.view.close(SOON)


@pytest.mark.parametrize(("state", "event", "shown"), ROWS)
def test_a_row_of_the_table(case, state, event, shown):
    case.bring(state, ends="ended" in (state, shown), has_file=event == "its file changes")
    case.do(event)
    case.until(lambda: case.is_shown(shown))


def test_all_rows_are_read():
    assert len(ROWS) > 30
