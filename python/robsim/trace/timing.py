"""Regularity of a run's frames, and delay of its inputs: `Trace.timing`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats, check_float
from robsim.base.report import Column, Quantity, Report, Row, Table, count

_ROWS = ("from exposure to arrival", "from arrival to input", "from exposure to input")
_MOST_JITTER = 0.2  # of dt: filters and fits count in whole steps
_MOST_OFF = 0.05  # of dt
_OTHER_RATE = 0.7  # of the model's
_SAME = 0.8  # share of intervals that make a multiple of dt the rate


@dataclass(frozen=True, kw_only=True, eq=False)
class TimingReport(Report):
    """The regularity of the frames and the delay of the inputs in a run.

    Attributes
    ----------
    dt : float
        Time of a step of the model (s).
    steps : int
        Steps of the record.
    rate : float
        Frames per second, the median; NaN for a single frame.
    jitter : float
        Standard deviation of the time between the exposures of consecutive frames (s).
    lost : int
        Frames missing between two others, at the actual rate.
    stopped : int
        Number of stops of the robot; the time until the next frame is not counted.
    interval : float
        Median time between frames, in a whole number of steps, for one step (s): dt if the frames
        come at the rate of the model; NaN for a single frame.
    latency : array (3, 3)
        Time from the exposure of a frame to its arrival, from the arrival to the input's sending,
        and both together (s); columns median, 95 % quantile, maximum. NaN = not known.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     report = robsim.Experiment(camera).run(5).timing()
    >>> report.steps
    5
    """

    dt: float
    steps: int
    rate: float
    jitter: float
    lost: int
    stopped: int
    interval: float
    latency: Floats

    @property
    def title(self) -> str:
        """The subject of the report: the frames and inputs."""
        return "Timing"

    @property
    def motor_delay(self) -> float:
        """The median time from the exposure of a frame to the sending of the input, in steps of dt.

        Use this value as `motor_delay` of a simulated world, of filters and of fits.
        """
        return float(self.latency[2, 0] / self.dt)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Frames and their intervals, and the delay of the inputs."""
        return (
            Quantity("steps", "steps", self.steps),
            Quantity("rate", "frame rate", self.rate, "1/s", ".4g"),
            Quantity("jitter_ms", "jitter", 1e3 * self.jitter, "ms", ".3g"),
            Quantity("lost", "lost frames", self.lost, format=lambda n: count(n, n + self.steps)),
            Quantity("stopped", "stops", self.stopped),
            Quantity("motor_delay", "motor delay", self.motor_delay, "steps", ".3g"),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """Latencies in ms, and the median in steps."""
        columns = (
            Column("median_ms", "median", "ms"),
            Column("most_ms", "95 % below", "ms"),
            Column("maximum_ms", "maximum", "ms"),
            Column("median_steps", "median", "steps", ".3g"),
        )
        rows = [
            Row(title, (*(1e3 * times), times[0] / self.dt))
            for title, times in zip(_ROWS, self.latency, strict=True)
        ]
        return (Table(key="latency", columns=columns, rows=rows, row_title="latency"),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """The latency's omissions, and timing problems."""
        remarks = []
        if self.jitter > _MOST_JITTER * self.dt:
            remarks.append(
                "the frames come irregularly: filters and fits round the time between two frames "
                f"to whole steps of {self.dt:g} s"
            )
        if self.rate * self.dt < _OTHER_RATE:
            remarks.append(
                f"{self.rate:.3g} frames/s come, not {1 / self.dt:.3g}: the camera is slower "
                "(in dim light webcams halve their rate), or callbacks take longer than a step; "
                f"set the camera's fps={self.rate:.3g}, or add light"
            )
        elif abs(self.interval - self.dt) > _MOST_OFF * self.dt:
            remarks.append(
                f"a step takes {self.interval:.3g} s, not the {self.dt:g} s of the model, so that "
                "predictions and speeds are off: set this dt in the model, or the rate of the "
                "camera"
            )
        if self.latency[2, 1] - self.latency[2, 0] > _MOST_JITTER * self.dt:
            remarks.append(
                "the motor delay varies; filters and fits use the same delay for each step"
            )
        if math.isfinite(self.motor_delay):
            remarks.append(
                "motor delay: use it for a simulated world, for filters and for "
                "batch_estimate; it excludes the delays of the line and of the motors. For the "
                "sum, use "
                "batch_estimate(trace, method='output_error', motor_delay='fit')"
            )
        return tuple(remarks)


def timing_report(
    t: Floats, t_arrival: Floats, t_sent: Floats, *, interrupted: NDArray[np.bool_], dt: float
) -> TimingReport:
    """Return the report of a run, from times (N,) in s; NaN = not known.

    The times are of the exposure and arrival of frames, and of sent inputs. `interrupted` (N,): the
    robot was stopped after the previous step. `dt` is the model's time of a step (s).
    """
    intervals = np.diff(t)[~interrupted[1:]]
    n_steps = np.maximum(np.rint(intervals / dt), 1)
    multiple = float(np.median(n_steps)) if len(n_steps) else 1.0
    if np.count_nonzero(n_steps == multiple) <= _SAME * len(n_steps):
        multiple = 1.0
    follow_each_other = intervals[n_steps == multiple]
    return TimingReport(
        dt=dt,
        steps=len(t),
        rate=1 / float(np.median(follow_each_other)) if len(follow_each_other) else np.nan,
        jitter=float(np.std(follow_each_other)) if len(follow_each_other) else np.nan,
        lost=int(np.maximum(np.rint(n_steps / multiple) - 1, 0).sum()),
        stopped=int(interrupted.sum()),
        interval=float(np.median(intervals / n_steps)) if len(intervals) else np.nan,
        latency=np.array([_spread(x) for x in (t_arrival - t, t_sent - t_arrival, t_sent - t)]),
    )


def _spread(times: Floats) -> tuple[float, float, float]:
    """Return the median, the 95 % quantile and the maximum; NaN without a time."""
    known = times[np.isfinite(times)]
    if not len(known):
        return np.nan, np.nan, np.nan
    return float(np.median(known)), float(np.quantile(known, 0.95)), float(known.max())


MAXIMUM_DELAY = 1000  # steps


def check_delay(name: str, delay: Any) -> float:
    return check_float(name, delay, "steps", minimum=0, maximum=MAXIMUM_DELAY)


def delayed(u: Floats, delay: float) -> Floats:
    """Return mean inputs (N, 2), V, that act in each step, `delay` steps late; 0 at first."""
    n = math.floor(delay)
    f = delay - n
    # row k has u(k - n - 1)
    past = np.vstack((np.zeros((n + 1, 2)), u))[: len(u) + 1]
    # u_acting(k) = (1 - f) u(k - n) + f u(k - n - 1), with the delay n + f
    return np.asarray((1 - f) * past[1:] + f * past[:-1])
