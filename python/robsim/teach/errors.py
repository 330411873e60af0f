"""Errors by their cause: a submission, an assignment, or the grader."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robsim.simulation import FailedCallback
    from robsim.trace import Trace

#: The causes of a submission's failure.
ERROR, TIMEOUT, EXIT = "error", "timeout", "exit"


class GradingError(Exception):
    """A failure of grading, and its place; the class names the cause.

    Parameters
    ----------
    message : str
        The whole sentence, with its place in it.
    slot : str or None
        The slot.
    step : int or None
        The step of the run; None = at the start, or earlier.
    file : str or None
        The file; ``"s003.ipynb, cell 5"`` of a notebook.
    line : int or None
        The line in it, from 1.
    cause : {"error", "timeout", "exit"}
        The kind: an error, a call or a run that took too long, or the end of the process.

    Attributes
    ----------
    slot, step, file, line, cause
        The same.
    whose : str
        ``"submission"``, ``"assignment"`` or ``"grader"``.
    """

    whose: str

    def __init__(
        self,
        message: str,
        *,
        slot: str | None = None,
        step: int | None = None,
        file: str | None = None,
        line: int | None = None,
        cause: str = ERROR,
    ) -> None:
        super().__init__(message)
        self.slot, self.step, self.file, self.line, self.cause = slot, step, file, line, cause

    @property
    def message(self) -> str:
        """The whole sentence."""
        return str(self)

    def __reduce__(self) -> tuple[partial[GradingError], tuple[()]]:
        return partial(type(self), str(self), **self._place), ()

    @property
    def _place(self) -> dict[str, Any]:
        names = ("slot", "step", "file", "line", "cause")
        return {name: getattr(self, name) for name in names}

    def _anew(self) -> GradingError:
        """Return the same without notes and traceback; `copy` keeps them where tblib is."""
        return self.__reduce__()[0]()


class SubmissionError(GradingError):
    """The submission caused the failure: it cannot be read or loaded, or it failed in a run."""

    whose = "submission"

    #: The printed output of the failed run, cut; invisible characters are escaped.
    output: str = ""
    #: The steps of the run until the failure, with the truth; None = no steps.
    trace: Trace | None = None
    #: Its place, as for a callback that fails in one process: in a run of a campaign.
    callback: FailedCallback


class AssignmentError(GradingError):
    """The assignment is wrong: a file of the teacher, the key or an option."""

    whose = "assignment"


class GraderError(GradingError):
    """The grader or its machine caused the failure, not the submission."""

    whose = "grader"
