"""A step as a picture for the browser, with what is drawn over it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from robsim._core import Blob, Frame, PlaneMap, Step, detect, reduced
from robsim.base.checks import Floats
from robsim.gui._frames import boxes_of, jpeg, lens_of, numbers

if TYPE_CHECKING:
    from robsim.gui.panels.record import Record


@dataclass(frozen=True)
class Shot:
    """What is shown of a step; taken in the thread of the run, used in that of the view.

    Attributes
    ----------
    frame : Frame or None
        The camera's picture; None = no frame came.
    measured, held, truth : sequence of float or None
        Poses.
    boxes : list
        ``[colour, left, top, right, bottom]`` of each blob.
    missed : str or None
        Why the robot was not found.
    past : bool
        Whether it is not the newest.
    n_resets : int
        That of the record, when it was taken.
    """

    k: int
    t: float
    frame: Frame | None
    measured: list[float] | None = None
    held: list[float] | None = None
    truth: list[float] | None = None
    estimate: dict[str, Any] | None = None
    boxes: Sequence[Sequence[Any]] = ()
    missed: str | None = None
    past: bool = False
    n_resets: int = 0

    def head(self, area: tuple[int, int]) -> dict[str, Any]:
        """Return the message about it; without a picture it shows the bare work area."""
        size, plane_map = [*area], PlaneMap()
        if self.frame is not None:
            height, width = self.frame.image.shape[:2]
            size, plane_map = [width, height], self.frame.plane_map
        return {
            "type": "frame",
            "k": self.k,
            "t": self.t,
            "size": size,
            "map": plane_map.matrix.ravel().tolist(),
            "intrinsics": lens_of(plane_map),
            "measured": self.measured,
            "held": self.held,
            "truth": self.truth,
            "estimate": self.estimate,
            "boxes": self.boxes,
            "missed": self.missed,
            "past": self.past,
        }


def shot_of(step: Step, columns: Mapping[str, Floats], n_resets: int, *, is_tracked: bool) -> Shot:
    """Return what is shown of the newest step."""
    measurement = step.measurement
    estimate = step.estimate
    detection = step.detection if is_tracked else None
    blobs = step.blobs if is_tracked else {}
    return Shot(
        k=step.k,
        t=step.t,
        frame=step.frame,
        measured=None if measurement is None else numbers(measurement.pose),
        held=row_of(columns, "pose_held", step.k) if is_tracked else None,
        truth=row_of(columns, "pose_true", step.k),
        estimate=None if estimate is None else _estimate(estimate.pose, estimate.covariance),
        boxes=boxes_of(blobs),
        missed=None if measurement or detection is None else detection.explanation,
        n_resets=n_resets,
    )


def past_shot(record: Record, k: int, frame: Frame | None) -> Shot:
    """Return what is shown of a step that is over: its blobs are found again."""
    columns = record.columns()
    measured = row_of(columns, "pose_measured", k)
    pose, covariance = (row_of(columns, name, k) for name in ("pose_estimated", "covariance"))
    is_tracked = frame is not None and "pose_measured" in columns
    blobs = record.find_blobs(frame) if frame is not None and is_tracked else {}
    is_missed = frame is not None and is_tracked and measured is None
    return Shot(
        k=k,
        t=record.time_of(k),
        frame=frame,
        measured=measured,
        held=row_of(columns, "pose_held", k),
        truth=row_of(columns, "pose_true", k),
        estimate=None if pose is None else _estimate(pose, covariance or math.nan),
        boxes=boxes_of(blobs),
        missed=_why_missed(record, frame, blobs) if frame is not None and is_missed else None,
        past=k < record.n_steps - 1,
    )


def _why_missed(record: Record, frame: Frame, blobs: Mapping[str, Sequence[Blob]]) -> str:
    """Return why the default measurement finds no robot, or that only the user's own does not."""
    found = detect(blobs, record.markers, plane_map=frame.plane_map, image=frame)
    if not record.has_own_measure:
        return found.explanation
    beside = "the default one finds the robot here"
    if found.measurement is None:
        beside = f"the default one finds none either: {found.explanation}"
    return f"your measure found no robot; {beside}"


def picture_of(frame: Frame | None, width: int) -> bytes:
    return b"" if frame is None else jpeg(reduced(frame, max(width, 1)))


def _estimate(pose: Any, covariance: Any) -> dict[str, Any] | None:
    listed = numbers(pose)
    return None if listed is None else {"pose": listed, "covariance": numbers(covariance)}


def row_of(columns: Mapping[str, Floats], name: str, k: int) -> list[float] | None:
    """Return the numbers of a step; None where they are not known."""
    if name not in columns or k >= len(columns[name]):
        return None
    return numbers(columns[name][k])
