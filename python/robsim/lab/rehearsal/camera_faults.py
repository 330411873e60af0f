"""The faults of a simulated camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robsim import _core
from robsim.base.checks import check_float
from robsim.base.text import quoted


@dataclass(frozen=True, kw_only=True)
class CameraFaults:
    """The faults of a simulated camera.

    The faults of a frame depend only on the scenario's seed and the number of the tick. Times count
    from the start of the world (s). The world starts when the camera is first opened.

    Parameters
    ----------
    late : float
        Probability that a frame is delayed by `late_by`. Later frames wait.
    late_by : float
        Delay of late frames (s).
    dropped : float
        Probability that a frame is lost.
    repeated : float
        Probability that the previous picture is sent again, with a new number and time. This fault
        also occurs in real cameras: the frame shows an old position without any sign.
    torn : float
        Probability that the lower part of a frame is from the previous frame, or black. A camera
        reports that such a frame is incomplete: `robsim.Camera` counts and discards the frame.
    stall : tuple of float, optional
        Start and duration of a silence (s).
    unplug : tuple of float, optional
        Start and duration of a disconnection (s): the camera fails, and cannot be opened.
    drift : float
        Amplitude of a slow change of the exposure, relative to the correct exposure, 0..1.
    drift_period : float
        Its period (s).

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names it.

    Examples
    --------
    >>> faults = robsim.lab.CameraFaults(dropped=0.05, late=0.1, unplug=(20, 3))
    >>> faults.dropped, faults.late, faults.unplug
    (0.05, 0.1, (20, 3))
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
    """Return start and duration; None = never."""
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
