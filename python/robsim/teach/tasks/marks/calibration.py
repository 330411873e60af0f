"""`TaskCalibration`: limits, their basis, and the marks of each solution by these limits."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from robsim.base.checks import check_choice, check_kinds
from robsim.base.files import write_whole
from robsim.base.report import Column, Quantity, Report, Row, Table, interval, percent
from robsim.base.text import listed, one_line, quoted
from robsim.teach.tasks.definition import Task, check_task
from robsim.teach.tasks.marks.limits import share_interval
from robsim.teach.tasks.score import ScoreLimit
from robsim.teach.tasks.solutions import Solution

FORMAT = 1
#: Minimum share of tests that a wrong solution should fail, and its maximum part of the points.
POWER, MOST_OF_WRONG = 0.95, 0.5


#: The source of provisional limits.
SHIPPED_TASK, FEW_TESTS = "shipped task", "few tests"
_PROVISIONAL = {
    SHIPPED_TASK: "they belong to the task that ships with robsim, whose numbers differ",
    FEW_TESTS: "they are estimated from few tests",
}


@dataclass(frozen=True, kw_only=True)
class SolutionMarks:
    """The marks of a solution in many tests.

    Attributes
    ----------
    name : str
        Its name.
    is_right : bool
        Whether it should have full points.
    tests : int
        The number of tests, each on fresh runs.
    failing : int
        The number of tests with less than full points.
    points : float
        The median of its points, 0..1.
    statistics : mapping of str to float
        The median of each score's statistic; None = all runs failed.

    Examples
    --------
    >>> import json, pathlib
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> public = json.loads(pathlib.Path("hw1/limits.json").read_text())["tests"]["public"]
    >>> found = robsim.teach.TaskCalibration.from_record(public["calibration"])
    >>> [(one.name, one.failing, one.tests) for one in found.solutions[:3]]
    [('reference', 0, 299), ('straight', 0, 299), ('naive', 60, 60)]
    """

    name: str
    is_right: bool
    tests: int
    failing: int
    points: float
    statistics: Mapping[str, float | None]

    @property
    def rate(self) -> float:
        """The share of tests with less than full points."""
        return self.failing / self.tests

    @property
    def rate_interval(self) -> tuple[float, float]:
        """The 95 % interval of the probability of less than full points."""
        return share_interval(self.failing, self.tests)


@dataclass(frozen=True, kw_only=True)
class TaskCalibration(Report):
    """Limits of a task that right solutions hardly ever miss, and the basis of these limits.

    Attributes
    ----------
    task : str
        The kind of task.
    parameters : mapping of str to value
        Its parameters.
    limits : mapping of str to ScoreLimit
        The limits of its scores, by name.
    false_fail : float
        The maximum probability with which a right solution has less than full points.
    confidence : float
        The probability that `false_fail` holds: with 0.95, 1 of 20 calibrations is wrong.
    tests : int
        Tests of each right solution that determine the size of the limits.
    pilot_tests : int
        Earlier tests that determine their shape: the ratios between the scores' limits.
    rank : int
        The number of `tests` that reach the limits: 1 = only the largest; 0 = an estimate from
        few tests.
    seed : int
        The seed of all runs.
    task_digest, solutions_digest : str
        Digests that identify the task and the solutions.
    versions : mapping of str to str
        The software versions of the computation.
    solutions : tuple of SolutionMarks
        The marks of each solution by these limits, in the same tests. The limits are based on the
        tests of the right solutions.
    provisional : str
        The source of provisional limits: ``"shipped task"`` or ``"few tests"``; "" = the limits are
        exact.

    Examples
    --------
    >>> import json, pathlib
    >>> assignment = robsim.teach.new_assignment("park", "hw1", seed=1)
    >>> public = json.loads(pathlib.Path("hw1/limits.json").read_text())["tests"]["public"]
    >>> found = robsim.teach.TaskCalibration.from_record(public["calibration"])
    >>> found.verdict, round(found.limits["overshoot"].full, 2), found.provisional
    ('wrong solutions fail', 1.19, 'shipped task')
    """

    task: str
    parameters: Mapping[str, Any]
    limits: Mapping[str, ScoreLimit]
    false_fail: float
    confidence: float
    tests: int
    pilot_tests: int
    rank: int
    seed: int
    task_digest: str
    solutions_digest: str
    versions: Mapping[str, str]
    solutions: tuple[SolutionMarks, ...]
    provisional: str = ""

    @property
    def why_provisional(self) -> str:
        """Return a sentence on provisional limits; "" = the limits are exact."""
        if not self.provisional:
            return ""
        return (
            f"the limits are provisional: {_PROVISIONAL[self.provisional]}; robsim assignment "
            "calibrate makes exact ones"
        )

    def for_task(self, task: Task, solutions: Iterable[Solution]) -> TaskCalibration:
        """Return a copy with provisional limits for another task of the same kind."""
        check_task(task)
        of_solutions = solutions_digest(check_kinds("solutions", solutions, Solution))
        return replace(
            self,
            parameters=task.parameters,
            task_digest=task_digest(task),
            solutions_digest=of_solutions,
            provisional=SHIPPED_TASK,
        )

    @property
    def missed(self) -> tuple[SolutionMarks, ...]:
        """The wrong solutions that fail in less than 95 % of the tests."""
        return tuple(one for one in self.solutions if not one.is_right and one.rate < POWER)

    @property
    def near(self) -> tuple[SolutionMarks, ...]:
        """The wrong solutions that have more than half of the points."""
        return tuple(
            one for one in self.solutions if not one.is_right and one.points > MOST_OF_WRONG
        )

    @property
    def title(self) -> str:
        """The name of the task."""
        return f"Limits of the task {quoted(self.task)}, for {self.parameters['runs']} runs a test"

    @property
    def verdict(self) -> str:
        """Whether wrong solutions fail."""
        return "some wrong solutions pass" if self.missed else "wrong solutions fail"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The guaranteed rate, and the result of the tests."""
        return (
            Quantity("false_fail", "right ones fail, at most", self.false_fail, "", percent),
            Quantity("confidence", "confidence", self.confidence, "", percent),
            Quantity("tests", "tests", self.tests),
            Quantity("pilot_tests", "earlier tests, for the shape of the limits", self.pilot_tests),
            Quantity("rank", "tests that reach the limits", self.rank),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """The limits, and the marks of the solutions."""
        of_limits = [
            Column("full", "full points up to", ""),
            Column("zero", "no points from", ""),
            Column("low", "full points down to", ""),
            Column("low_zero", "no points from there down", ""),
        ]
        limits = [Row(name, [*vars(limit).values()]) for name, limit in self.limits.items()]
        of_solutions = [
            Column("kind", "is", ""),
            Column("tests", "tests", ""),
            Column("rate", "fails", "", percent),
            Column("interval", "95 %", "", _percents),
            Column("points", "points", "", percent),
            *(Column(name, name, "", ".3g") for name in self.limits),
        ]
        solutions = []
        for one in self.solutions:
            kind, found = "right" if one.is_right else "wrong", one.statistics.values()
            numbers = [one.tests, one.rate, one.rate_interval, one.points, *found]
            solutions.append(Row(one.name, [kind, *numbers]))
        return (
            Table(key="limits", columns=of_limits, rows=limits, row_title="score"),
            Table(key="solutions", columns=of_solutions, rows=solutions, row_title="solution"),
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """Notes on the numbers and on wrong solutions that pass."""
        remarks = [
            "a test fails if it has less than full points; points and scores are medians over tests"
        ]
        if self.provisional:
            remarks.insert(0, self.why_provisional)
        if self.missed:
            names = listed(quoted(one.name) for one in self.missed)
            remarks.append(
                f"wrong, but fail in less than {percent(POWER, 0)} of the tests: {names}; use "
                "more runs per test, or longer runs"
            )
        if self.near:
            remarks.append(
                f"more than half of the points: {listed(one.name for one in self.near)}; their "
                f"errors are hardly larger than those of right ones"
            )
        return tuple(remarks)

    def stale(self, task: Task, solutions: Iterable[Solution] | None = None) -> str | None:
        """Return a sentence with the reason if a task needs a new calibration; None = up to date.

        Parameters
        ----------
        task : Task
            The task.
        solutions : iterable of Solution, optional
            The right and the wrong ones. Default: robsim's own.

        Raises
        ------
        TypeError
            If an argument has the wrong type.
        """
        check_task(task)
        chosen = check_kinds(
            "solutions", task.solutions if solutions is None else solutions, Solution
        )
        if task_digest(task) != self.task_digest:
            changed = changes(task.parameters, self.parameters)
            of_it = f" in {changed}" if changed else ""
            return f"the task differs from the calibrated one{of_it}: calibrate again"
        if solutions_digest(chosen) != self.solutions_digest:
            return "the solutions differ from the calibrated ones: calibrate again"
        return None

    def as_record(self) -> dict[str, Any]:
        """Return the calibration as plain data for a file."""
        return {"format": FORMAT} | asdict(self)

    @classmethod
    def from_record(cls, record: Any) -> TaskCalibration:
        """Return the calibration from the result of `as_record`.

        Raises
        ------
        ValueError
            If the record has different content.
        """
        if not isinstance(record, Mapping) or record.get("format") != FORMAT:
            raise ValueError(f"record must have format {FORMAT}, got {quoted(record)}")
        data = {name: value for name, value in record.items() if name != "format"}
        try:
            limits = {name: ScoreLimit(**limit) for name, limit in data.pop("limits").items()}
            solutions = tuple(SolutionMarks(**one) for one in data.pop("solutions"))
            check_choice("provisional", data.get("provisional", ""), ("", *_PROVISIONAL))
            return cls(limits=limits, solutions=solutions, **data)
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"no calibration: {error}") from None


def _percents(shares: tuple[float, float]) -> str:
    return f"{interval([100 * share for share in shares])} %"


def task_digest(task: Task) -> str:
    """Return a digest of the properties that affect the numbers of the task's runs."""
    return _digest(
        {
            "task": task.name,
            "parameters": task.parameters,
            "scenario": task.scenario.to_toml(),
            "values": dict(task.values),
            "scores": [asdict(score) | {"title": ""} for score in task.scores],
        }
    )


def changes(new: Mapping[str, Any], old: Mapping[str, Any]) -> str:
    """Return the parameters that differ, as text with both values; "" = all are the same."""
    new, old = json.loads(json.dumps([dict(new), dict(old)]))  # tuples become lists
    return listed(
        f"{name} ({value}, not {old.get(name)})"
        for name, value in new.items()
        if _rounded(value) != _rounded(old.get(name))
    )


def solutions_digest(solutions: Iterable[Solution]) -> str:
    """Return a digest of solutions."""
    return _digest(
        [
            [one.name, one.is_right, {name: _lines(text) for name, text in one.files.items()}]
            for one in solutions
        ]
    )


def _lines(source: bytes) -> list[str]:
    return source.decode(errors="replace").splitlines()  # the line ends depend on the system


def _digest(data: Any) -> str:
    text = json.dumps(_rounded(data), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _rounded(data: Any) -> Any:
    """Return data with floats to 12 digits, which are the same on all machines."""
    if isinstance(data, Mapping):
        return {key: _rounded(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_rounded(value) for value in data]
    return f"{data:.12g}" if isinstance(data, float) else data


SHIPPED = Path(__file__).parents[1] / "limits.json"


def read_calibrations(file: Path) -> dict[str, TaskCalibration]:
    """Return the content of a file by `write_calibrations`; a ValueError names the file."""
    try:
        records = json.loads(file.read_text(encoding="utf-8"))
        if not isinstance(records, dict):
            raise ValueError("expected a table of calibrations by name")
        return {name: TaskCalibration.from_record(record) for name, record in records.items()}
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{one_line(file)} has no calibrations: {error}") from None


def write_calibrations(file: Path, calibrations: Mapping[str, TaskCalibration]) -> None:
    """Write calibrations by name as JSON, atomically for readers."""
    records = {name: calibration.as_record() for name, calibration in calibrations.items()}
    write_whole(file, (json.dumps(records, indent=1, allow_nan=False) + "\n").encode())


@cache
def shipped_calibrations() -> Mapping[str, TaskCalibration]:
    return read_calibrations(SHIPPED)
