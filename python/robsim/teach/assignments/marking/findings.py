"""The doctor's findings in submissions that lose points."""

from __future__ import annotations

from contextlib import suppress

from robsim.teach.assignments.marking.references import of_submission
from robsim.teach.assignments.marking.task_runs import RunTest
from robsim.teach.errors import SubmissionError
from robsim.teach.grading.calling import judged
from robsim.teach.results import PASSED

_DOCTOR = "robsim.teach.doctor._finding:first_finding"
_SECONDS = 20.0  # maximum duration


class Doctor:
    """The doctor, which examines each submission once for its slots, in a sandbox."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, tuple[str, ...]], str] = {}

    def finding(self, run: RunTest, left: float) -> str:
        """Return the first finding within the remaining time (s); "" = no finding."""
        mark = run.mark
        is_loaded = len(mark.failed) < mark.runs or any(one.step is not None for one in mark.failed)
        if mark.status == PASSED or not is_loaded:
            return ""
        place = (of_submission(run.task.submission), run.task.rules.slots)
        if place not in self._kept:
            self._kept[place] = ""
            if left > 0:
                with suppress(SubmissionError):  # its failure is known
                    self._kept[place] = judged(run.task, _DOCTOR, min(_SECONDS, left)).result
        return self._kept[place]
