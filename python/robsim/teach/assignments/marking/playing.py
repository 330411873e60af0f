"""`play_run`: the repetition of a test's run, for an appeal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from robsim.base.checks import Floats, check_int, check_text
from robsim.base.files import as_path, write_whole
from robsim.base.report import Column, Report, Row, Table
from robsim.base.spelling import check_names
from robsim.teach.assignments.assignment import Assignment, TaskTest, check_is_assignment
from robsim.teach.assignments.classes.store import ResultFolder
from robsim.teach.assignments.classes.submissions import check_is_one, one_submission
from robsim.teach.assignments.marking.references import References, numbers_of, seeds_of
from robsim.teach.assignments.marking.task_runs import files_for, graded_task
from robsim.teach.errors import SubmissionError
from robsim.teach.grading.graded_run import graded_run
from robsim.teach.submissions.reading import open_submission
from robsim.teach.texts import clean_text
from robsim.trace import Trace


def picture_of(test: TaskTest, trace: Trace, reference: Trace | None) -> tuple[bytes, str]:
    """Return a run of a submission next to the reference's, as PNG, and its description."""
    from robsim.plotting.beside import as_png, draw_run  # matplotlib takes its time

    task = test.task
    figure, caption = draw_run(
        trace, reference, slots=task.slots, goals=task.goals, unscored=task.unscored
    )
    return as_png(figure), caption


def path_of(trace: Trace) -> list[list[float]]:
    path: Floats = trace.pose_true[:, :2]
    rounded: list[list[float]] = path.round(1).tolist()
    return rounded


@dataclass(frozen=True, kw_only=True)
class PlayedRun(Report):
    """A repeated run of a test; its key makes the run identical to the graded run.

    Attributes
    ----------
    test : TaskTest
        The test.
    student : str
        The student.
    run : int
        Its number.
    trace : Trace
        The run, with the truth.
    numbers : mapping of str to float
        Its scores; empty if it failed.
    failed : str
        The submission's failure in the run, as in grading; "" = no failure.
    reference : Trace or None
        The run of the reference in the same world; None = no reference available.
    reference_numbers : mapping of str to float
        Its scores.
    output : str
        The printed output of the submission.
    files : tuple of Path
        Its trace and picture, if they were written.
    remarks : tuple of str
        The reasons of its failure and of the choice of this run.

    Examples
    --------
    A solution that does not turn at the goal:

    >>> import shutil
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> folder = shutil.copytree("hw1/solutions/park/wrong/naive", "ann")
    >>> played = robsim.teach.play_run(assignment, "ann", "public", run=0)
    >>> [round(one["heading"], 1) for one in (played.numbers, played.reference_numbers)]  # deg
    [27.9, 2.4]
    """

    test: TaskTest
    student: str
    run: int
    trace: Trace
    numbers: Mapping[str, float]
    reference: Trace | None
    reference_numbers: Mapping[str, float]
    output: str
    failed: str = ""
    files: tuple[Path, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """The student, the test and the number of the run."""
        return f"{self.student}, {self.test.name}, run {self.run}"

    @property
    def tables(self) -> Sequence[Table]:
        """The scores of the run and of the reference, if the run was completed."""
        if self.failed:
            return ()
        columns = (
            Column("value", "this run"),
            Column("reference", "reference"),
            Column("ratio", "ratio", "", ".3g"),
        )
        rows = [
            Row(score.title, (value, other, value / other if other else None), unit=score.unit)
            for score in self.test.task.scores
            for value, other in [(self.numbers[score.name], self.reference_numbers[score.name])]
        ]
        return (Table(key="scores", columns=columns, rows=rows, row_title="score"),)

    def picture(self) -> bytes:
        """Return a PNG picture of the run next to the reference's run."""
        return picture_of(self.test, self.trace, self.reference)[0]


def play_run(
    assignment: Assignment,
    submission: str | PathLike[str],
    test: str,
    run: int | None = None,
    out: str | PathLike[str] | None = None,
    *,
    student: str | None = None,
) -> PlayedRun:
    """Repeat a run of a test with the same world, noise and numbers, for example for an appeal.

    Parameters
    ----------
    assignment : Assignment
        The assignment that graded the submission.
    submission : path
        The submission.
    test : str
        The name of the test.
    run : int, optional
        The number of the run, from 0. Default: the worst run of the results in `out`, or 0.
    out : path, optional
        The folder of `grade_class`, for the files `PlayedRun.files`.
    student : str, optional
        See `grade_submission`.

    Returns
    -------
    PlayedRun
        The run with its trace, and the reference's run.

    Raises
    ------
    SubmissionError
        If the submission fails before the first step, with slot and line. After a later failure,
        the run has all steps up to the failure, and `failed` names the reason.
    AssignmentError, FileNotFoundError, TypeError, ValueError, OSError
        As `grade_submission`.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("ann").mkdir()
    >>> size = pathlib.Path("ann/measure.py").write_text("def measure(step): return None")
    >>> played = robsim.teach.play_run(assignment, "ann", "public", run=0)
    >>> len(played.trace), int(played.trace.seen.sum())
    (60, 0)
    """
    check_is_assignment(assignment)
    tests = {one.name: one for one in assignment.tests}
    handed = one_submission(submission, assignment)
    check_is_one(handed, assignment)
    name = handed.student if student is None else check_text("student", student)
    named = [check_text("test", test)]
    check_names(f"{assignment.name} has no test by a task", named, tests, ValueError)
    one = tests[test]
    folder = None if out is None else ResultFolder(as_path(out, "out"))
    remarks = []
    if run is None and (run := _worst(folder, name, test)) is None:
        run = 0
        remarks.append("run 0, because the worst run is unknown without results")
    check_int("run", run, minimum=0, maximum=one.task.runs - 1)
    files: tuple[Path, ...] = ()
    if folder is not None:
        files = tuple(folder.of(name) / f"{test}-run{run}{kind}" for kind in (".npz", ".png"))
    contents = open_submission(handed.path, assignment._rules(), handed.files)
    task = graded_task(assignment, one, files_for(assignment, one, contents))
    seeds = seeds_of(assignment, one, name, run)
    failed, numbers = "", {}
    try:
        graded = graded_run(task, one.task.scenario, one.task.steps, seeds)
        trace, output = graded.result, graded.output
        numbers = dict(numbers_of(one, trace))
    except SubmissionError as error:
        if error.trace is None:  # no step to be shown
            raise
        trace, output, failed = error.trace, error.output, clean_text(str(error))
        remarks.append(f"the run ended early: {failed}")
    references = References(assignment)
    played = PlayedRun(
        test=one,
        student=name,
        run=run,
        trace=trace,
        numbers=numbers,
        reference=None if one.reference is None else references.trace(one, name, run),
        reference_numbers=references.numbers(one, name, run),
        output=output,
        failed=failed,
        files=files,
        remarks=tuple(remarks),
    )
    if files:
        trace_file, picture_file = files
        trace_file.parent.mkdir(parents=True, exist_ok=True)
        trace.save(trace_file)
        write_whole(picture_file, played.picture())
    return played


def _worst(folder: ResultFolder | None, student: str, test: str) -> int | None:
    result = None if folder is None else folder.read(student)
    tests = () if result is None else result.tests
    return next((one.worst for one in tests if one.name == test), None)
