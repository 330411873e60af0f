"""Start, Pause, Step and similar buttons, the big Stop, and the state of the run."""

from __future__ import annotations

import math
import threading
import time
import traceback
from concurrent.futures import Future
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from robsim._core import Step
from robsim.base.source_line import SourceLine
from robsim.base.text import printable, said_by
from robsim.gui._driver import Playback
from robsim.gui._link import Link, Refused
from robsim.gui.kept_runs import keep
from robsim.gui.panels.part import Handlers, Part
from robsim.simulation import Experiment
from robsim.simulation.callbacks.errors import callback_of, traceback_line
from robsim.simulation.slots import AT_START, SLOTS
from robsim.trace import Trace

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
_LONGEST = 4000  # characters of a text
_MOST_FRAMES = 20


def trouble_of(error: BaseException) -> dict[str, Any]:
    """Return the field ``error`` of the message ``state``."""
    failed = callback_of(error)
    told = {
        "slot": failed.slot if failed else None,
        "k": failed.k if failed else None,
        "text": said_by(error),
        "file": None,
        "line": None,
        "code": None,
        "traceback": "",
    }
    with suppress(Exception):  # an exception may hold any value, such as notes = 5
        told |= _told_by(error)
    return told


def _told_by(error: BaseException) -> dict[str, Any]:
    source = _source_of(error)
    return {
        "text": _shortened(_text_of(error, source)),
        "file": source.file if source else None,
        "line": source.number if source else None,
        "code": _code_of(error, source),
        "traceback": _shortened(_traceback_of(error)),
    }


def _source_of(error: BaseException) -> SourceLine | None:
    failed = callback_of(error)
    if failed is not None and failed.source is not None:
        return failed.source
    if isinstance(error, SyntaxError) and error.filename:
        return SourceLine(error.filename, error.lineno or 1, "<module>")
    return None


def _code_of(error: BaseException, source: SourceLine | None) -> str | None:
    if isinstance(error, SyntaxError) and error.text:  # in a file that failed to load
        return _shortened(error.text.strip())
    return _shortened(source.text) if source else None


def _text_of(error: BaseException, source: SourceLine | None) -> str:
    """Return kind (without its module), message and notes of an error, without its place."""
    failed = callback_of(error)
    where = f"in the callback {failed.slot} {failed.when}" if failed else None
    if failed is not None and failed.slot not in SLOTS:
        where = f"in {failed.slot} {failed.when}"
    notes = [note for note in getattr(error, "__notes__", []) if note != where]
    said = _last_lines(error)
    kind = f"{type(error).__module__}.{type(error).__qualname__}"
    if said.startswith(kind):
        said = type(error).__name__ + said.removeprefix(kind)
    if where:
        said = said.replace(f": {where}: ", ": ", 1)
    if source:
        said = said.removesuffix(f"\n  {traceback_line(source)}")
        if isinstance(error, SyntaxError) and source.file == error.filename:
            said = said.rpartition("\n")[2]
    return "\n".join([said, *map(str, notes)])


def _traceback_of(error: BaseException) -> str:
    """Return the traceback without frames of robsim and installed packages; may be empty."""
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if SourceLine(frame.filename, frame.lineno or 1, frame.name).is_users
    ]
    if not frames:
        return ""
    return "".join([*traceback.format_list(frames[-_MOST_FRAMES:]), _last_lines(error)])


def _last_lines(error: BaseException) -> str:
    kind = traceback.TracebackException(type(error), error, None)
    kind.__notes__ = None
    return "".join(kind.format_exception_only()).rstrip()


def _shortened(text: str) -> str:
    return printable(text if len(text) <= _LONGEST else text[:_LONGEST] + " ...")


_GAP = 1.0  # s between two looks at the camera's counts
_PATIENCE = 0.2  # s for Stop
_MOST_STOPS = 10  # that hang at the same time


