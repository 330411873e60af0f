"""Statistics of the whole record: errors and their histograms, during a run and on pause."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim.estimation.evaluation.chi_square import chi_square_band
from robsim.estimation.evaluation.consistency import nees
from robsim.estimation.evaluation.errors import (
    number_of_bins,
    pose_errors,
    usual_limits,
    wrapped_error,
)
from robsim.gui._link import Link
from robsim.gui._worker import Beside
from robsim.gui.panels.part import Part
from robsim.trace import Trace
from robsim.trace.trace import longest_run

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
_GAP = 1.0  # s
_SHARE = 0.1  # of the time at the most, while it runs


class Summary(Part):
    """Sends a message that is computed from the whole record, in a separate thread."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._newest: dict[str, Any] | None = None
        self._seen: tuple[int, int] | None = None  # resets and steps of the last result
        self._since = -math.inf  # time of the last look for new steps
        self._gap = _GAP
        self._beside = Beside(panel, f"robsim {type(self).__name__.lower()}")

    @abstractmethod
    def message(self, trace: Trace) -> dict[str, Any]:
        """Return the message; in a separate thread."""

    def greet(self, link: Link) -> None:
        if self._newest is None:
            self._since = -math.inf
        else:
            link.send(self._newest)

    def changed(self) -> None:
        self._seen, self._since = None, -math.inf

    def close(self, timeout: float) -> None:
        self._beside.wait(timeout)

    def look(self, now: float) -> float:
        if self._beside.is_busy:
            return math.inf  # until it is done
        record, is_running = self.panel.record, self.panel.is_running
        seen = record.n_resets, record.n_steps
        if self.panel.is_over:  # nothing can come later
            if seen != self._seen:
                self._seen, self._newest = seen, self.message(record.trace)
                self.panel.send(self._newest)
            return math.inf
        due = self._since + self._gap if is_running else math.inf
        if now < due and (is_running or seen == self._seen):
            return due
        if seen != self._seen and any(link.is_watched for link in self.panel.links):
            self._seen = seen
            self._begin(seen[0], record.trace)
        self._since = now
        return now + self._gap if is_running else math.inf

    def _begin(self, n_resets: int, trace: Trace) -> None:
        def timed() -> tuple[dict[str, Any], float]:
            began = time.monotonic()
            return self.message(trace), time.monotonic() - began

        def take(result: tuple[dict[str, Any], float] | None) -> None:
            if result is not None and n_resets == self.panel.record.n_resets:
                self._newest, took = result
                self._gap = max(_GAP, took / _SHARE)
                self.panel.send(self._newest)

        self._beside.begin(timed, take)


_NEES_STEPS = 300
_NEES_GAP = 10  # steps, after which errors are taken to be independent

_NAMES = (("x", "px", 1.0), ("y", "px", 1.0), ("heading", "deg", math.degrees(1.0)))


class Statistics(Summary):
    """Sends mean, standard deviation and histogram of each error."""

    def message(self, trace: Trace) -> dict[str, Any]:
        part = trace[longest_valid(trace)]
        judged = {"nees": nees_of(trace)}
        if not len(part):
            return {"type": "statistics", "first": None, "last": None, "errors": [], **judged}
        with np.errstate(over="ignore", invalid="ignore"):  # of an estimate that runs away
            errors = [*_errors(part, "measurement"), *_errors(part, "estimate")]
        first, last = int(part.k[0]), int(part.k[-1])
        return {"type": "statistics", "first": first, "last": last, "errors": errors, **judged}


def nees_of(trace: Trace) -> dict[str, Any] | None:
    """Return the mean NEES of the newest steps with its bounds; None without an estimate.

    Errors of neighbouring steps are correlated, so only every tenth step counts.
    """
    part = trace[-_NEES_STEPS:]
    error = wrapped_error(part.pose_estimated, part.pose_true)[::-_NEES_GAP]
    if not np.isfinite(part.covariance).any():
        return None
    if not np.isfinite(part.pose_true).any():
        return {"why": "unknown_truth"}
    try:
        values = nees(error, part.covariance[::-_NEES_GAP])
    except ValueError:
        return {"why": "bad_covariance"}
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    low, high = chi_square_band(3, runs=len(known)).tolist()
    mean = float(known.mean())
    verdict = "optimistic" if mean > high else "conservative" if mean < low else "consistent"
    return {"mean": mean, "n": len(known), "band": [low, high], "verdict": verdict}


def longest_valid(trace: Trace) -> slice:
    """Return the longest range of steps without gaps in the columns compared with the truth."""
    is_true = np.isfinite(trace.pose_true[:, 0])
    known = trace.seen if trace.is_tracked else np.isfinite(trace.pose_estimated[:, 0])
    return longest_run(is_true & known)


def _errors(trace: Trace, of: str) -> Iterator[dict[str, Any]]:
    if not np.isfinite(trace.poses_from(of)).any():
        return
    report = pose_errors(trace, of=of)
    bias, sd = report.bias, report.sd  # computed on access
    for axis, (name, unit, factor) in enumerate(_NAMES):
        values = factor * report.error[0, :, axis]
        known = values[np.isfinite(values)]
        mean, std = factor * bias[axis], factor * sd[axis]
        low, high = usual_limits(known)
        if np.isfinite([mean, std, low, high]).all():
            counts, _ = np.histogram(known, number_of_bins(len(known)), (low, high))
            yield {
                **{"of": of, "name": name, "unit": unit, "n": len(known), "mean": mean},
                **{"std": std, "low": low, "high": high, "counts": counts.tolist()},
            }
