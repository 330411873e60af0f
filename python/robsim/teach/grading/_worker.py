"""A worker from the grader's side: its start, its messages and its end; faults are its own."""

from __future__ import annotations

import pickle
import shutil
import socket
import tempfile
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

from robsim.base.values import Closing
from robsim.teach.errors import ERROR, EXIT, TIMEOUT, GraderError, SubmissionError
from robsim.teach.grading._frame_memory import FrameMemory
from robsim.teach.grading._wire import LIMITS, Channel, Kind, Ready, WireError
from robsim.teach.grading.answering import CallSetup
from robsim.teach.grading.robot_half import ROBOT_SLOTS, Setup, groups_of
from robsim.teach.grading.task import Done, Task, hidden_files, modules_with_masked
from robsim.teach.isolation import start_worker
from robsim.teach.isolation.ending import GRADER_LOST_IT
from robsim.teach.isolation.limits import as_size
from robsim.teach.texts import ErrorText, clean_text

R = TypeVar("R")

# The same for most workers, so that one zygote starts them.
_MODULES = (
    "numpy",
    *("robsim.campaigns", "robsim.control", "robsim.lab.cameras", "robsim.estimation.evaluation"),
    *("robsim.estimation.identification", "robsim.vision.imaging", "robsim.vision.robots"),
    *("robsim.simulation", "robsim.trace", "robsim.vision.markers"),
    *("robsim.teach.grading.robot_half", "robsim.teach.grading.answering"),
)
_ENDING = 2.0  # s, maximum for a worker's end after its run
_BUSY = 10.0  # times its processor time: the maximum of a call by the clock
_DYING = 5.0  # s, maximum between the end of its connection and its own end


