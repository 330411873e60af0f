"""Frames from outside the simulation."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from robsim._core import Frame, RobotModel, RobotParameters
from robsim.simulation._scene import HEADINGS

DT_TOLERANCE = 2e-3  # relative; video files round their rate

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
    """An iterable of frames, as the loop takes them.

    Parameters
    ----------
    frames : iterable of Frame
        The frames. Its attributes ``area`` and ``dt``, if it has them, say how large the work area
        is (px) and how far the frames are apart (s).

    Raises
    ------
    TypeError
        If it is not iterable.
    """

    def __init__(self, frames: Iterable[Frame]) -> None:
        if not isinstance(frames, Iterable):
            raise TypeError(f"frames must be an iterable of Frame objects, got {frames!r}")
        self.area: tuple[int, int] | None = getattr(frames, "area", None)
        self.dt: float | None = getattr(frames, "dt", None)
        self._frames = frames
        self._iterator = iter(frames)

    @property
    def comes_once(self) -> bool:
        """Whether the frames that have come can't come again."""
        return self._iterator is self._frames

    def restart(self) -> None:
        """Begin with the first frame again."""
        self._iterator = iter(self._frames)

    def take(self, k: int) -> Frame | None:
        """Return the frame of step k; None = there are no more."""
        frame = next(self._iterator, None)
        if frame is not None and not isinstance(frame, Frame):
            raise TypeError(f"frames must give Frame objects, got {frame!r} at step {k}")
        return frame

    def define_model(self) -> RobotModel:
        """Return the default model, in the time steps of the frames."""
        return RobotModel(RobotParameters() if self.dt is None else RobotParameters(dt=self.dt))

    def checked(self, define_model: Callable[[], Any]) -> Callable[[], Any]:
        """Return a define_model that refuses a model whose dt is not that of the frames."""

        @functools.wraps(define_model)
        def check() -> Any:
            model, dt = define_model(), self.dt
            if dt is None or not isinstance(model, RobotModel):
                return model
            if not math.isclose(model.dt, dt, rel_tol=DT_TOLERANCE):
                raise ValueError(
                    f"the model's dt is {model.dt:g} s, but the frames are {dt:g} s apart: give "
                    "the model that dt, or the recording another"
                )
            return model

        return check


def check_no_world(options: Mapping[str, Any]) -> None:
    """Refuse options of a simulated world beside frames that come from elsewhere."""
    for name, default in _WORLD.items():
        value = options[name]
        if not (value is default or (isinstance(value, (str, float, int)) and value == default)):
            raise ValueError(f"{name} needs a simulated world, got it with frames=...")
