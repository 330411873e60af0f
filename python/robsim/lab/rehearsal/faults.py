"""What a simulated lab is asked for and knows: the camera's faults and lens, the robot's truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim import _core
from robsim._core import Frame, Intrinsics
from robsim.base.checks import Floats, check_float, check_size
from robsim.base.text import quoted


@dataclass(frozen=True, kw_only=True)
class CameraFaults:
    """What goes wrong with a simulated camera.

    What happens to the frame of a tick depends on the seed of the scenario and the tick alone.
    Times count from the start of the world (s); it starts when the camera is first opened.

    Parameters
    ----------
    late : float
        Probability that a frame comes `late_by` later than it should. Those behind it wait.
    late_by : float
        By how much (s).
    dropped : float
        Probability that a frame never comes.
    repeated : float
        Probability that the picture before comes again, with a number and a time of its own, as
        from real cameras: it shows the robot where it was, and nothing in the frame says so.
    torn : float
        Probability that the lower part of a frame is that of the one before, or black. A camera
        knows that such a frame is not complete: `robsim.Camera` counts it and hands it to nobody.
    stall : tuple of float, optional
        Start and duration of a silence (s).
    unplug : tuple of float, optional
        Start and duration of a time without the camera (s): it fails, and cannot be opened.
    drift : float
        Amplitude of the exposure's slow change, relative to the right one, 0..1.
    drift_period : float
        Its period (s).

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names it.

    Examples
    --------
    >>> faults = robsim.lab.CameraFaults(dropped=0.05, late=0.1, unplug=(20, 3))
    """

    late: float = 0.0
    late_by: float = 0.1
    dropped: float = 0.0
    repeated: float = 0.0
    torn: float = 0.0
    stall: tuple[float, float] | None = None
    unplug: tuple[float, float] | None = None
    drift: float = 0.0
    drift_period: float = 60.0

    def __post_init__(self) -> None:
        for name in ("late", "dropped", "repeated", "torn", "drift"):
            check_float(name, getattr(self, name), minimum=0, maximum=1)
        check_float("late_by", self.late_by, "s", minimum=0, maximum=3600)
        check_float("drift_period", self.drift_period, "s", exclusive_minimum=0)
        _span("stall", self.stall)
        _span("unplug", self.unplug)

    def _native(self, seed: int) -> _core.CameraFaults:
        return _core.CameraFaults(
            late=self.late,
            lateness=self.late_by,
            dropped=self.dropped,
            repeated=self.repeated,
            torn=self.torn,
            stall=_span("stall", self.stall),
            unplugged=_span("unplug", self.unplug),
            drift=self.drift,
            drift_period=self.drift_period,
            seed=seed,
        )


def _span(name: str, value: Any) -> tuple[float, float]:
    """Return start and duration; None = nothing at any time."""
    if value is None:
        return 0.0, 0.0
    try:
        start, duration = value
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be (start, duration) in s, got {quoted(value)}") from None
    return (
        check_float(f"{name}[0]", start, "s", minimum=0),
        check_float(f"{name}[1]", duration, "s", minimum=0),
    )


@dataclass(frozen=True)
class Lens:
    """A lens that distorts radially, about the centre of the frame.

    What an ideal lens would show at the distance r from the centre, in halves of the frame's
    diagonal, appears at the distance r (1 + k1 r^2 + k2 r^4): with k1 = -0.04 the corners move in
    by 4 %.

    Parameters
    ----------
    k1, k2 : float
        The coefficients; ``Lens()`` does not distort.

    Raises
    ------
    TypeError, ValueError
        If a coefficient is not a finite number.

    Notes
    -----
    Source: D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971;
    the radial terms.
    """

    k1: float = 0.0
    k2: float = 0.0

    def __post_init__(self) -> None:
        check_float("k1", self.k1)
        check_float("k2", self.k2)

    def distorted(self, pixels: ArrayLike, size: tuple[int, int]) -> Floats:
        """Return where frames show what an ideal lens would show at these pixels.

        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Ideal pixels (u, v).
        size : tuple of int
            Width and height of the frames (px).

        Returns
        -------
        array (2,) or (N, 2)
            Pixels (u, v) of the frames.

        Raises
        ------
        TypeError, ValueError
            If an argument has another type or shape, or the lens would fold such frames over.
        """
        return self._before(size).distorted(pixels)

    def ideal(self, pixels: ArrayLike, size: tuple[int, int]) -> Floats:
        """Return where an ideal lens would show what frames show at these pixels.

        Parameters
        ----------
        pixels : array (2,) or (N, 2)
            Pixels (u, v) of the frames.
        size : tuple of int
            Width and height of the frames (px).

        Returns
        -------
        array (2,) or (N, 2)
            Ideal pixels (u, v).

        Raises
        ------
        TypeError, ValueError
            If an argument has another type or shape, or the lens would fold such frames over.
        """
        return self._before(size).ideal(pixels)

    def _before(self, size: tuple[int, int]) -> Intrinsics:
        """Return the intrinsics of a camera with frames of a size, r in halves of the diagonal."""
        width, height = check_size("size", size)
        half = math.sqrt(width * width + height * height) / 2
        middle = ((width - 1) / 2, (height - 1) / 2)
        matrix = ((half, 0, middle[0]), (0, half, middle[1]), (0, 0, 1))
        intrinsics = Intrinsics(matrix, (self.k1, self.k2, 0, 0, 0))
        if np.isnan(intrinsics.ideal((-0.5, -0.5))).any():
            raise ValueError(
                "k1 and k2 must keep the order of the pixels from the centre to the corners: with "
                "these, the lens folds the picture over within the frame"
            )
        return intrinsics


@dataclass(frozen=True, eq=False, repr=False)
class LabTruth:
    """The ticks of a simulated lab up to now, the last million at most.

    The camera exposes at each tick. Row i of the arrays is tick ``first + i``.

    Attributes
    ----------
    first : int
        Number of the first tick kept.
    dt : float
        Time from tick to tick (s).
    t : array (N,)
        When they came: ``time.monotonic()`` (s).
    pose : array (N, 3)
        Where the robot was: x, y (work-area px), heading (rad).
    last_u : array (N, 2)
        The mean of the input that the robot acted on since the tick before (V), before process
        noise. It has moved the robot here: ``pose[i] = model.predict(pose[i-1], pose[i-2],
        last_u[i])``.
    hidden : array (N,) of bool
        Whether something hid the robot from the camera.
    shown : array (N,) of int
        The tick of the picture that the camera delivered for this one: its own, but for a repeated
        frame. -1: none, or none yet.
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
        """Return the tick that a frame of this lab was exposed at.

        Parameters
        ----------
        frame : Frame
            The frame, with the time of its exposure, as `robsim.Camera` delivers it.

        Returns
        -------
        int
            Number of the tick, from the start of the world.

        Raises
        ------
        TypeError
            If `frame` is not a Frame.
        ValueError
            If it has no time, or none of these ticks.
        """
        if not isinstance(frame, Frame):
            raise TypeError(f"frame must be a Frame, got {quoted(frame)}")
        if frame.t is None or frame.epoch is None:
            raise ValueError("frame must have t and epoch, as those of a live camera have")
        row = float(frame.epoch + frame.t - self.t[0]) / self.dt
        nearest = round(row)
        if abs(row - nearest) > 0.01 or not 0 <= nearest < len(self):
            raise ValueError("frame must be of this lab, and not from after this truth was read")
        return self.first + nearest

    def pose_of(self, frame: Frame) -> Floats:
        """Return where the robot was when a frame of this lab was exposed.

        Parameters
        ----------
        frame : Frame
            The frame, as for `tick_of`. A repeated one shows another pose: that of ``shown``.

        Returns
        -------
        array (3,)
            x, y (work-area px), heading (rad).

        Raises
        ------
        TypeError, ValueError
            As `tick_of`.
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
