"""The result of Finish: the batch estimate as table and figure."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from robsim.base.checks import Floats
from robsim.estimation.identification.batch import BatchEstimate, batch_estimate, judged
from robsim.estimation.identification.determined import Identifiability
from robsim.gui._link import Link
from robsim.gui._worker import Beside, drawing
from robsim.gui.panels.analysis.statistics import Summary
from robsim.gui.panels.part import Part
from robsim.trace import PARAMETER_NAMES, Trace

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
_MOST_ROWS = 5000  # for judging noise and excitation


class Parameters(Summary):
    """Sends the newest estimates, and how well the run determines them."""

    def message(self, trace: Trace) -> dict[str, Any]:
        values = _last_known(trace.parameters)
        known = None if values is None else judged(trace[-_MOST_ROWS:])
        return {
            "type": "parameters",
            "names": PARAMETER_NAMES,
            "values": None if values is None else listed(values),
            "errors": None if known is None else listed(known.standard_errors),
            "excitation": excitation_of(known),
        }


def listed(numbers: ArrayLike) -> list[float | None]:
    return [x if np.isfinite(x) else None for x in np.ravel(numbers).tolist()]


def _last_known(parameters: Floats) -> Floats | None:
    known = np.flatnonzero(np.isfinite(parameters[-_MOST_ROWS:]).all(axis=(1, 2)))
    return parameters[-_MOST_ROWS:][known[-1]] if len(known) else None


def excitation_of(judged: Identifiability | None) -> dict[str, Any]:
    """Return the verdict on the excitation; its text is empty while nothing is known."""
    if judged is None or np.isnan(judged.relative).all():
        return {"text": "", "good": None, "weak": []}
    poorly, not_at_all = judged.names("poorly"), judged.names("not excited")
    weak = [name for name in PARAMETER_NAMES if name in {*poorly, *not_at_all}]
    return {"text": _excitation_text(poorly, not_at_all), "good": not weak, "weak": weak}


def _excitation_text(poorly: list[str], not_at_all: list[str]) -> str:
    counts = [(len(not_at_all), "not excited"), (len(poorly), "poorly excited")]
    parts = [f"{count} {words}" for count, words in counts if count]
    if not parts:
        return "all parameters are sufficiently excited"
    return f"of {len(PARAMETER_NAMES)} parameters {', '.join(parts)}: drive in another way"


Steps: TypeAlias = tuple[int, int]  # resets, and steps since
Told: TypeAlias = tuple[dict[str, Any], list[bytes]]  # message and pictures


class Result(Part):
    """Estimates the parameters from the whole record, which takes about a second."""

    _newest: Told | None = None
    _seen: Steps = (0, 0)  # used for the estimate
    _is_wanted = False

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._beside = Beside(panel, "robsim result")
        self._estimated: tuple[Steps, BatchEstimate] | None = None
        self._estimating = threading.Lock()  # guards the estimate

    def greet(self, link: Link) -> None:
        if self._newest is not None and self._seen == self._steps:
            message, pictures = self._newest
            link.send({**message, "again": True}, pictures)

    def tell(self) -> None:
        """Send the finished estimate to all views; one estimate at a time."""
        self._is_wanted = True
        self._begin()

    def estimate(self) -> BatchEstimate:
        """Return the estimate, computed once for the same steps; any thread may call this."""
        return self._estimate()[1]

    @property
    def _steps(self) -> Steps:
        record = self.panel.record
        return record.n_resets, record.n_steps

    def _estimate(self) -> tuple[Steps, BatchEstimate]:
        with self._estimating:  # also the steps: an older estimate never replaces a newer one
            n_resets, trace = self.panel.record.n_resets, self.panel.record.trace
            seen = n_resets, len(trace)
            if not len(trace):
                raise ValueError("nothing has run yet")
            if self._estimated is None or self._estimated[0] != seen:
                self._estimated = seen, batch_estimate(trace)
            return self._estimated

    def settle(self) -> None:
        """Wait until all requested estimates are computed and drawn."""
        self._beside.wait()

    def close(self, timeout: float) -> None:
        self._beside.wait(timeout)

    def _begin(self) -> None:
        if not self._is_wanted or self._beside.is_busy:
            return
        self._is_wanted = False
        self._beside.begin(self._compute, self._take)

    def _compute(self) -> tuple[Steps, Told]:
        try:
            seen, report = self._estimate()
        except ValueError as error:  # too short, or no such poses were recorded
            verdict = {"verdict": "no estimate", "good": None}
            return self._steps, ({"type": "result", "rows": [], "text": str(error), **verdict}, [])
        return seen, _told(report)

    def _take(self, result: tuple[Steps, Told] | None) -> None:
        if result is not None and result[0][0] == self.panel.record.n_resets:
            self._seen, self._newest = result
            message, pictures = self._newest
            self.panel.send({**message, "again": False}, *pictures)
        self._begin()


def _told(report: BatchEstimate) -> Told:
    excitation = excitation_of(report.identifiability)
    message = {
        "type": "result",
        "rows": _rows_of(report),
        "text": "\n".join((report.title, *report.remarks)),
        "verdict": excitation["text"],
        "good": excitation["good"],
    }
    return message, [_figure_of(report)]


def _rows_of(report: BatchEstimate) -> list[list[Any]]:
    columns = (report.theta_true, report.batch, report.standard_errors, report.online)
    return [[*row] for row in zip(PARAMETER_NAMES, *map(listed, columns), strict=True)]


def _figure_of(report: BatchEstimate) -> bytes:
    from robsim.plotting import plot_batch  # matplotlib takes its time to load

    with drawing:
        axes: Any = plot_batch(report)
        picture: bytes = axes._repr_png_()
    return picture
