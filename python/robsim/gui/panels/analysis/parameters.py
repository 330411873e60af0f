"""The estimated parameters: values, standard errors, excitation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robsim.base.checks import Floats
from robsim.estimation.identification.batch import batch_estimate
from robsim.estimation.identification.determined import Identifiability, identifiability
from robsim.gui.panels.analysis.summary import Summary
from robsim.trace import PARAMETER_NAMES, NotRecordedError, Trace

_MOST_ROWS = 5000  # that noise and excitation are judged from


class Parameters(Summary):
    """Sends the newest estimates, and how well the run determines them."""

    def message(self, trace: Trace) -> dict[str, Any]:
        values = _last_known(trace.parameters)
        judged = None if values is None else _judged(trace[-_MOST_ROWS:])
        return {
            "type": "parameters",
            "names": PARAMETER_NAMES,
            "values": None if values is None else listed(values),
            "errors": None if judged is None else listed(judged.standard_errors),
            "excitation": excitation_of(judged),
        }


def listed(numbers: ArrayLike) -> list[float | None]:
    return [x if np.isfinite(x) else None for x in np.ravel(numbers).tolist()]


def _last_known(parameters: Floats) -> Floats | None:
    known = np.flatnonzero(np.isfinite(parameters[-_MOST_ROWS:]).all(axis=(1, 2)))
    return parameters[-_MOST_ROWS:][known[-1]] if len(known) else None


def _judged(trace: Trace) -> Identifiability | None:
    """Return how well the estimates are known; of an estimator that does not say, the samples."""
    try:
        return identifiability(trace)
    except NotRecordedError:
        pass
    try:
        return batch_estimate(trace).identifiability
    except ValueError:  # too few samples as yet
        return None


def excitation_of(judged: Identifiability | None) -> dict[str, Any]:
    """Return the verdict on the excitation; its text is empty where nothing is known yet."""
    if judged is None or np.isnan(judged.relative).all():
        return {"text": "", "good": None, "weak": []}
    poorly, not_at_all = judged.names("poorly"), judged.names("not excited")
    weak = [name for name in PARAMETER_NAMES if name in {*poorly, *not_at_all}]
    return {"text": _excitation_text(poorly, not_at_all), "good": not weak, "weak": weak}


def _excitation_text(poorly: list[str], not_at_all: list[str]) -> str:
    counts = [(len(not_at_all), "not excited"), (len(poorly), "poorly excited")]
    parts = [f"{count} {words}" for count, words in counts if count]
    if not parts:
        return "all parameters are well excited"
    return f"of {len(PARAMETER_NAMES)} parameters {', '.join(parts)}: drive in another way"
