"""The errors of measurement and estimate: their histograms over the longest valid record."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from robsim.estimation.evaluation.errors import pose_errors
from robsim.estimation.evaluation.histograms import number_of_bins, usual_limits
from robsim.gui.panels.analysis.summary import Summary
from robsim.trace import Trace
from robsim.trace.trace import longest_run

_NAMES = (("x", "px", 1.0), ("y", "px", 1.0), ("heading", "deg", math.degrees(1.0)))


class Statistics(Summary):
    """Sends mean, standard deviation and histogram of each error."""

    def message(self, trace: Trace) -> dict[str, Any]:
        part = trace[longest_valid(trace)]
        if not len(part):
            return {"type": "statistics", "first": None, "last": None, "errors": []}
        with np.errstate(over="ignore", invalid="ignore"):  # of an estimate that runs away
            errors = [*_errors(part, "measurement"), *_errors(part, "estimate")]
        first, last = int(part.k[0]), int(part.k[-1])
        return {"type": "statistics", "first": first, "last": last, "errors": errors}


def longest_valid(trace: Trace) -> slice:
    """Return the steps of the longest record without a gap in what is compared with the truth."""
    is_true = np.isfinite(trace.pose_true[:, 0])
    known = trace.seen if trace.is_tracked else np.isfinite(trace.pose_estimated[:, 0])
    return longest_run(is_true & known)


def _errors(trace: Trace, of: str) -> Iterator[dict[str, Any]]:
    if not np.isfinite(trace.poses_from(of)).any():
        return
    report = pose_errors(trace, of=of)
    bias, sd = report.bias, report.sd  # each is computed when it is asked for
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
