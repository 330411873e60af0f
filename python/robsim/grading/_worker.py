"""A worker as the grader sees it: it is started, asked, and ended; what is wrong is its fault."""

from __future__ import annotations

import pickle
import socket
import time
from collections.abc import Sequence
from contextlib import suppress
from types import TracebackType
from typing import NoReturn, Self

import numpy as np
from numpy.typing import NDArray

from robsim._base.source_line import SourceLine
from robsim._base.text import cut
from robsim.grading._errors import SubmissionError
from robsim.grading._robot_half import ROBOT_SLOTS, Setup, groups_of
from robsim.grading._start import Limits, start_worker
from robsim.grading._wire import LIMITS, Channel, Failure, Kind, Ready, WireError

_ENTRY = "robsim.grading._robot_half:work"
_ENDING = 0.2  # s that a worker whose run is over has to end by itself


class Worker:
    """The process that has the robot half of one run.

    Parameters
    ----------
    setup : Setup
        What the robot half is told.
    memory : sequence of int
        The descriptors of the memory that it sees.
    limits : Limits
        What it may take.
    isolation : str
        How it is shut in.

    Attributes
    ----------
    output : str
        What the submission has printed, cut; complete when the worker is closed.
    """

    def __init__(
        self, setup: Setup, *, memory: Sequence[int], limits: Limits, isolation: str
    ) -> None:
        self._limits = limits
        self._deadline = time.monotonic() + limits.run
        self._groups: dict[str, tuple[str, ...]] = {}
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                self._process = start_worker(
                    entry=_ENTRY, channel=theirs, memory=memory, limits=limits, isolation=isolation
                )
        except BaseException:
            ours.close()
            raise
        self._channel = Channel(ours, LIMITS)
        self._setup = setup

    @property
    def output(self) -> str:
        """What the submission has printed."""
        return self._process.output

    def ready(self) -> Ready:
        """Send the submission, wait until it is loaded, and return what it fills.

        Raises
        ------
        SubmissionError
            If it cannot be loaded, or not in time.
        """
        hello = pickle.dumps(self._setup)
        kind, body = self._asked(Kind.HELLO, hello, None, self._limits.first_call, (), None)
        if kind != Kind.READY:
            self._refuse_kind(kind, body, None, None)
        try:
            ready = Ready.from_bytes(body, ROBOT_SLOTS)
        except WireError as error:
            self.refuse(None, None, str(error))
        except ValueError as error:
            self.refuse("define_model", None, str(error))
        allowed = {*self._setup.slots}
        if "init_parameter_estimator" in allowed:  # whose updates are this stage
            allowed.add("estimate_parameters")
        foreign = {*ready.filled, *ready.switched_on} - allowed
        if foreign:
            self.refuse(min(foreign), None, "the submission must not fill this slot")
        groups = groups_of(ready.filled, self._setup.on)
        self._groups = {group[0]: group for group in groups}
        return ready

    def exchange(
        self, message: bytes, pixels: NDArray[np.uint8] | None, slot: str, k: int
    ) -> bytes:
        """Send a step as far as it is known; return it as the worker has filled it in."""
        group = self._groups.get(slot, (slot,))
        call = self._limits.first_call if k == 0 else self._limits.call
        kind, body = self._asked(Kind.STEP, message, pixels, call * len(group), group, k)
        if kind != Kind.ANSWER:
            self._refuse_kind(kind, body, slot, k)
        return body

    def _asked(
        self,
        kind: Kind,
        message: bytes,
        pixels: NDArray[np.uint8] | None,
        call: float,
        group: tuple[str, ...],
        k: int | None,
    ) -> tuple[Kind, bytes]:
        slot = group[0] if group else None
        left = self._deadline - time.monotonic()
        if left <= 0:
            self._end_late(group, k, self._limits.run, "the run")
        try:
            parts = (message,) if pixels is None else (message, pixels.data)
            self._channel.send(kind, *parts, patience=min(call, left))
            return self._channel.receive(min(call, left))
        except TimeoutError:
            is_run = left < call
            self._end_late(group, k, self._limits.run if is_run else call, "the run" * is_run)
        except WireError as error:
            self.refuse(slot, k, f"the worker has sent {error}")
        except (EOFError, OSError):
            self.refuse(slot, k, f"the worker is gone: {self._process.wait(1.0).text}")

    def _end_late(
        self, group: tuple[str, ...], k: int | None, seconds: float, what: str
    ) -> NoReturn:
        what = what or " and ".join(group) or "loading the submission"
        step = f" at step {k}" if k is not None else ""
        text = f"{what} took longer than {seconds:g} s{step}"
        raise SubmissionError(text, slot=group[0] if group else None, step=k)

    def _refuse_kind(self, kind: Kind, body: bytes, slot: str | None, k: int | None) -> NoReturn:
        """Raise what a failure says, or that something else was due."""
        if kind != Kind.ERROR:
            self.refuse(slot, k, "the worker has sent a message that is not due")
        try:
            failure = Failure.from_bytes(body, cut)
        except WireError as error:
            self.refuse(slot, k, f"the worker has sent {error}")
        named = failure.slot if failure.slot in ROBOT_SLOTS else slot
        step = k if failure.step < 0 or k is None else min(failure.step, k)
        self.refuse(named, step, failure.text, failure)

    def refuse(
        self, slot: str | None, k: int | None, what: str, failure: Failure | None = None
    ) -> NoReturn:
        """Raise SubmissionError for a slot and a step."""
        step = " at the start" if k is None or k < 0 else f" at step {k}"
        place, file, line = "", None, None
        if failure is not None and failure.file:
            file, line = failure.file, failure.line
            place = f" ({SourceLine(file, line, '').place})"
        where = f"in {slot}{step}: " if slot else ""
        raise SubmissionError(f"{where}{what}{place}", slot=slot, step=k, file=file, line=line)

    def end(self) -> None:
        """Say that the run is over, and leave a moment for what is still to be printed."""
        with suppress(OSError):
            self._channel.send(Kind.END, patience=_ENDING)
            self._process.wait(_ENDING)

    def close(self) -> None:
        """End the process, whatever it does."""
        self._channel.close()
        self._process.kill()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
