"""Calls of a submission's functions: arrays go to a worker and back, and are checked.

A judge is a function of a trusted module that examines callbacks in the worker. The grader never
trusts its result, a text of the worker: the submission may have written the text.
"""

from __future__ import annotations

import importlib
import os
import pickle
import socket
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from robsim._core import WorldState
from robsim.base.text import quoted
from robsim.teach.errors import ERROR, SubmissionError
from robsim.teach.grading._wire import LIMITS, Kind
from robsim.teach.grading._worker import Worker, done
from robsim.teach.grading.answering import NUMBER, CallSetup, serving, world_arrays
from robsim.teach.grading.arrays import MOST_MESSAGE, as_arrays, from_message, to_parts
from robsim.teach.grading.task import Done, Task
from robsim.teach.submissions import loaded_slots
from robsim.teach.texts import ErrorText, clean_text, error_text

_FARTHEST = 1e9  # px, rad: beyond any robot
#: A shape, with None for an axis of any length; of several results a list of shapes.
Shape = tuple[int | None, ...]


@dataclass(frozen=True)
class Wanted:
    """The conditions for the results of a call."""

    shapes: list[Shape] | None = None  # a shape for each of the results; None = any
    finite: bool = True  # whether all numbers must be finite

    def why_not(self, results: Sequence[NDArray[Any]]) -> str | None:
        if self.shapes is not None:
            if len(results) != len(self.shapes):
                wanted = "one array" if len(self.shapes) == 1 else f"{len(self.shapes)} arrays"
                return f"the result must be {wanted}, got {len(results)}"
            for array, shape in zip(results, self.shapes, strict=True):
                if not _fits(array.shape, shape):
                    told = str(shape).replace("None", "any")
                    return f"the result must be an array of shape {told}, got {array.shape}"
        if self.finite:
            for array in results:
                if array.dtype.kind == "f" and not np.isfinite(array).all():
                    return "the result must be all finite"
        return None


def _fits(shape: tuple[int, ...], wanted: Shape) -> bool:
    return len(shape) == len(wanted) and all(
        axis in (None, length) for length, axis in zip(shape, wanted, strict=True)
    )


def wanted(shape: Any, finite: bool) -> Wanted:
    if shape is None:
        return Wanted(None, finite)
    shapes = shape if isinstance(shape, list) else [shape]
    for one in shapes:
        if not isinstance(one, tuple):
            raise TypeError(f"shape must be a tuple, or a list of tuples, got {quoted(shape)}")
        for axis in one:
            if axis is not None and not (isinstance(axis, (int, np.integer)) and axis >= 0):
                raise ValueError(f"shape must contain only lengths and None, got {quoted(axis)}")
    return Wanted(list(shapes), finite)


class CallWorker(Worker):
    """A process that answers calls; it knows only the arguments of each call."""

    _ENTRY = "robsim.teach.grading.answering:work"
    _LIMITS = LIMITS | {Kind.RESULT: MOST_MESSAGE}

    def refuse(self, slot: str | None, k: int | None, what: str, cause: str = ERROR) -> NoReturn:
        if slot in self._setup.rules.functions:
            raise SubmissionError(f"{slot}: {what}", slot=slot, cause=cause)
        super().refuse(slot, k, what, cause)

    def loaded(self) -> frozenset[str]:
        """Send the submission, and return the callable names; raise SubmissionError if it fails."""
        self._names = self._setup.submission.slots
        self._called = False
        body = self._hello()
        if len(body) != len(self._names) or not {*body} <= {0, 1}:
            self.refuse(None, None, "the worker has sent a message of another length or kind")
        return frozenset(name for name, there in zip(self._names, body, strict=True) if there)

    def call(
        self, name: str, arguments: Sequence[NDArray[Any]], result: Wanted, k: int | None = None
    ) -> list[NDArray[Any]]:
        seconds = self._limits.call if self._called else self._limits.first_call
        self._called = True
        parts = [NUMBER.pack(self._names.index(name)), *to_parts(arguments)]
        body = self._asked(Kind.CALL, Kind.RESULT, parts, seconds, (name,), k)
        try:
            arrays = from_message(body)
        except ValueError as error:
            self.refuse(name, k, f"the worker has sent {error}")
        if (problem := result.why_not(arrays)) is not None:
            self.refuse(name, k, problem)
        return arrays


