"""The result of a submission's grading: points, sentences, numbers, as a file."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from robsim.base.checks import check_text
from robsim.base.files.reading import parse_json
from robsim.base.report import Column, Quantity, Report, Row, Table


def in_hundredths(points: float, most: float) -> float:
    """Return points in hundredths; rounding never yields all points or 0."""
    if points >= most:
        return most
    rounded = round(points, 2)
    if rounded >= most:
        rounded = round(rounded - 0.01, 2)
    elif rounded <= 0 < points:
        rounded = 0.01
    return min(max(rounded, 0.0), most)


def fraction_of(points: float, most: float) -> float:
    """Return the share of the points, 0 to 1; 1 if there are no points."""
    return 1.0 if points >= most else max(points / most, 0.0)


def number(points: float) -> str:
    """Return points as a number without zeros at its end."""
    return f"{points:.2f}".rstrip("0").rstrip(".")


def of_most(points: float, most: float) -> str:
    return f"{number(points)} of {number(most)} {'point' if most == 1 else 'points'}"


#: The status of a test.
PASSED, PARTIAL, FAILED, ERROR, NOT_RUN = "passed", "partial", "failed", "error", "not run"
FORMAT = 1


@dataclass(frozen=True, kw_only=True)
class ScoreResult:
    """A score in a test: the statistic of its runs, and its part of the points.

    Attributes
    ----------
    name, title, unit : str
        See `Score`.
    values, reference : tuple of float
        The numbers of the completed runs, and of the reference in the same runs.
    statistic : float
        Their statistic; NaN = all runs failed.
    limit, zero, low, low_zero : float or None
        See `ScoreLimit`.
    fraction, share : float
        The part of its points, 0 to 1, and its share of the points of the test. The part of a
        score with share 0 multiplies all others, which contain it.

    Examples
    --------
    >>> import pathlib
    >>> assignment = robsim.teach.new_assignment("measure", "hw1", seed=1)
    >>> pathlib.Path("ann").mkdir()
    >>> size = pathlib.Path("ann/measure.py").write_text("def measure(step): return None")
    >>> result = robsim.teach.grade_submission(assignment, "ann", public=True)
    >>> [(score.name, score.fraction) for score in result.tests[0].scores]
    [('position', 0.0), ('heading', 0.0), ('lost', 0.0)]
    """

    name: str
    title: str
    unit: str = ""
    values: tuple[float, ...] = ()
    reference: tuple[float, ...] = ()
    statistic: float
    limit: float
    zero: float
    low: float | None = None
    low_zero: float | None = None
    fraction: float
    share: float = 1.0

    @property
    def is_met(self) -> bool:
        """Whether the score is within the limits for full points."""
        is_small = self.low is not None and self.statistic < self.low
        return self.statistic <= self.limit and not is_small


@dataclass(frozen=True, kw_only=True)
class FailedRun:
    """A failed run: its number and the submission's failure.

    `cause` has the values of `SubmissionError.cause`.

    Examples
    --------
    >>> park = robsim.teach.ParkTask()
    >>> trial = robsim.teach.try_solution(park, control=lambda: lambda step: 1 / 0, runs=1)
    >>> trial.failed
    {0: 'ZeroDivisionError: division by zero'}
    """

    run: int
    reason: str
    slot: str | None = None
    step: int | None = None
    file: str | None = None
    line: int | None = None
    cause: str = "error"


@dataclass(frozen=True, kw_only=True)
class TestResult:
    """A graded test of an assignment.

    All texts are clean: they have no escapes or control characters, and are at most a page long.

    Attributes
    ----------
    name, title : str
        Its name in the assignment, and its title for people.
    number : str
        Its number, such as "3.1"; "" = without a number.
    public : bool
        Whether students have it, too. Students see only the points and the `sentence` of hidden
        tests.
    points, most : float
        Its points, rounded to hundredths, and the maximum possible. Rounding never yields full
        points or 0.
    provisional : str
        The reason why the limits of its points are provisional; "" = exact limits.
    status : str
        ``"passed"`` (all points), ``"partial"``, ``"failed"`` (0 points), ``"error"`` (the
        assignment or the grader failed: no points are lost or won), ``"not run"``.
    sentence : str
        The text for the student, one or two sentences.
    whose : str or None
        The cause of failed runs: ``"submission"``, ``"assignment"``, ``"grader"``.
    scores : tuple of ScoreResult
        Empty for a teacher's own test.
    runs : int
        The number of runs; 0 for a teacher's own test.
    failed : tuple of FailedRun
        The failed runs: each loses its part of the points.
    worst : int or None
        The number of the shown run: the worst, or a failed one.
    picture : str or None
        The file of its picture, next to this file.
    caption : str
        The description of the picture in a sentence, also for blind readers.
    finding : str
        The doctor's finding; "" = no finding.
    output : str
        The printed output of the submission, cut.
    seconds : float
        Its duration.
    digest : str
        SHA-256 of all inputs of its numbers, without points and limits; "" = not run yet.
    by_hand : bool
        Whether these are points by hand, such as for style, and not a test.
    """

    __test__ = False  # not a test of pytest

    name: str
    title: str
    number: str = ""
    public: bool = True
    points: float
    most: float
    provisional: str = ""
    status: str
    sentence: str = ""
    whose: str | None = None
    scores: tuple[ScoreResult, ...] = ()
    runs: int = 0
    failed: tuple[FailedRun, ...] = ()
    worst: int | None = None
    picture: str | None = None
    caption: str = ""
    finding: str = ""
    output: str = ""
    seconds: float = 0.0
    digest: str = ""
    by_hand: bool = False

    def __post_init__(self) -> None:
        # Here, so that all readers get the same points, with the right sum.
        object.__setattr__(self, "points", in_hundredths(self.points, self.most))


@dataclass(frozen=True, kw_only=True)
class ByHand:
    """Marks by hand of a submission.

    Attributes
    ----------
    late_days : float
        The number of late days.
    kept : float
        The remaining share of the points, 0 to 1.
    points : float or None
        Points that replace the tests' points; None = the tests count.
    comment : str
        A comment for the student.

    Examples
    --------
    >>> mark = robsim.teach.ByHand(late_days=1.0, kept=0.9, comment="one day late")
    >>> mark.kept
    0.9
    """

    late_days: float = 0.0
    kept: float = 1.0
    points: float | None = None
    comment: str = ""


@dataclass(frozen=True, kw_only=True, repr=False)
class SubmissionResult:
    """All tests of a submission.

    Attributes
    ----------
    assignment, title : str
        Name and title of the assignment.
    student : str
        The name of the student, or of the group.
    members : tuple of str
        The students of a group.
    tests : tuple of TestResult
        In the order of the assignment; during grading the finished ones, then "not run".
    notes : tuple of str
        The files left out in reading, or the reason why reading failed.
    isolation : str
        The layers of the sandbox, in a line.
    submission_digest, assignment_digest : str
        SHA-256 of the submission, and of all inputs of the points.
    versions : mapping of str to str
        robsim, numpy, python.
    is_done : bool
        Whether all tests were run.
    seconds : float
        Its duration.
    by_hand : ByHand
        Late days, points by hand and a comment.
    command : str
        The shell command that grades it; "" = unknown.
    """

    assignment: str
    title: str
    student: str
    members: tuple[str, ...] = ()
    tests: tuple[TestResult, ...] = ()
    notes: tuple[str, ...] = ()
    isolation: str = ""
    submission_digest: str = ""
    assignment_digest: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)
    is_done: bool = False
    seconds: float = 0.0
    by_hand: ByHand = ByHand()
    command: str = field(default="", compare=False)

    @property
    def points(self) -> float:
        """All points of the submission, by tests and by hand, minus the deduction for late days."""
        hand = self.by_hand
        points = self.points_of_tests if hand.points is None else hand.points
        points += sum(test.points for test in self.tests if test.by_hand)
        return round(points * hand.kept, 2)

    @property
    def most(self) -> float:
        """The maximum points."""
        return round(sum(test.most for test in self.tests), 2)

    @property
    def points_of_tests(self) -> float:
        """The points of the tests, without points by hand."""
        return round(sum(test.points for test in self.tests if not test.by_hand), 2)

    @property
    def has_errors(self) -> bool:
        """Whether the grading of a test failed because of the assignment or the grader."""
        return any(test.status == ERROR for test in self.tests)

    @property
    def is_unread(self) -> bool:
        """Whether reading failed, so that no test ran; `notes` gives the reason."""
        return self.is_done and not self.submission_digest and bool(self.notes)

    @property
    def report(self) -> SubmissionReport:
        """The tests in a table, as a `Report`."""
        return SubmissionReport(of=self)

    def __str__(self) -> str:
        return str(self.report)

    def __repr__(self) -> str:
        return f"<SubmissionResult: {self.report.line}>"

    def _repr_html_(self) -> str:
        return self.report._repr_html_()

    def to_json(self) -> str:
        """Return the result as JSON, with null for NaN and infinity."""
        data = {"format": FORMAT} | asdict(self)
        if not self.members:  # as in files of earlier versions
            del data["members"]
        return json.dumps(finite(data), indent=1, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> SubmissionResult:
        """Return the result of a text from `to_json`; raise ValueError for other text."""
        data = parse_json(check_text("text", text), 2**20)
        if not isinstance(data, dict) or data.pop("format", None) != FORMAT:
            raise ValueError(f"text must be the result of a submission, in format {FORMAT}")
        try:
            tests = tuple(_test(one) for one in data.pop("tests"))
            data["by_hand"] = ByHand(**data.get("by_hand", {}))
            lists = {name: tuple(data.get(name, ())) for name in ("notes", "members")}
            return cls(tests=tests, **data | lists)
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"no result of a submission: {error}") from None


def _test(data: Mapping[str, Any]) -> TestResult:
    scores = tuple(_score(one) for one in data["scores"])
    failed = tuple(FailedRun(**one) for one in data["failed"])
    return TestResult(**{**data, "scores": scores, "failed": failed})


def _score(data: Mapping[str, Any]) -> ScoreResult:
    statistic = math.nan if data["statistic"] is None else data["statistic"]
    runs = {
        name: tuple(math.nan if value is None else value for value in data[name])
        for name in ("values", "reference")
    }
    return ScoreResult(**{**data, **runs, "statistic": statistic})


def finite(value: Any) -> Any:
    """Return data with None instead of NaN and infinity, which JSON does not have."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@dataclass(frozen=True, kw_only=True)
class SubmissionReport(Report):
    """The result of a submission, for a prompt and a notebook."""

    of: SubmissionResult

    @property
    def title(self) -> str:
        return f"{self.of.student}, {self.of.title}"

    @property
    def quantities(self) -> Sequence[Quantity]:
        points, of_tests = self.of.points, self.of.points_of_tests
        return (
            Quantity("points", "points", points, "", ".2f"),
            Quantity("most", "of", self.of.most, "", "g"),
            *([Quantity("tests", "the tests gave", of_tests)] if points != of_tests else ()),
        )

    @property
    def tables(self) -> Sequence[Table]:
        columns = (
            Column("points", "points", "", ".2f"),
            Column("most", "of", "", "g"),
            Column("status", "", ""),
            Column("sentence", "", ""),
        )
        rows = [
            Row(test.name, (test.points, test.most, test.status, test.sentence))
            for test in self.of.tests
        ]
        return (Table(key="tests", columns=columns, rows=rows, row_title="test"),)

    @property
    def remarks(self) -> Sequence[str]:
        return self.of.notes
