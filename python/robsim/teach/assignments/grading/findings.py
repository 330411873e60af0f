"""What the doctor finds in submissions that lose points."""

from __future__ import annotations

from contextlib import suppress

from robsim.teach.assignments.grading.references import of_submission
from robsim.teach.assignments.grading.task_runs import RunTest
from robsim.teach.assignments.results import PASSED
from robsim.teach.errors import SubmissionError
from robsim.teach.grading.calling import judged

_DOCTOR = "robsim.teach.doctor._finding:first_finding"
_SECONDS = 20.0  # that it may take
_MOST_KEPT = 100  # submissions


class Doctor:
    """The doctor, which looks at each submission once for its slots, where that is shut in."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, tuple[str, ...]], str] = {}

    def finding(self, run: RunTest, left: float) -> str:
        """Return what is wrong first with what was graded; "" = nothing, or nobody knows.

        Parameters
        ----------
        run : RunTest
            What came of its test.
        left : float
            s that are left for it.
        """
        if run.mark.status == PASSED or _is_never_loaded(run):
            return ""
        place = (of_submission(run.task.submission), run.task.rules.slots)
        if place not in self._kept:
            if len(self._kept) >= _MOST_KEPT:
                self._kept.clear()
            self._kept[place] = ""
            if left > 0:
                with suppress(SubmissionError):  # that it fails is known
                    self._kept[place] = judged(run.task, _DOCTOR, min(_SECONDS, left)).result
        return self._kept[place]


def _is_never_loaded(run: RunTest) -> bool:
    failed = run.mark.failed
    return len(failed) == run.mark.runs and all(one.step is None for one in failed)
