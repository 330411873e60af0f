"""The worker's side of a graded run: the robot half, with the callbacks of a submission.

Until the submission is loaded, all messages come from the grader, and are trusted.
"""

from __future__ import annotations

import dataclasses
import os
import socket
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._core import ColorClass, MarkerLayout, RecursiveLeastSquares, RobotModel
from robsim.simulation.callbacks.errors import CallbackTypeError, CallbackValueError
from robsim.simulation.options import UNLIMITED
from robsim.simulation.runner import Runner
from robsim.simulation.slots import ONCE, ROBOT, SLOTS, STEP, names
from robsim.teach.grading._frame_memory import SLOTS as FRAME_SLOTS
from robsim.teach.grading._frame_memory import slot_bytes
from robsim.teach.grading._wire import Channel, Kind, Ready
from robsim.teach.grading.answering import serving
from robsim.teach.grading.task import Frames, given_to
from robsim.teach.submissions import Rules, SubmissionFiles, load_slots
from robsim.teach.texts import ErrorText, error_text
from robsim.trace import Trace
from robsim.trace.columns import RECORDED
from robsim.vision.robots.definition import RobotDefinition

#: The possible slots of a submission in a worker, in the order of the bits of `Ready`.
ROBOT_SLOTS = names(half=ROBOT)
STAGES = names(half=ROBOT, when=STEP)


@dataclass(frozen=True, kw_only=True)
class Setup:
    """The knowledge of the robot half before the first step, and its submission."""

    submission: SubmissionFiles
    rules: Rules
    on: tuple[str, ...]  # the stages that are on in the grader
    robot: RobotDefinition
    area: tuple[int, int]
    resolution: tuple[int, int]
    colors: tuple[ColorClass, ...]
    markers: MarkerLayout
    smoothing: int | None
    model: RobotModel  # of the robot half, unless the submission defines another
    estimates_parameters: bool
    controller_seed: int  # of ``step.controller_seed``
    frames: Frames  # see `Task`


def filled_stages(callbacks: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the stages of each step that callbacks of a submission fill; True is no callback."""
    filled = {slot for slot in STAGES if callable(callbacks.get(slot))}
    has_estimator = callable(callbacks.get("init_parameter_estimator"))
    if has_estimator and callbacks.get("estimate_parameters") is not False:
        filled.add("estimate_parameters")
    filled |= {slot for slot in STAGES if type(callbacks.get(slot)) in SLOTS[slot].native}
    return tuple(slot for slot in STAGES if slot in filled)


def groups_of(filled: Sequence[str], on: Sequence[str]) -> list[tuple[str, ...]]:
    """Return groups of submitted stages without a grader's stage (of `on`) between them."""
    groups: list[list[str]] = []
    follows = False
    for stage in STAGES:
        if stage in filled:
            if not follows:
                groups.append([])
            groups[-1].append(stage)
        follows = stage in filled or (follows and stage not in on)
    return [tuple(group) for group in groups]


class RobotHalf(Runner):
    """The loop with the robot half alone; the world half is the grader's."""

    _GROUPS = RECORDED
    _AGAIN = "in the grader"

    def __init__(
        self, setup: Setup, callbacks: Mapping[str, Any], channel: Channel, memory: int | None
    ) -> None:
        self._channel = channel
        switched_on = {slot for slot in STAGES if callbacks.get(slot) is True}
        self._is_on_there = frozenset(setup.on) | switched_on
        self._default_model = setup.model
        filled = filled_stages(callbacks)
        frames = None
        if memory is not None:
            size = slot_bytes(setup.resolution)
            frames = _core.SharedFrames(memory, FRAME_SLOTS, size, setup.resolution)
        world = _core.RemoteWorld(
            self._next_message, slots=filled, frames=frames, resolution=setup.resolution
        )
        super().__init__(
            world,
            robot=setup.robot,
            area=setup.area,
            boundary="recorded",
            seed=np.random.SeedSequence(0),
            colors=setup.colors,
            markers=setup.markers,
            smoothing=setup.smoothing,
            identify_from="truth",  # all samples come from the grader
            time_limit=None,
        )
        self._core.set_controller_seed(setup.controller_seed)
        self._core.set_given(given_to(filled, setup.frames), samples=True)
        self._fill_slots(estimate_parameters=setup.estimates_parameters or None)
        for slot in self.SLOTS:
            if slot in callbacks:
                callback = callbacks[slot]
                is_default = callback is False or (callback is True and slot == "measure")
                self._set_slot(slot, None if is_default else callback)
        for stage in self._told(filled):
            self._core.set_slot(stage, world)
        self._core.set_observer(world)
        self._ready = self._readiness(callbacks, filled)

    def _told(self, filled: tuple[str, ...]) -> tuple[str, ...]:
        """Return the grader's stages whose results this half gets before its own last one."""
        last = max((STAGES.index(stage) for stage in filled), default=-1)
        native = "estimate_parameters" if self._callbacks["estimate_parameters"] is True else ""
        return tuple(
            stage
            for stage in STAGES[: max(last, 0)]
            if stage in self._is_on_there and stage not in (*filled, native)
        )

    def _readiness(self, callbacks: Mapping[str, Any], filled: tuple[str, ...]) -> Ready:
        once = (slot for slot in ROBOT_SLOTS if SLOTS[slot].when == ONCE)
        switched_on = tuple(slot for slot in STAGES if callbacks.get(slot) is True)
        return Ready(
            (*(slot for slot in once if callbacks.get(slot)), *filled),
            switched_on,
            type(self.estimator) is RecursiveLeastSquares,
            self.model,
        )

    def _next_message(self, answer: bytes) -> bytes | None:
        channel = self._channel
        kind, body = channel.exchange(Kind.ANSWER, answer) if answer else channel.receive()
        return body if kind == Kind.STEP else None

    def _default(self, slot: str) -> Any:
        return self._default_model if slot == "define_model" else None

    def _is_on(self, slot: str) -> bool:
        return slot in self._is_on_there or super()._is_on(slot)

    def run(self, steps: int | None = None, *, progress: bool | str = False) -> Trace:
        self._run(UNLIMITED, False, None)
        return self.trace

    def _change_vision(self, **changes: Any) -> NoReturn:
        raise AttributeError("a graded robot half cannot change its markers")

    def _theta_true(self) -> ArrayLike:
        return np.full((3, 5), np.nan)


def work(connection: socket.socket, memory: Sequence[int]) -> None:
    with serving(connection, _told) as (channel, setup):
        setup.submission.write_to(os.getcwd())
        callbacks = load_slots(setup.submission, setup.rules, os.getcwd())
        half = RobotHalf(setup, callbacks, channel, memory[0] if memory else None)
        channel.send(Kind.READY, half._ready.to_bytes(ROBOT_SLOTS))
        half.run()


def _told(error: BaseException) -> ErrorText:
    told = error_text(error)
    for kind, name in ((CallbackTypeError, "TypeError"), (CallbackValueError, "ValueError")):
        if type(error) is kind:
            # The error has callback, step and line anyway.
            line, _, _ = told.message.partition("\n")
            return dataclasses.replace(told, type=name, message=line.partition(": ")[2] or line)
    return told
