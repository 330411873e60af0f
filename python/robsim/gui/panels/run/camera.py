"""The camera view: the newest frame, sent as fast as the browsers receive it."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim._core import Blob, Frame, PlaneMap, Step, classify, detect, reduced
from robsim.base.checks import Floats
from robsim.gui._link import (
    SLOW,
    FrameClock,
    Link,
    boxes_of,
    jpeg,
    lens_of,
    magnified,
    numbers,
)
from robsim.gui.panels.part import Handlers, Part

if TYPE_CHECKING:
    from robsim.gui.panels.record import Record
    from robsim.gui.panels.view import PanelView


_TOLD = ("k", "t", "measured", "held", "truth", "estimate", "particles", "boxes", "missed", "past")
_MOST_PARTICLES = 300
_HIDDEN = "hidden by dropout"
_OWN_MISSED = "your measure found no robot"


@dataclass(frozen=True)
class Shot:
    """The shown data of a step: made in the thread of the run, used in the view's thread."""

    k: int
    t: float
    frame: Frame | None  # None = no frame
    measured: list[float] | None = None  # a pose, like the next two
    held: list[float] | None = None
    truth: list[float] | None = None
    estimate: dict[str, Any] | None = None
    particles: list[list[float]] | None = None  # positions
    boxes: Sequence[Sequence[Any]] = ()  # [colour, left, top, right, bottom] of each blob
    missed: str | None = None
    past: bool = False  # an older step
    n_resets: int = 0  # of the record

    def head(self, area: tuple[int, int]) -> dict[str, Any]:
        """Return the header of the message; without a picture it shows the bare work area."""
        size, plane_map = [*area], PlaneMap()
        if self.frame is not None:
            height, width = self.frame.image.shape[:2]
            size, plane_map = [width, height], self.frame.plane_map
        fields = {name: getattr(self, name) for name in _TOLD}
        seen = {"map": plane_map.matrix.ravel().tolist(), "intrinsics": lens_of(plane_map)}
        return {"type": "frame", "size": size, **seen, **fields}


def shot_of(
    step: Step, columns: Mapping[str, Floats], n_resets: int, *, is_tracked: bool, is_own: bool
) -> Shot:
    """Return the picture of the newest step; `is_own`: the user's `measure` was called."""
    measurement = step.measurement
    estimate = step.estimate
    detection = step.detection if is_tracked else None
    blobs = step.blobs if is_tracked else {}
    why = None if measurement or detection is None else detection.explanation
    is_over = step.k < len(columns.get("pose_measured", ()))
    if is_own and is_tracked and is_over and measurement is None:
        why = _OWN_MISSED
    return Shot(
        k=step.k,
        t=step.t,
        frame=step.frame,
        measured=None if measurement is None else numbers(measurement.pose),
        held=row_of(columns, "pose_held", step.k) if is_tracked else None,
        truth=row_of(columns, "pose_true", step.k),
        estimate=None if estimate is None else _estimate(estimate.pose, estimate.covariance),
        boxes=boxes_of(blobs),
        missed=_HIDDEN if why and _is_hidden(columns, step.k) else why,
        n_resets=n_resets,
    )


def particles_of(estimator: Any) -> list[list[float]] | None:
    """Return positions of some particles of a particle filter, (N, 2) or wider.

    Each position represents the same weight if the filter has `weights`.
    """
    with suppress(Exception):  # of a user's property
        return _particles_of(getattr(estimator, "__self__", estimator))
    return None


def _particles_of(owner: Any) -> list[list[float]] | None:
    particles, weights = (getattr(owner, name, None) for name in ("particles", "weights"))
    if not isinstance(particles, np.ndarray) or particles.ndim != 2 or particles.shape[1] < 2:
        return None
    n, most = len(particles), min(len(particles), _MOST_PARTICLES)
    if not n:
        return None
    if not isinstance(weights, np.ndarray) or weights.shape != (n,):
        weights = np.full(n, 1 / n)
    parts = (np.arange(most) + 0.5) / most
    chosen = np.minimum(np.searchsorted(np.cumsum(weights), parts), n - 1)
    places = particles[chosen, :2].astype(np.float64).round(1)
    return places[np.isfinite(places).all(axis=1)].tolist()  # type: ignore[no-any-return]


def past_shot(record: Record, k: int, frame: Frame | None) -> Shot:
    """Return the shown data of a past step; its blobs are found again."""
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
        missed=_why_missed(record, k, frame, blobs) if frame is not None and is_missed else None,
        past=k < record.n_steps - 1,
    )


def _is_hidden(columns: Mapping[str, Floats], k: int) -> bool:
    return "hidden" in columns and k < len(columns["hidden"]) and bool(columns["hidden"][k])