def calling(task: Task) -> CallWorker:
    """Return a worker that answers calls of the functions and slots of a task."""
    return CallWorker(CallSetup(task.submission, task.rules), task)


def called(
    task: Task, name: str, calls: Sequence[Sequence[NDArray[Any]]], result: Wanted
) -> Done[list[Any]]:
    """Call a function with lists of arrays; SubmissionError has the number of a failed call."""
    with calling(task) as worker:
        return done(worker, lambda: _called(worker, name, calls, result))


def _called(
    worker: CallWorker, name: str, calls: Sequence[Sequence[NDArray[Any]]], result: Wanted
) -> list[Any]:
    worker.loaded()
    results = []
    for number, arguments in enumerate(calls, 1):
        try:
            arrays = worker.call(name, arguments, result)
        except SubmissionError as error:
            if len(calls) == 1:
                raise
            message = f"{error} (in call {number} of {len(calls)})"
            raise SubmissionError(message, **error._place) from None
        values = [array[()] for array in arrays]  # an array without axes becomes a number
        results.append(values[0] if len(values) == 1 else tuple(values))
    return results


def world_slots(worker: CallWorker) -> dict[str, Callable[[Any], NDArray[Any]]]:
    """Return callbacks for a simulation here, which call the worker with arrays."""

    def evaluate_model(world: WorldState) -> NDArray[Any]:
        arrays = world_arrays(world)
        (pose,) = worker.call("evaluate_model", arrays, Wanted([(3,)]), world.k)
        if (abs(pose.astype(np.float64)) > _FARTHEST).any():
            worker.refuse("evaluate_model", world.k, f"no robot can reach {pose}")
        return pose

    def adjust_background(background: NDArray[np.uint8]) -> NDArray[Any]:
        same = Wanted([background.shape])
        (adjusted,) = worker.call("adjust_background", as_arrays("background", [background]), same)
        if adjusted.dtype != np.uint8:
            worker.refuse("adjust_background", None, "the result must be an array of uint8")
        return adjusted

    known: dict[str, Callable[[Any], NDArray[Any]]] = {
        "evaluate_model": evaluate_model,
        "adjust_background": adjust_background,
    }
    return {name: known[name] for name in worker.loaded()}


_MOST_SAID = 1 << 14  # bytes


@dataclass(frozen=True)
class JudgeSetup(CallSetup):
    """The setup of a worker with a judge."""

    #: ``"module:function"``. The function gets a maker of fresh callbacks by slot, the names of the
    #: slots, and the masks. It returns a text.
    judge: str


def work(connection: socket.socket, memory: Sequence[int]) -> None:
    def told(error: BaseException) -> ErrorText:
        return replace(error_text(error), slot=None)

    with serving(connection, told) as (channel, setup), ExitStack() as loaded:
        setup.submission.write_to(os.getcwd())
        module, _, name = setup.judge.partition(":")
        judge: Callable[..., str] = getattr(importlib.import_module(module), name)

        def make() -> dict[str, Any]:
            slots = loaded_slots(setup.submission, setup.rules, os.getcwd())
            return loaded.enter_context(slots)

        said = judge(make, setup.submission.slots, setup.rules.masked).encode(
            "utf-8", "backslashreplace"
        )
        channel.send(Kind.RESULT, said[:_MOST_SAID])


class JudgeWorker(Worker):
    """A process in which a judge, loaded before any mask, examines a submission."""

    _ENTRY = "robsim.teach.grading.calling:work"
    _LIMITS = LIMITS | {Kind.RESULT: _MOST_SAID}
    _MODULES = (*Worker._MODULES, "robsim.teach.doctor._finding")

    def said(self, seconds: float) -> str:
        """Return the judge's text, made harmless, with a time limit (s)."""
        parts = [pickle.dumps(self._setup)]
        said = self._asked(Kind.HELLO, Kind.RESULT, parts, seconds)
        return clean_text(said.decode("utf-8", "replace"))


def judged(task: Task, judge: str, seconds: float) -> Done[str]:
    """Return the text of a judge, which the submission may have written.

    The judge is ``"module:function"`` of robsim. Raise SubmissionError if the submission fails or
    exceeds the time limit (s).
    """
    short = replace(task, limits=replace(task.limits, run=seconds))
    with JudgeWorker(JudgeSetup(task.submission, task.rules, judge), short) as worker:
        return done(worker, lambda: worker.said(seconds))
