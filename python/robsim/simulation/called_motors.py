"""The destination of the inputs of an `Experiment`."""

from __future__ import annotations

import atexit
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any
from weakref import WeakSet

import numpy as np

from robsim._core import HaltedError, MotorLink
from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted

_STOPS = 2  # how often the stop input is sent
_ATTEMPTS = 4
_all_motors: WeakSet[CalledMotors] = WeakSet()


@atexit.register
def _stop_all() -> None:
    """Stop driving motors when Python ends, such as after `step`."""
    for motors in [*_all_motors]:
        motors.stop()


def motors_of(send: Callable[[Floats], Any], stop_input: Floats | None) -> MotorLink | CalledMotors:
    """Return the link that `send` is, or a wrapper that stops the robot like a link.

    `send(u)` brings an input (2,), in V, to the robot. `stop_input` (2,), V, stops it; None =
    nothing is sent at the end. A link has its own stop: another one raises ValueError.
    """
    if not callable(send):
        raise TypeError(f"send must be callable, got {quoted(send)}")
    if not isinstance(send, MotorLink):
        return CalledMotors(send, stop_input)
    if stop_input is None or stop_input.any():
        raise ValueError(
            f"stop_input must be (0, 0), because {quoted(send)} itself tells the robot to stop, "
            f"got {quoted(stop_input)}"
        )
    return send


class CalledMotors:
    """A function that brings inputs to a robot, with the methods of a `MotorLink` (`motors_of`)."""

    _has_moved = False  # an input was sent since the last stop input
    _is_halted = False
    _error: BaseException | None = None  # of the last stop

    def __init__(self, send: Callable[[Floats], Any], stop_input: Floats | None) -> None:
        self._send = send
        self._stop_input = stop_input
        self._process = os.getpid()
        _all_motors.add(self)

    def __del__(self) -> None:
        self.stop()

    def resume(self) -> None:
        """Accept inputs from now on."""
        self._process = os.getpid()
        self._is_halted = False

    def __call__(self, u: Floats) -> None:
        """Send an input; HaltedError if the robot was halted in this run."""
        if self._is_halted:
            raise HaltedError("the robot was stopped and takes no input before the next run")
        self._has_moved = True  # even after a failure, as the input may have arrived
        self._send(u)

    def halt(self) -> None:
        """Stop the robot from any thread; the run sends no more inputs, and stops it again."""
        self._is_halted = True
        if not self._must_stop:
            return
        for _ in range(_STOPS):
            with suppress(BaseException):  # the end of the run reports the error
                self._send(np.array(self._stop_input))

    def stop(self) -> Floats | None:
        """Send the stop input, unless it was the last input; return the sent input.

        It is sent twice, as a line may lose it, and sent again after a failure. It raises nothing:
        `_check_stop` does. A Ctrl-C does not prevent sending, and is delivered afterwards.
        """
        if not self._must_stop:
            return None
        failure: BaseException | None = None
        n_sent = 0
        for _ in range(_ATTEMPTS):
            try:
                self._send(np.array(self._stop_input))
                n_sent += 1
            except KeyboardInterrupt as error:
                self._error = error
            except BaseException as error:
                failure = error
            if n_sent == _STOPS:
                break
        if n_sent == 0:
            self._error = failure
            return None
        self._has_moved = False
        return self._stop_input

    def _check_stop(self) -> None:
        """Raise, once, the error of stopping the robot."""
        if self._error is not None:
            error, self._error = self._error, None
            raise error

    @property
    def can_halt(self) -> bool:
        """Whether an input that stops the robot is set."""
        return self._stop_input is not None

    @property
    def _must_stop(self) -> bool:
        # A forked process ends; the robot is its parent's.
        return self.can_halt and self._has_moved and self._process == os.getpid()


def stop_input_value(stop_input: Sequence[float] | None) -> Floats | None:
    """Return the option ``stop_input`` as an array (2,); None = nothing is sent."""
    if stop_input is None:
        return None
    u = as_float_array("stop_input", stop_input)
    if u.shape != (2,) or not np.isfinite(u).all():
        raise ValueError(
            f"stop_input must be (u1, u2), finite, in V, or None, got {quoted(stop_input)}"
        )
    return u