def _why_missed(record: Record, k: int, frame: Frame, blobs: Mapping[str, Sequence[Blob]]) -> str:
    """Return the reason why the default measurement or the user's measurement finds no robot."""
    if _is_hidden(record.columns(), k):
        return _HIDDEN
    found = detect(blobs, record.markers, plane_map=frame.plane_map, image=frame)
    if not record.has_own_measure:
        return found.explanation
    beside = "robsim's default finds the robot here"
    if found.measurement is None:
        beside = f"robsim's default does not either: {found.explanation}"
    return f"{_OWN_MISSED}; {beside}"


def picture_of(frame: Frame | None, width: int) -> bytes:
    return b"" if frame is None else jpeg(reduced(frame, max(width, 1)))


def _estimate(pose: Any, covariance: Any) -> dict[str, Any] | None:
    listed = numbers(pose)
    return None if listed is None else {"pose": listed, "covariance": numbers(covariance)}


def row_of(columns: Mapping[str, Floats], name: str, k: int) -> list[float] | None:
    """Return the numbers of a step; None for unknown numbers."""
    if name not in columns or k >= len(columns[name]):
        return None
    return numbers(columns[name][k])


class CameraView(Part):
    """Sends the newest step as a picture with its overlays."""

    _taken: Shot | None = None  # in the thread of the run
    _is_told = False  # whether the thread of the view knows of `_taken`
    _newest: Shot | None = None

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._clock = FrameClock()

    def setup(self) -> dict[str, Any]:
        record = self.panel.record
        return {
            "area": record.area,
            "robot": {
                "name": record.robot_name,
                "outline": record.outline.tolist(),
                "markers": [one.tolist() for one in (record.markers.polygons or {}).values()],
            },
        }

    def handlers(self) -> Handlers:
        return {"magnify": self._magnify}

    def take(self, step: Step) -> None:
        is_running, is_watched = self.panel.is_running, self.panel.is_watched
        if is_running and (
            time.monotonic() < self._clock.due if is_watched else self._taken is None
        ):
            return
        # A view that connects during a run must not show the last step of an earlier view.
        self._taken = self.panel.record.shot(step) if is_watched or not is_running else None
        if not self._is_told:  # a busy view must not queue hundreds of frames
            self._is_told = True
            self.panel.post(self._show)

    def greet(self, link: Link) -> None:
        link.shown = None
        if self._shot is None and self.panel.has_room():
            self.panel.driver.prepare()

    @property
    def _shot(self) -> Shot | None:
        """The shown step; None if it is from before a reset."""
        shot = self._newest
        return shot if shot and shot.n_resets == self.panel.record.n_resets else None

    def look(self, now: float) -> float:
        shot = self._shot
        links = [link for link in self.panel.links if link.looking is None]
        lacking = [link for link in links if link.lacks(shot)]
        if shot is None or not lacking:
            return math.inf
        if ready := [link for link in lacking if link.has_room(now)]:
            self._clock.sent(now)
            self._send(shot, ready, now)
        return math.inf if len(ready) == len(lacking) else now + SLOW

    def renew(self) -> None:
        """Take the last step of an ended run."""
        if self.panel.record.n_steps:
            self._newest = self.panel.record.shot(self.panel.runner.last_step)

    def encode(self, shot: Shot, width: int) -> bytes:
        return picture_of(shot.frame, width)

    def _magnify(self, link: Link, message: dict[str, Any]) -> None:
        """Send the pixels around a point with their classes: 0 = no class, 1 = the first class."""
        if link.frame is None:
            return
        record = self.panel.record
        box, part = magnified(link.frame.image, message)
        classes = np.zeros(part.shape[:2], np.uint8)
        if part.size and record.colors:
            markers, smoothing = record.markers, record.smoothing
            masks = classify(part, record.colors, markers=markers, smoothing=smoothing)
            for number, color in enumerate(record.colors, start=1):
                classes[masks[color.name]] = number
        head = {"type": "detail", "glass": message["glass"], "box": box}
        link.send(head, [part.tobytes(), classes.tobytes()])

    def _show(self) -> None:
        self._is_told = False  # before reading `_taken`: later steps post again
        self._newest = self._taken

    def _send(self, shot: Shot, links: list[Link], now: float) -> None:
        pictures: dict[int, bytes] = {}
        head = shot.head(self.panel.record.area)
        brings_rows = self.panel.rows.is_due(now)
        for link in links:
            if link.width not in pictures:
                pictures[link.width] = self.encode(shot, link.width)
            entries, blocks = self.panel.rows.new(link) if brings_rows else ([], [])
            link.shown, link.frame = shot, shot.frame
            link.send_frame({**head, "rows": entries}, [pictures[link.width], *blocks], now)
        self.panel.past.keep(shot, pictures)
        if brings_rows:
            self.panel.rows.sent(now, links)