class Transport(Part):
    """Carries out the buttons of the run, and sends its state."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        panel.driver.on_stage.append(self._note_stage)
        self._stopping: list[threading.Thread] = []
        self._camera: CameraRate | None = None
        if isinstance(panel.runner, Experiment) and panel.runner.is_live:
            self._camera = CameraRate(panel.runner)

    def handlers(self) -> Handlers:
        return {"press": self._press, "animate": self._animate, "home": self._go_home}

    def setup(self) -> dict[str, Any]:
        driver = self.panel.driver
        has_home = self.panel.go_home is not None
        return {"motors": driver.has_motors, "live": driver.is_live, "has_home": has_home}

    def state(self) -> dict[str, Any]:
        driver, record = self.panel.driver, self.panel.record
        n_resets, steps, error = record.n_resets, record.n_steps, driver.error
        return {
            "state": "closed" if self.panel.is_over else driver.state,
            "k": steps - 1,
            "steps": steps,
            "resets": n_resets,
            "t": self._time(),
            "speed": 0 if math.isinf(driver.speed) else driver.speed,
            "animate": driver.animates,
            "stage": self.panel.runner.stage,
            "error": error and trouble_of(error),
            "camera": self._camera and self._camera.told(driver.state == "running"),
            "stopped": driver.is_stopped,
        }

    def _time(self) -> float | None:
        record = self.panel.record
        try:
            return record.time_of(record.n_steps - 1) if record.n_steps else None
        except IndexError:  # it was reset meanwhile
            return None

    def take(self, step: Step) -> None:
        if self._camera is not None:
            self._camera.take(step)

    def look(self, now: float) -> float:
        is_over = self.panel.driver.state == "closed" or not self.panel.is_watched
        if self._camera is None or is_over:
            return math.inf
        if now >= self._camera.due:
            self._camera.count(now)
            self.panel.tell_state()
        return self._camera.due

    def _press(self, link: Link, message: dict[str, Any]) -> None:
        driver, button = self.panel.driver, message["button"]
        if button == "start" and driver.state == "ended" and isinstance(driver.runner, Experiment):
            raise Refused("All frames have been used. Reset begins again with the first frame.")
        if button == "stop":
            self._stop()
            return
        if button == "end":
            self.panel.stuck.end()
            return
        self.panel.check_room(2 if button == "pause" else 1)
        buttons = {
            "start": driver.start,
            "pause": driver.pause,
            "step": driver.step,
            "step_stage": driver.step_stage,
            "reset": self._reset,
            "finish": self.panel.finish,
        }
        if button not in buttons:
            raise Refused(f"unknown button {button!r}")
        done = buttons[button]()
        if done is not None:
            done.add_done_callback(self._tell_failure)

    def _reset(self) -> Future[None]:
        before = self.panel.driver.call(lambda: self.panel.record.trace)
        done = self.panel.driver.reset()
        if not isinstance(self.panel.runner, Playback):
            done.add_done_callback(lambda _: self._keep(before, done))
        return done

    def _keep(self, before: Future[Trace], reset: Future[None]) -> None:
        """Save the previous run after a reset."""
        if reset.cancelled() or reset.exception() or not len(before.result()):
            return
        try:
            file = keep(".npz", before.result().save)
        except (OSError, MemoryError) as error:
            self.panel.note(f"The previous run could not be saved: {error}")
        else:
            self.panel.note(f"The previous run is in {file}", "info")

    def _stop(self) -> None:
        """Stop the robot at once from this thread: the thread of the run may hang in a callback.

        If stopping hangs, too, the panel still works, and the next Stop tries again.
        """
        self.panel.forget("press")  # earlier presses must not move the robot after Stop
        self._stopping = [thread for thread in self._stopping if thread.is_alive()]
        if len(self._stopping) < _MOST_STOPS:
            thread = threading.Thread(target=self._stop_robot, name="robsim stop", daemon=True)
            thread.start()
            thread.join(_PATIENCE)
            self._stopping.append(thread)
        if self._stopping and self._stopping[-1].is_alive():
            self.panel.note("The robot may still be driving: its motors have not answered yet")

    def _stop_robot(self) -> None:
        try:
            self.panel.driver.stop_robot().add_done_callback(self._tell_failure)
        except BaseException as error:  # any error of the motors
            self.panel.note(f"The robot could not be stopped: {said_by(error)}")

    def _tell_failure(self, future: Future[None]) -> None:
        if not future.cancelled() and (error := future.exception()) is not None:
            self.panel.note(str(error) or type(error).__name__)

    def _go_home(self, link: Link, message: dict[str, Any]) -> None:
        if self.panel.go_home is None:
            raise Refused("this panel was not opened from the start page")
        self.panel.go_home()

    def _animate(self, link: Link, message: dict[str, Any]) -> None:
        self.panel.driver.animates = message["on"]
        self.panel.tell_state()

    def _note_stage(self, stage: str, step: Step) -> None:
        is_start = stage in AT_START
        # The next stage of the step shows the progress, so no stage is left out.
        message = {"type": "stages", "stage": stage if is_start else self.panel.runner.stage}
        self.panel.post(lambda: self.panel.send(message))


class CameraRate:
    """Statistics of a live camera: frame rate, age of the newest frame, dropped frames."""

    def __init__(self, experiment: Experiment) -> None:
        self._source = experiment._source
        self._exposed = -math.inf  # the newest frame, by the monotonic clock
        self._began: float | None = None  # when the run continued; None = it is paused
        self._grabbed: tuple[float, int] | None = None  # time, number of frames
        self._rate: float | None = None  # 1/s
        self._dropped = 0  # during the run
        self._dropped_before = 0  # the camera's count at the last look
        self.due = 0.0

    def take(self, step: Step) -> None:
        """Note the exposure time of a step's frame; in the thread of the run."""
        frame = step.frame
        if frame is not None and frame.epoch is not None and frame.t is not None:
            self._exposed = frame.epoch + frame.t

    def count(self, now: float) -> None:
        """Note the number of grabbed frames."""
        self.due = now + _GAP
        if (counts := self._source.counts) is None:
            return
        if self._grabbed is not None:
            self._rate = (counts.grabbed - self._grabbed[1]) / (now - self._grabbed[0])
        self._grabbed = now, counts.grabbed

    def told(self, is_running: bool) -> dict[str, Any]:
        """Return the field ``camera`` of the message ``state``."""
        self._count_dropped()
        now = time.monotonic()
        if is_running != (self._began is not None):
            self._began = now if is_running else None
        # Without a frame since the start, the age is the waiting time.
        age = None if self._began is None else max(0.0, now - max(self._exposed, self._began))
        return {"rate": self._rate, "age": age, "dropped": self._dropped}

    def _count_dropped(self) -> None:
        """Count frames dropped during a run; while it is paused, dropping frames is normal."""
        if (counts := self._source.counts) is not None:
            if self._began is not None:
                self._dropped += counts.dropped - self._dropped_before
            self._dropped_before = counts.dropped
