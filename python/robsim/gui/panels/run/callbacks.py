"""The list of callbacks: their owners, places and run times."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
import time
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robsim._core import Step
from robsim.base.text import said_by
from robsim.gui._driver import Playback
from robsim.gui._link import Link, Refused
from robsim.gui.panels.code_colors import code_colors
from robsim.gui.panels.editor import lab_link, open_in_editor
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.places import name_in, place_in, source_in
from robsim.gui.panels.run.make_mine import can_make, make_mine
from robsim.gui.panels.run.prints import HeardCalls
from robsim.gui.panels.settings.owners import owners_of
from robsim.simulation.callbacks.errors import callback_of
from robsim.simulation.slots import AT_START, SLOTS

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView

_GAP = 1.0  # s between two messages while it runs, and two looks while it does not
_PATIENCE = 120.0  # s that a check may take

_Slots = list[dict[str, Any]]


class Callbacks(Part):
    """Sends for each slot the owner, place, run time and last error of its callback.

    Slots hold plain Python values, which the thread of the view may read.
    """

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        assert not isinstance(panel.runner, Playback)  # which has no slots
        self._runner = panel.runner
        self._owners = owners_of(self._runner)
        self._slots = [slot for slot in SLOTS if slot in self._runner.SLOTS]
        self._times = HeardCalls()
        self._runner._time_calls(self._times)
        self._means: dict[
            str, tuple[int, float, float | None]
        ] = {}  # calls, s, ms of the newest calls
        self._opened: list[tuple[Link, subprocess.Popen[bytes]]] = []
        self._told: _Slots = []
        self._files = self._runner._from_folder
        self._due = self._may_edit = 0.0
        self._noted: set[str] = set()  # doubts
        self._is_trouble_told = False
        self._n_printed = self._n_resets = 0  # as the browsers know them
        self._beside = panel.beside("robsim check")
        self._check: subprocess.Popen[bytes] | None = None

    def handlers(self) -> Handlers:
        own = {"source": self._source, "edit": self._edit}
        return {**own, "make_mine": self._make_mine, "check": self._begin_check}

    def greet(self, link: Link) -> None:
        self._send(link, self._described())
        link.send(self._printed())

    def close(self, timeout: float) -> None:
        self._times.end()
        self._end_check()

    def take(self, step: Step) -> None:
        doubts = self._runner._doubts
        for doubt in doubts:
            if doubt not in self._noted:
                self.panel.note(doubt[:1].upper() + doubt[1:], level="warning")
        self._noted = set(doubts)
        if (trouble := self.panel.record.trouble) is not None and not self._is_trouble_told:
            self._is_trouble_told = True
            self.panel.note(f"The session cannot be written: {said_by(trouble)}", level="warning")

    def changed(self) -> None:
        if self.panel.driver.state == "closed":
            self._runner._time_calls(None)
            self._times.end()
            self._end_check()  # the view waits for this
        if self._n_resets != self.panel.record.n_resets:
            self._n_resets = self.panel.record.n_resets
            self._times.clear()
        self._tell()
        self._tell_printed()

    def look(self, now: float) -> float:
        if not any(link.is_watched for link in self.panel.links):
            return math.inf
        if now >= self._due:
            self._due = now + _GAP
            self._look_at_editors()
            self._look_at_files()
            self._tell()
            self._tell_printed()
        return self._due

    def _tell(self) -> None:
        if any(link.is_watched for link in self.panel.links):
            self._tell_gone()
        slots = self._described()
        if slots != self._told:
            self._told = slots
            for link in self.panel.links:
                if link.is_watched:
                    self._send(link, slots)

    def _tell_printed(self) -> None:
        if self._times.n_heard != self._n_printed:
            self._n_printed = self._times.n_heard
            self.panel.send(self._printed())

    def _printed(self) -> dict[str, Any]:
        return {"type": "printed", "lines": [[*line] for line in self._times.lines.copy()]}

    def _tell_gone(self) -> None:
        """Report the replacement of files that are no longer in the folder."""
        before, self._files = self._files, self._runner._from_folder
        for slot in self._slots:
            given = self._runner._given[slot]
            was_used = before.get(slot, False) is not False and (given is None or given is True)
            if slot in self._files or not was_used:
                continue
            is_off = self._owners.of(slot) == "off"
            now = f"{SLOTS[slot].title} is off" if is_off else "robsim's default replaces it"
            self.panel.note(f"{slot}.py was removed from the folder: {now}")

    def _send(self, link: Link, slots: _Slots) -> None:
        if not link.is_in_notebook:  # a page has no JupyterLab behind its address
            slots = [{**slot, "link": None} for slot in slots]
        link.send({"type": "callbacks", "slots": slots})

    def _described(self) -> _Slots:
        return [self._facts(slot) for slot in self._slots]

    def _facts(self, slot: str) -> dict[str, Any]:
        place = place_in(self._runner, slot)
        calls, ms = self._timed(slot)
        return {
            "slot": slot,
            "when": SLOTS[slot].when,
            "owner": self._owners.of(slot),
            "name": name_in(self._runner, slot),
            "file": None if place.file is None else str(place.file),
            "line": place.line,
            "link": None if place.file is None else lab_link(place.file),
            "can_edit": place.file is not None,
            "can_make": self._can_make(slot),
            "can_check": self._runner._folder is not None and slot in self._runner._from_folder,
            "ms": ms,
            "calls": calls,
            "error": self._error(slot),
        }

    def _can_make(self, slot: str) -> bool:
        is_off = self._runner._from_folder.get(slot) is False
        has_none = self._owners.why_not_mine(slot) is not None
        return (is_off or has_none) and can_make(self._runner, slot)

    def _timed(self, slot: str) -> tuple[int, float | None]:
        """Return the number of calls, and the mean run time of the newest calls (ms)."""
        calls, seconds = self._times.total(slot)
        before, spent, ms = self._means.get(slot, (0, 0.0, None))
        if calls < before:  # another callback is in the slot
            before, spent, ms = 0, 0.0, None
        if calls > before:
            ms = 1e3 * (seconds - spent) / (calls - before)
        self._means[slot] = calls, seconds, ms
        return calls, ms

    def _error(self, slot: str) -> dict[str, Any] | None:
        error = self.panel.driver.error
        failed = None if error is None else callback_of(error)
        if error is None or failed is None or failed.slot != slot:
            return None
        line = failed.source.number if failed.source else None
        return {"text": said_by(error), "line": line, "k": failed.k}

    def _source(self, link: Link, message: dict[str, Any]) -> None:
        slot = self._known(message)
        try:
            text, first = source_in(self._runner, slot)
        except OSError as error:
            raise Refused(f"{slot} cannot be read: {error}") from None
        file = place_in(self._runner, slot).file
        link.send(
            {
                "type": "source",
                "slot": slot,
                "text": text,
                "file": None if file is None else str(file),
                "first": first,
                "colors": code_colors(text),
            }
        )

    def _make_mine(self, link: Link, message: dict[str, Any]) -> None:
        """Create the user's file for the slot, show it, and open it in an editor if possible."""
        slot = self._known(message)
        if not self._can_make(slot):
            raise Refused(
                f"{slot} already has your own callback, or cannot have a callback in your folder"
            )
        self.panel.check_room()

        def done(made: Future[Path]) -> None:
            if made.cancelled():
                return
            if (error := made.exception()) is not None:
                link.refuse(f"{slot}.py was not created: {said_by(error)}")
                return
            file = made.result()
            late = slot in AT_START and slot not in self._runner._from_folder
            then = "used after Reset" if late else "used from the next step on"
            self.panel.note(f"{file} is your own, {then}", level="info")
            self._owners.look()
            self.panel.tell_setup()
            self.panel.tell_state()
            self._tell()
            self._source(link, message)
            if lab_link(file) is None:
                with suppress(Refused):  # the source is shown anyway
                    open_in_editor(file, 1)

        made = self.panel.driver.call(lambda: make_mine(self._runner, slot))
        made.add_done_callback(lambda made: self.panel.post(lambda: done(made)))

    def _begin_check(self, link: Link, message: dict[str, Any]) -> None:
        """Check a file with the doctor in a separate process, which can be ended."""
        slot, folder = self._known(message), self._runner._folder
        if folder is None or slot not in self._runner._from_folder:
            raise Refused(f"{slot} has no file in a folder, so there is nothing to check")
        if self._beside.is_busy:
            raise Refused("the previous check is still running")
        command = [sys.executable, "-m", "robsim", "check", str(folder._absolute)]
        try:
            self._check = check = subprocess.Popen(
                [*command, "--slot", slot, "--json"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
            )
        except OSError as error:
            raise Refused(f"the check could not be started: {error}") from None

        def tell(remarks: dict[str, Any] | None) -> None:
            self._check = None
            link.send({"type": "remarks", "slot": slot, **(remarks or {"said": "", "lines": []})})

        self._beside.begin(lambda: _remarks_of(check, f"{slot}.py"), tell)

    def _end_check(self) -> None:
        if (check := self._check) is not None:
            check.kill()

    def _edit(self, link: Link, message: dict[str, Any]) -> None:
        slot = self._known(message)
        place = place_in(self._runner, slot)
        if place.file is None:
            raise Refused(f"{slot} is not in a file")
        if time.monotonic() < self._may_edit:  # a second click or a held key
            return
        started = open_in_editor(place.file, place.line or 1)
        self._may_edit = time.monotonic() + _GAP
        if started is not None:
            self._opened.append((link, started))

    def _known(self, message: dict[str, Any]) -> str:
        slot: str = message["slot"]
        if slot not in self._slots:
            raise Refused(f"unknown slot {slot!r}")
        return slot

    def _look_at_files(self) -> None:
        """Forget the error of a callback after a change of the folder's files."""
        error, folder = self.panel.driver.error, self._runner._folder
        if error is None or folder is None or callback_of(error) is None:
            return
        with suppress(OSError, ValueError):  # the next start raises it again
            if folder.is_new:
                self.panel.driver.forget(error)

    def _look_at_editors(self) -> None:
        """Report editors that failed to open their file."""
        waiting = [(link, editor) for link, editor in self._opened if editor.poll() is None]
        for link, editor in self._opened:
            if editor.returncode:
                text = (
                    "Your editor could not open the file: set VISUAL to another one before you "
                    "start Python, or open the file yourself"
                )
                link.send({"type": "note", "level": "error", "text": text})
        self._opened = waiting


def _remarks_of(check: subprocess.Popen[bytes], file: str) -> dict[str, Any]:
    """Return the remarks of a check, for the whole file and for lines (number, text)."""
    try:
        printed = check.communicate(timeout=_PATIENCE)[0]
        told = json.loads(printed[printed.rfind(b"\n{\n") + 1 :])  # after prints of the callback
    except subprocess.TimeoutExpired:
        check.kill()
        with suppress(subprocess.TimeoutExpired):  # a child process may hold the pipe
            check.communicate(timeout=_GAP)
        return {"said": [f"the check was cancelled after {_PATIENCE:g} s"], "lines": []}
    except ValueError:
        return {"said": ["the check ended without a result"], "lines": []}
    said, lines = [], []
    places = [(problem["sentence"], problem.get("line") or "") for problem in told["problems"]]
    for sentence, place in [*places, *((remark, remark) for remark in told.get("remarks", ()))]:
        found = re.search(rf"\b{re.escape(file)}:(\d+)", place)
        words = re.sub(rf" \({re.escape(file)}:[^)]*\)", "", sentence.removeprefix(f"{file}: "))
        if found:
            lines.append([int(found[1]), words])
        else:
            said.append(words)
    return {"said": said or ([] if lines else ["passed all checks"]), "lines": lines}
