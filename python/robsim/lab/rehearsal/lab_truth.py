"""The truth of a simulated lab: the robot's pose at each tick."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robsim._core import Frame
from robsim.base.checks import Floats, check_kind


@dataclass(frozen=True, eq=False, repr=False)
class LabTruth:
    """The ticks of a simulated lab so far, at most the last million.

    The camera exposes at each tick. Row i of the arrays belongs to the tick ``first + i``.

    Attributes
    ----------
    first : int
        Number of the first tick kept.
    dt : float
        Time from tick to tick (s).
    t : array (N,)
        Times of the ticks: ``time.monotonic()`` (s).
    pose : array (N, 3)
        Pose of the robot: x, y (work-area px), heading (rad).
    last_u : array (N, 2)
        The mean input of the robot since the previous tick (V), before process
        noise. This input caused the pose of the tick:
        ``pose[i] = model.predict(pose[i-1], pose[i-2], last_u[i])``.
    hidden : array (N,) of bool
        Whether something hid the robot from the camera.
    shown : array (N,) of int
        The tick of the picture delivered for this tick: the same, except for a repeated frame.
        -1: no picture, or not yet.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     frame = camera.read()
    ...     truth = lab.truth
    >>> truth.pose[0].tolist()
    [600.0, 600.0, 0.0]
    """

    first: int
    dt: float
    t: Floats
    pose: Floats
    last_u: Floats
    hidden: NDArray[np.bool_]
    shown: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.t)

    def tick_of(self, frame: Frame) -> int:
        """Return the tick of the exposure of a lab frame.

        Parameters
        ----------
        frame : Frame
            The frame with its exposure time, as delivered by `robsim.Camera`.

        Returns
        -------
        int
            Number of the tick, from the start of the world.

        Raises
        ------
        TypeError
            If `frame` is not a Frame.
        ValueError
            If the frame has no time, or a time outside of these ticks.
        """
        check_kind("frame", frame, Frame)
        if frame.t is None or frame.epoch is None:
            raise ValueError("frame must have t and epoch, like frames of a live camera")
        row = float(frame.epoch + frame.t - self.t[0]) / self.dt
        nearest = round(row)
        if abs(row - nearest) > 0.01 or not 0 <= nearest < len(self):
            raise ValueError("frame must come from this lab, before this truth was read")
        return self.first + nearest

    def pose_of(self, frame: Frame) -> Floats:
        """Return the robot's pose at the exposure of a lab frame.

        Parameters
        ----------
        frame : Frame
            The frame, as for `tick_of`. A repeated frame shows an earlier pose, at the tick
            ``shown``.

        Returns
        -------
        array (3,)
            x, y (work-area px), heading (rad).

        Raises
        ------
        TypeError, ValueError
            Like `tick_of`.
        """
        pose: Floats = self.pose[self.tick_of(frame) - self.first]
        return pose

    def __repr__(self) -> str:
        return f"<LabTruth: {len(self)} ticks from {self.first} on, dt = {self.dt:g} s>"


def truth_of(first: int, ticks: Floats, dt: float) -> LabTruth:
    """Return the truth of the ticks of a native lab."""
    t, pose, last_u, hidden, shown = np.split(ticks, (1, 4, 6, 7), axis=1)
    arrays = t[:, 0], pose, last_u, hidden[:, 0] > 0, shown[:, 0].astype(np.int64)
    for array in arrays:
        array.flags.writeable = False
    return LabTruth(first, dt, *arrays)
