"""The tools on a run: they open in the panel, and the run uses their results."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from robsim.base.text import said_by
from robsim.gui._driver import Playback
from robsim.gui._link import Buffers, Link, Refused
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.record import RunRecord
from robsim.gui.tools.colors.panel import ColorPanel
from robsim.gui.tools.colors.view import ColorsView
from robsim.gui.tools.pictures import RunPictures
from robsim.gui.tools.robots.panel import RobotPanel
from robsim.gui.tools.robots.view import RobotsView
from robsim.simulation import Experiment, Simulation

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

NAMES = ("robots", "colors")

_GAP = 0.5  # s between two looks for a changed robot or changed colours, such as in a cell
_FILE = "colors.toml"
_EXPECTED = (OSError, TypeError, ValueError, RuntimeError)

T = TypeVar("T")


class Tools(Part):
    """Opens a tool on the run, relays its messages, and gives its result to the run."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self.tool: RobotPanel | ColorPanel | None = None
        self._name: str | None = None
        self._lines: dict[Link, ToolLine] = {}
        self._seen = self._looked_for()
        self._due = 0.0
        self._is_settled = threading.Event()  # set unless a result is on its way to the run
        self._is_settled.set()

    def handlers(self) -> Handlers:
        return {
            "tool": self._choose,
            "use_tool": self._use,
            "use_here": self._use,
            "tell_tool": self._tell,
        }

    def setup(self) -> dict[str, Any]:
        return {"tools": [] if isinstance(self.panel.runner, Playback) else [*NAMES]}

    def state(self) -> dict[str, Any]:
        return {"tool": self._name}

    def look(self, now: float) -> float:
        for link in [link for link in self._lines if link not in self.panel.links]:
            line = self._lines.pop(link)
            if self.tool is not None:
                self.tool._view.disconnect(line)
        if not self.panel.is_watched:
            return math.inf
        if now >= self._due:
            self._due = now + _GAP
            self._look_at_run()
        return self._due

    def close(self, timeout: float) -> None:
        self._close(timeout)

    def settle(self) -> None:
        """Wait until the run has the result; not in the run's or the view's thread."""
        self._is_settled.wait()

    def begin(self, name: str) -> None:
        """Open a tool on the run, and close the previous tool."""
        runner = self.panel.runner
        if name not in NAMES or isinstance(runner, Playback):
            raise Refused(f"this run has no tool {name!r}")
        self._close()
        self.tool = _opened(name, self.panel, runner)
        self._name = name

    def has(self, line: ToolLine) -> bool:
        return line in self._lines.values()

    def _choose(self, link: Link, message: dict[str, Any]) -> None:
        if message["name"] is None:
            self._close()
        elif message["name"] != self._name:
            self.begin(message["name"])
        self.panel.tell_state()

    def _tell(self, link: Link, message: dict[str, Any]) -> None:
        """Pass a browser's message on to the tool."""
        if self.tool is None or message["name"] != self._name:
            return  # it was closed meanwhile
        view = self.tool._view
        if link not in self._lines:
            self._lines[link] = ToolLine(self, link)
            view.connect(self._lines[link])
        told = {**message["message"], "id": message["id"]}
        view.receive(self._lines[link], told, message["buffers"])

    def _use(self, link: Link, message: dict[str, Any]) -> None:
        """Give the result to the run, close the tool, and continue."""
        if self.tool is None:
            return
        self.panel.check_room()
        tool, runner = self.tool, self.panel.runner
        assert isinstance(runner, (Simulation, Experiment))

        def change_run(made: Future[tuple[str, Any]]) -> None:
            name, value = made.result()
            changed = self.panel.driver.call(lambda: setattr(runner, name, value))
            self._then(link, changed, keep)

        def keep(_: Future[None]) -> None:
            keeps = message["type"] == "use_tool"
            self._then(link, tool._view.later(tool._keep if keeps else str), resume)

        def resume(kept: Future[str]) -> None:
            if self.tool is tool:
                self._close()
            self._look_at_run()
            self.panel.tell_state()
            if remark := kept.result():
                self.panel.send({"type": "note", "level": "info", "text": remark})
            if isinstance(runner, Simulation):  # a real robot waits for Start
                self.panel.driver.start()
            self._is_settled.set()

        self._is_settled.clear()
        # Each step runs in its own thread without waiting, so that Stop works meanwhile.
        self._then(link, tool._view.later(tool._made), change_run)

    def _then(self, link: Link, future: Future[T], go_on: Callable[[Future[T]], None]) -> None:
        """Continue in the view's thread after `future`; show an error if it failed."""

        def done() -> None:
            error = None if future.cancelled() else future.exception()
            if error is not None:
                text = str(error) if isinstance(error, _EXPECTED) else said_by(error)
                link.send({"type": "note", "level": "error", "text": text})
            if error is not None or future.cancelled():  # the tool is being closed
                self._is_settled.set()
            else:
                go_on(future)

        def post(_: Future[T]) -> None:
            if not self.panel.post(done):  # the panel has been closed
                self._is_settled.set()

        future.add_done_callback(post)

    def _close(self, timeout: float = 0.0) -> None:
        """Close the tool; without a timeout (s) it finishes its work first."""
        tool, self.tool, self._name = self.tool, None, None
        self._lines.clear()
        if tool is not None:
            tool._close(timeout)

    def _looked_for(self) -> tuple[object, ...]:
        runner = self.panel.runner
        if isinstance(runner, Playback):
            return ()
        return runner.robot, runner.colors, runner.markers

    def _look_at_run(self) -> None:
        """Take over a changed robot or changed colours of the run."""
        if (now := self._looked_for()) == self._seen:
            return
        self._seen = now
        if isinstance(self.panel.record, RunRecord):
            self.panel.record.look_again()
        self.panel.tell_setup()


class ToolLine(Link):
    """The link of a tool to a browser, through the panel's link."""

    def __init__(self, tools: Tools, link: Link) -> None:
        super().__init__()
        self._tools, self._link = tools, link

    @property
    def is_behind(self) -> bool:
        return self._link.is_behind

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        """Pass a message to the panel's thread, which owns the link; drop it once the tool ends."""
        message = {"type": "tool", "message": dict(head)}

        def send() -> None:
            if self._tools.has(self):
                self._link.send(message, buffers)

        if not self._tools.panel.post(send):
            raise RuntimeError("the panel has ended")


def _opened(
    name: str, panel: PanelView, runner: Simulation | Experiment
) -> RobotPanel | ColorPanel:
    pictures = RunPictures(panel.driver, panel.record.title)
    if name == "robots":
        return RobotPanel(RobotsView(pictures, runner.robot, runner.colors, begins_live=False))
    return ColorPanel(ColorsView(pictures, runner.colors, runner.robot, _free_file()))


def _free_file() -> Path:
    """Return the name of a new colour file, so that no existing file is overwritten."""
    for name in itertools.chain([_FILE], (f"colors{n}.toml" for n in itertools.count(2))):
        if not Path(name).exists():
            return Path(name)
    raise AssertionError("numbers do not end")