class Worker(Closing):
    """The process with the robot half of one run; subclasses have other code and messages."""

    _ENTRY = "robsim.teach.grading.robot_half:work"
    _LIMITS = LIMITS
    _MODULES: Sequence[str] = _MODULES

    def __init__(
        self, setup: Setup | CallSetup, task: Task, memory: FrameMemory | None = None
    ) -> None:
        self.memory = memory
        self._setup = setup
        self._limits = task.limits_of_worker
        self._deadline = time.monotonic() + self._limits.run
        self._groups: dict[str, tuple[str, ...]] = {}
        # robsim loads masked parts before it closes their file, so that the rest stays usable.
        masked = [one for one in modules_with_masked(task.rules) if not one.startswith(_MODULES)]
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                self.process = start_worker(
                    entry=self._ENTRY,
                    modules=(*self._MODULES, *masked),
                    channel=theirs,
                    memory=[] if memory is None else [memory.descriptor],
                    limits=self._limits,
                    isolation=task.isolation,
                    hidden=hidden_files(task.rules),
                )
        except BaseException:
            ours.close()
            raise
        self._channel = Channel(ours, self._LIMITS)

    def ready(self) -> Ready:
        """Send the submission, and return its slots; raise SubmissionError if it fails."""
        setup = self._setup
        assert isinstance(setup, Setup)
        body = self._hello()
        try:
            ready = Ready.from_bytes(body, ROBOT_SLOTS)
        except WireError as error:
            self.refuse(None, None, f"the worker has sent {error}")
        except ValueError as error:
            self.refuse("define_model", None, str(error))
        allowed = {*setup.rules.slots}
        if "init_parameter_estimator" in allowed:  # whose updates are this stage
            allowed.add("estimate_parameters")
        if foreign := {*ready.filled, *ready.switched_on} - allowed:
            self.refuse(min(foreign), None, "the submission must not fill this slot")
        # The worker checks this, too, but within reach of the submission.
        if not setup.rules.defaults and (ready.switched_on or not ready.filled):
            self.refuse(None, None, "the submission must fill its slots with its own code")
        own, ours = ready.model, setup.model
        is_same = own.dt == ours.dt and np.array_equal(own.theta, ours.theta)
        if "define_model" not in ready.filled and not is_same:
            self.refuse("define_model", None, "the submission must not change the model")
        groups = groups_of(ready.filled, setup.on)
        self._groups = {group[0]: group for group in groups}
        return ready

    def _hello(self) -> bytes:
        message = [pickle.dumps(self._setup)]
        return self._asked(Kind.HELLO, Kind.READY, message, self._limits.first_call)

    def exchange(
        self, message: bytes, pixels: NDArray[np.uint8] | None, slot: str, k: int
    ) -> bytes:
        """Send a step as far as known; return the worker's completed step."""
        group = self._groups.get(slot, (slot,))
        call = self._limits.first_call if k == 0 else self._limits.call
        parts: list[bytes | memoryview] = [message]
        if pixels is not None:
            parts.append(pixels.data)
        return self._asked(Kind.STEP, Kind.ANSWER, parts, call * len(group), group, k)

    def _asked(
        self,
        kind: Kind,
        due: Kind,
        parts: Sequence[bytes | memoryview],
        seconds: float,
        group: tuple[str, ...] = (),
        k: int | None = None,
    ) -> bytes:
        """Send a message, and return the expected answer, with a time limit (s)."""
        slot = group[0] if group else None
        try:
            came, body = self._exchanged(kind, parts, seconds)
        except TimeoutError:
            what = " and ".join(group) or "loading the submission"
            if time.monotonic() >= self._deadline:
                what, seconds = "the run", self._limits.run
            step = f" at step {k}" if k is not None else ""
            text = f"{what} took longer than {seconds:g} s{step}"
            raise SubmissionError(text, slot=slot, step=k, cause=TIMEOUT) from None
        except WireError as error:
            self.refuse(slot, k, f"the worker has sent {error}")
        except (EOFError, OSError):
            self._refuse_death(slot, k)
        if came != due:
            self._refuse_kind(came, body, slot, k)
        return body

    def _exchanged(
        self, kind: Kind, parts: Sequence[bytes | memoryview], seconds: float
    ) -> tuple[Kind, bytes]:
        """Exchange messages; count the worker's processor time, or the clock alone."""
        begin, worked = time.monotonic(), self.process.cpu_seconds
        patience = min(seconds, max(self._deadline - begin, 1e-3))
        try:
            return self._channel.exchange(kind, *parts, patience=patience)
        except TimeoutError:
            latest = min(self._deadline, begin + _BUSY * seconds)
            while (left := worked + seconds - self.process.cpu_seconds) > 0:
                if (now := time.monotonic()) >= latest:
                    break
                with suppress(TimeoutError, WireError):  # the rest of a late message
                    return self._channel.receive(min(max(left, 0.01), latest - now))
            raise

    def _refuse_death(self, slot: str | None, k: int | None) -> NoReturn:
        ending = self.process.wait(_DYING)
        if ending is GRADER_LOST_IT:
            raise GraderError(ending.text, slot=slot, step=k)
        text = ending.text if ending.over else "its process has closed its connection"
        self.refuse(slot, k, text, EXIT if ending.exited or not ending.over else ERROR)

    def _refuse_kind(self, kind: Kind, body: bytes, slot: str | None, k: int | None) -> NoReturn:
        if kind != Kind.ERROR:
            self.refuse(slot, k, "the worker has sent an unexpected message")
        try:
            told = ErrorText.from_json(body)
        except ValueError as error:
            self.refuse(slot, k, f"the worker has sent a malformed error message: {error}")
        room = shutil.disk_usage(tempfile.gettempdir()).free
        if told.type == "OSError" and room < self._limits.folder_size:
            raise GraderError(f"the grader's disk is full: {told.message}", slot=slot, step=k)
        if told.type == "MemoryError":
            more = f"it needed more than {as_size(self._limits.memory)}"
            told = replace(told, message=f"{told.message}: {more}" if told.message else more)
        if not told.type and (slot is not None or not told.message):  # else it is a sentence
            told = replace(told, type="Exception")
        named = told.slot if told.slot in (*ROBOT_SLOTS, *self._setup.rules.names) else slot
        step = None if k is None else min(k if told.step is None else told.step, k)
        raise replace(told, slot=named, step=step).as_error() from None

    def refuse(self, slot: str | None, k: int | None, what: str, cause: str = ERROR) -> NoReturn:
        step = None if k is None or k < 0 else k
        when = "at the start" if step is None else f"at step {step}"
        where = f"{slot} {when}" if slot else when
        raise SubmissionError(f"{where}: {what}", slot=slot, step=step, cause=cause)

    def end(self) -> None:
        with suppress(OSError):
            self._channel.send(Kind.END, patience=_ENDING)
            self.process.wait(_ENDING)

    def close(self) -> None:
        self._channel.close()
        self.process.kill()


def done(worker: Worker, act: Callable[[], R]) -> Done[R]:
    """Return an act's result and the worker's output, which a SubmissionError has as ``output``."""
    try:
        result = act()
    except SubmissionError as error:
        worker.close()
        error.output = _printed_by(worker)
        raise
    worker.end()
    return Done(result, _printed_by(worker), worker.process.layers.line)


def _printed_by(worker: Worker) -> str:
    text = worker.process.output
    return clean_text(text, 2 * len(text) + 100)
