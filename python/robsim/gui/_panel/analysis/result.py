"""What Finish gives: the batch estimate as table and figure."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from robsim.gui._link import Link
from robsim.gui._panel.analysis.beside import Beside
from robsim.gui._panel.analysis.parameters import excitation_of, listed
from robsim.gui._panel.drawing import drawing
from robsim.gui._panel.part import Part
from robsim.identification import BatchEstimate, batch_estimate
from robsim.trace import PARAMETER_NAMES, Trace

if TYPE_CHECKING:
    from robsim.gui._panel.view import PanelView


class Result(Part):
    """Estimates the parameters from the whole record, which takes a second or so."""

    _newest: tuple[dict[str, Any], list[bytes]] | None = None
    _seen = (0, 0)  # resets and steps that it was estimated from
    _is_wanted = False

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._beside = Beside(panel, "robsim result")
        self._estimated: tuple[tuple[int, int], BatchEstimate] | None = None
        self._estimating = threading.Lock()  # of that

    def greet(self, link: Link) -> None:
        record = self.panel.record
        if self._newest is not None and self._seen == (record.n_resets, record.n_steps):
            message, pictures = self._newest
            link.send({**message, "again": True}, pictures)

    def tell(self) -> None:
        """Send the estimate to all who watch, once it is made; one at a time."""
        self._is_wanted = True
        self._begin()

    def estimate(self) -> BatchEstimate:
        """Return the estimate, made once for the same steps; any thread may call this."""
        return self._estimate(*self._record())

    def _record(self) -> tuple[tuple[int, int], Trace]:
        """Return the steps by now: resets and their number, and the trace."""
        n_resets, trace = self.panel.record.n_resets, self.panel.record.trace
        return (n_resets, len(trace)), trace

    def _estimate(self, seen: tuple[int, int], trace: Trace) -> BatchEstimate:
        if not len(trace):
            raise ValueError("nothing has run yet")
        with self._estimating:
            if self._estimated is None or self._estimated[0] != seen:
                self._estimated = seen, batch_estimate(trace)
            return self._estimated[1]

    def close(self, timeout: float) -> None:
        self._beside.wait(timeout)

    def _begin(self) -> None:
        if not self._is_wanted or self._beside.is_busy:
            return
        self._is_wanted = False
        seen, trace = self._record()
        estimate = partial(self._estimate, seen, trace)
        self._beside.begin(lambda: _result_of(estimate), lambda result: self._take(seen, result))

    def _take(
        self, seen: tuple[int, int], result: tuple[dict[str, Any], list[bytes]] | None
    ) -> None:
        if result is not None:
            self._seen, self._newest = seen, result
            message, pictures = result
            self.panel.send({**message, "again": False}, *pictures)
        self._begin()


def _result_of(estimate: Callable[[], BatchEstimate]) -> tuple[dict[str, Any], list[bytes]]:
    try:
        report = estimate()
    except ValueError as error:  # too short, or no such poses were recorded
        text = str(error)
        verdict = {"verdict": "no estimate", "good": None}
        return {"type": "result", "rows": [], "text": text, **verdict}, []
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
