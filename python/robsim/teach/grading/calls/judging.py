"""A judge in the worker: a function of a trusted module that looks at a submission's callbacks.

What it says comes back as text of the worker, of which nothing is believed: the submission may have
said it.
"""

from __future__ import annotations

import importlib
import os
import pickle
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from robsim.teach.grading._wire import LIMITS, Channel, Kind
from robsim.teach.grading._worker import Worker, done
from robsim.teach.grading.calls.answering import CallSetup
from robsim.teach.grading.calls.arrays import as_array, from_message, to_parts
from robsim.teach.grading.tasks.task import Done, Task, hidden_files
from robsim.teach.submissions import load_slots
from robsim.teach.texts import clean_text, error_text

_MOST_SAID = 1 << 14  # bytes


@dataclass(frozen=True)
class JudgeSetup(CallSetup):
    """What a worker is told that has a judge.

    Attributes
    ----------
    judge : str
        ``"module:function"``: it is called with what makes the callbacks anew, by slot, and with
        the names of the slots, and returns a text.
    """

    judge: str


def work(connection: socket.socket, memory: Sequence[int]) -> None:
    """Do what a worker is for: take a submission, let the judge look at it, send what that says."""
    channel = Channel(connection)
    kind, body = channel.receive()
    if kind != Kind.HELLO:
        raise RuntimeError("the grader must say hello")
    setup: JudgeSetup = pickle.loads(body)
    module, _, name = setup.judge.partition(":")
    judge: Callable[..., str] = getattr(importlib.import_module(module), name)
    try:
        setup.submission.write_to(os.getcwd())

        def make() -> dict[str, Any]:
            return load_slots(setup.submission, setup.rules, os.getcwd())

        said = judge(make, setup.submission.slots).encode("utf-8", "backslashreplace")
        text = np.frombuffer(said[:_MOST_SAID], np.uint8)
        channel.send(Kind.RESULT, *to_parts([as_array("text", text)]))
    except BaseException as error:  # also what ends Python
        with suppress(OSError):
            channel.send(Kind.ERROR, replace(error_text(error), slot=None).to_json())


class JudgeWorker(Worker):
    """A process in which a judge looks at a submission."""

    _ENTRY = "robsim.teach.grading.calls.judging:work"
    _LIMITS = LIMITS | {Kind.RESULT: 2 * _MOST_SAID}

    def said(self, seconds: float) -> str:
        """Return what the judge says, within so many seconds, as text that is harmless."""
        parts = [pickle.dumps(self._setup)]
        kind, body = self._asked(Kind.HELLO, parts, seconds, (), None)
        if kind != Kind.RESULT:
            self._refuse_kind(kind, body, None, None)
        try:
            (text,) = from_message(body)
        except ValueError as error:
            self.refuse(None, None, f"the worker has sent {error}")
        if text.dtype != np.uint8 or text.ndim != 1:
            self.refuse(None, None, "the worker has sent no text")
        return clean_text(text.tobytes().decode("utf-8", "replace"))


def judged(task: Task, judge: str, seconds: float) -> Done[str]:
    """Let a judge look at a submission; return what it says, which the submission may have said.

    Parameters
    ----------
    task : Task
        What is looked at.
    judge : str
        ``"module:function"`` of robsim's own.
    seconds : float
        How long it may take.

    Raises
    ------
    SubmissionError
        If nothing is said in time, or the submission fails.
    """
    limits = replace(task.limits_of_worker, run=seconds)
    with JudgeWorker(
        JudgeSetup(task.submission, task.rules, judge),
        memory=None,
        limits=limits,
        isolation=task.isolation,
        hidden=hidden_files(task.rules),
    ) as worker:
        return done(worker, lambda: worker.said(seconds))
