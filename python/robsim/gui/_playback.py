"""Plays a record back: what a `Driver` drives where nothing runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robsim._core import Step

if TYPE_CHECKING:
    from robsim.gui.panels.record import Record


class Playback:
    """Goes through the steps of a record, which stays as it is.

    It has of a `Simulation` what a `Driver` needs. It stands at the last step, as a run does that
    is over; the next `step` gives the first one.
    """

    SLOTS = ()  # a record calls nothing
    stage = "world"

    def __init__(self, record: Record) -> None:
        self._record = record
        self._at = self.n_steps - 1
        self._next = 0
        self._shown: Step | None = None

    @property
    def n_steps(self) -> int:
        return self._record.n_steps

    @property
    def last_step(self) -> Step:
        """The step that is shown."""
        if self._shown is None:
            self._shown = self._step(self._at)
        return self._shown

    def step(self) -> Step:
        """Go to the next step; EOFError after the last one, after which it begins again."""
        if self._next >= self.n_steps:
            self._next = 0
            raise EOFError("the record is over")
        self.seek(self._next)
        return self.last_step

    def step_stage(self) -> str:
        """Go to the next step: a record has no stages."""
        self.step()
        return self.stage

    def seek(self, k: int) -> None:
        self._at, self._next, self._shown = k, k + 1, None

    def _step(self, k: int) -> Step:
        try:
            frame = self._record.frame(k)
        except LookupError:
            frame = None
        return self._record.step(k, frame)

    def reset(self) -> None:
        self.seek(0)

    def stop(self) -> bool:
        """Do nothing: a step takes no time that could be cut."""
        return False
