"""The task to measure: from a noisy frame to a pose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from robsim._core import DriveAround
from robsim.base.checks import check_float
from robsim.simulation import Scenario
from robsim.teach.tasks.definition import MASKED, Task
from robsim.teach.tasks.kinds.driving import AREA, DT, rms_of_poses, small_world
from robsim.teach.tasks.score import Score, scores_of
from robsim.trace import Trace
from robsim.trace.trace import check_trace
from robsim.trace.tracking import FALSE_POSE_LIMITS


@dataclass(frozen=True, kw_only=True)
class MeasureTask(Task):
    """Find the position and the heading of the robot in noisy frames, or report its absence.

    Parameters
    ----------
    noise : float
        Gaussian noise of the camera (%).
    dropout : float
        Probability that the robot is hidden, 0..1, in each of the segments of 3 steps.
    steps, runs : int
        See `Task`.

    Raises
    ------
    TypeError, ValueError
        If a parameter has the wrong type or is out of range; the message names it.

    Examples
    --------
    >>> task = robsim.teach.MeasureTask(noise=20.0)
    >>> [(score.name, score.unit) for score in task.scores]
    [('position', 'px'), ('heading', 'deg'), ('lost', '%')]
    """

    name: ClassVar[str] = "measure"
    title: ClassVar[str] = "measure the robot's pose in noisy frames"
    slots: ClassVar[tuple[str, ...]] = ("measure",)
    given: ClassVar[str] = "frames"
    scores: ClassVar[tuple[Score, ...]] = scores_of(
        ("position", "error of the position", "px", 0.55, 0.05, FALSE_POSE_LIMITS[0]),
        ("heading", "error of the heading",
         "deg", 0.45, 0.1, float(np.rad2deg(FALSE_POSE_LIMITS[1]))),
        ("lost", "frames with a false pose, or without one where the robot can be seen",
         "%", 0.0, 1e-3, 99.9, "lost"),
    )  # fmt: skip
    masked: ClassVar[tuple[str, ...]] = (*MASKED, "robsim.locate", "robsim.vision.detect")

    noise: float = 30.0
    dropout: float = 0.15

    def __post_init__(self) -> None:
        super().__post_init__()
        check_float("noise", self.noise, "%", minimum=0, maximum=100)
        check_float("dropout", self.dropout, minimum=0, maximum=1)

    @property
    def scenario(self) -> Scenario:
        """The world of the runs: a robot that drives around."""
        return small_world(
            noise=self.noise, headings=None, dropout=self.dropout, control=DriveAround()
        )

    @property
    def values(self) -> Mapping[str, Any]:
        """The time between two frames (s), the noise (%), and the positions of the markers (px)."""
        markers = self.scenario._marker_layout
        return {
            "DT": DT,
            "AREA": AREA,
            "NOISE": self.noise,
            "MARKER_DISTANCE": markers.distance,
            "MARKER_OFFSET": round(markers.offset, 6),
        }

    def score(self, trace: Trace) -> dict[str, float]:
        """Return the rms errors of all poses except false poses, and the share of lost frames."""
        check_trace(trace, "pose_true")
        is_good = trace.seen & ~trace.is_false
        is_lost = trace.is_false | ~(trace.seen | trace.hidden.astype(bool))
        return {**rms_of_poses(trace.error[is_good]), "lost": 100 * float(np.mean(is_lost))}
