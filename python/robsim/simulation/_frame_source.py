"""Frames from outside the simulation, such as recordings: the option ``frames`` of `Simulation`."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from robsim._core import Frame, RobotModel, RobotParameters
from robsim.simulation._scene import HEADINGS

DT_TOLERANCE = 2e-3  # relative; video files round their frame rate

# Options of a simulated world, and their defaults.
_WORLD = {
    "boundary": "bounce",
    "headings": HEADINGS,
    "noise": None,
    "dropout": None,
    "background": None,
    "start": None,
    "evaluate_model": None,
    "adjust_background": None,
}


class FrameSource:
    """An iterable of frames, read one per step by the loop.

    Parameters
    ----------
    frames : iterable of Frame
        The frames. The optional attributes ``area`` and ``dt`` are the size of the work area (px)
        and the time between two frames (s).

    Raises
    ------
    TypeError
        If `frames` is not iterable.
    """

    def __init__(self, frames: Iterable[Frame]) -> None:
        if not isinstance(frames, Iterable):
            raise TypeError(f"frames must be an iterable of Frame objects, got {frames!r}")
        self.area: tuple[int, int] | None = getattr(frames, "area", None)
        self.dt: float | None = getattr(frames, "dt", None)
        self._frames = frames
        self._iterator = iter(frames)

    @property
    def is_single_pass(self) -> bool:
        """Whether the frames can be read only once."""
        return self._iterator is self._frames

    def restart(self) -> None:
        """Start again with the first frame."""
        self._iterator = iter(self._frames)

    def take(self, k: int) -> Frame | None:
        """Return the frame of step k; None = no more frames."""
        frame = next(self._iterator, None)
        if frame is not None and not isinstance(frame, Frame):
            raise TypeError(f"frames must yield Frame objects, got {frame!r} at step {k}")
        return frame

    def define_model(self) -> RobotModel:
        """Return the default model, with the dt of the frames."""
        return RobotModel(RobotParameters() if self.dt is None else RobotParameters(dt=self.dt))

    def checked(self, define_model: Callable[[], Any]) -> Callable[[], Any]:
        """Return a define_model that raises if the model has another dt than the frames."""

        @functools.wraps(define_model)
        def check() -> Any:
            model, dt = define_model(), self.dt
            if dt is None or not isinstance(model, RobotModel):
                return model
            if not math.isclose(model.dt, dt, rel_tol=DT_TOLERANCE):
                raise ValueError(
                    f"the model's dt is {model.dt:g} s, but that of the frames is {dt:g} s: set "
                    "the dt of the model or of the recording"
                )
            return model

        return check


def check_no_world(options: Mapping[str, Any]) -> None:
    """Raise ValueError for options of a simulated world that are given together with frames."""
    for name, default in _WORLD.items():
        value = options[name]
        if not (value is default or (isinstance(value, (str, float, int)) and value == default)):
            raise ValueError(f"{name} is an option of a simulated world, got it with frames=...")
