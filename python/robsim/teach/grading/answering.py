"""The worker's side of calls: a function of the submission gets and returns arrays.

Until the submission is loaded, all messages come from the grader, and are trusted.
"""

from __future__ import annotations

import os
import pickle
import socket
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim._core import RobotModel, WorldState
from robsim.teach.grading._wire import Channel, Kind
from robsim.teach.grading.arrays import as_arrays, from_message, to_parts
from robsim.teach.submissions import Rules, SubmissionFiles, load_slots
from robsim.teach.texts import ErrorText, error_text

#: Before the arrays of a call: the number of the function.
NUMBER = struct.Struct("<I")


@dataclass(frozen=True)
class CallSetup:
    """The setup of a worker that answers calls."""

    #: The callable slots, in the order of their numbers.
    submission: SubmissionFiles
    rules: Rules


@contextmanager
def serving(
    connection: socket.socket, told: Callable[[BaseException], ErrorText]
) -> Iterator[tuple[Channel, Any]]:
    """Yield the channel and the setup of a worker; send the grader the error that ends its work."""
    channel = Channel(connection)
    kind, body = channel.receive()
    if kind != Kind.HELLO:
        raise RuntimeError("the grader's first message must be HELLO")
    setup = pickle.loads(body)
    try:
        yield channel, setup
    except BaseException as error:  # also SystemExit and KeyboardInterrupt
        with suppress(OSError):
            channel.send(Kind.ERROR, told(error).to_json())


def work(connection: socket.socket, memory: Sequence[int]) -> None:
    name: str | None = None

    def told(error: BaseException) -> ErrorText:
        text = error_text(error, slot=name)
        return replace(text, slot=name or text.slot)

    with serving(connection, told) as (channel, setup):
        setup.submission.write_to(os.getcwd())  # its data files, in the scratch folder
        loaded = load_slots(setup.submission, setup.rules, os.getcwd())
        names = setup.submission.slots
        channel.send(Kind.READY, bytes(callable(loaded[name]) for name in names))
        while True:
            kind, body = channel.receive()
            if kind != Kind.CALL:
                return
            name = names[NUMBER.unpack_from(body)[0]]
            arrays = from_message(memoryview(body)[NUMBER.size :])
            channel.send(Kind.RESULT, *to_parts(_called(name, loaded[name], arrays)))


def _called(name: str, function: Any, arrays: list[NDArray[Any]]) -> list[NDArray[Any]]:
    argue = _ARGUMENTS.get(name, _plain)
    result = function(*argue(arrays))
    return as_arrays("result", result if type(result) is tuple and argue is _plain else [result])


def _plain(arrays: list[NDArray[Any]]) -> list[Any]:
    return [array[()] for array in arrays]  # an array without axes becomes a number


def _world(arrays: list[NDArray[Any]]) -> list[Any]:
    """Return the record for `evaluate_model` from the arrays of `world_arrays`."""
    pose_1, pose_2, last_u, theta, times, k = arrays
    t, dt, model_dt = times.tolist()
    model = RobotModel.from_theta(theta, dt=model_dt)
    return [WorldState(pose_1, pose_2, last_u, model, k=int(k), t=t, dt=dt)]


def world_arrays(world: WorldState) -> list[NDArray[Any]]:
    model = world.model
    times = np.array([world.t, world.dt, model.dt])
    return [world.pose_1, world.pose_2, world.last_u, model.theta, times, np.array(world.k)]


_ARGUMENTS: dict[str, Callable[[list[NDArray[Any]]], list[Any]]] = {
    "evaluate_model": _world,
    "adjust_background": lambda arrays: arrays,
}
