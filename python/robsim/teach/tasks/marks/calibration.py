"""`TaskCalibration`: limits, what they rest on, and what each solution comes to by them."""

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
#: A wrong solution should fail at least so often, and have no more than that part of the points.
POWER, MOST_OF_WRONG = 0.95, 0.5


#: The source of provisional limits.
SHIPPED_TASK, FEW_TESTS = "shipped task", "few tests"
_PROVISIONAL = {
    SHIPPED_TASK: "they belong to the task that ships with robsim, whose numbers differ",
    FEW_TESTS: "they are estimated from few tests",
}


@dataclass(frozen=True, kw_only=True)
class SolutionMarks:
    """What a solution comes to in many tests.

    Attributes
    ----------
    name : str
        Its name.
    is_right : bool
        Whether it should have full points.
    tests : int
        How many tests were done, each on fresh runs.
    failing : int
        In how many of them it had less than full points.
    points : float
        The median of what it got, 0..1.
    statistics : mapping of str to float
        The median of each score's statistic; None = no run came through.
    """

    name: str
    is_right: bool
    tests: int
    failing: int
    points: float
    statistics: Mapping[str, float | None]

    @property
    def rate(self) -> float:
        """The share of tests in which it had less than full points."""
        return self.failing / self.tests

    @property
    def rate_interval(self) -> tuple[float, float]:
        """The 95 % interval of the probability of that."""
        return share_interval(self.failing, self.tests)


@dataclass(frozen=True, kw_only=True)
class TaskCalibration(Report):
    """Limits of a task, so that right solutions hardly ever fail, and what they rest on.

    Attributes
    ----------
    task : str
        The kind of task.
    parameters : mapping of str to value
        What was set of it.
    limits : mapping of str to ScoreLimit
        The limits of its scores, by name.
    false_fail : float
        The probability with which a right solution has less than full points, at most.
    confidence : float
        The probability that this is so: it is wrong for one calibration in 20, with 0.95.
    tests : int
        Tests of each right solution from which the size of the limits comes.
    pilot_tests : int
        Those before, from which their shape comes: how one score's limit is to another's.
    rank : int
        The limits are as large as that many of `tests` reach: 1 = the largest; 0 = they are
        estimated from few tests.
    seed : int
        The seed of all runs.
    task_digest, solutions_digest : str
        What tells the task, and the solutions, from others.
    versions : mapping of str to str
        What it was computed with.
    solutions : tuple of SolutionMarks
        What each solution comes to by these limits, in the same tests: the right ones in those that
        the limits come from.
    provisional : str
        The source of provisional limits: ``"shipped task"`` or ``"few tests"``; "" = the limits are
        exact.
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
        """Return it as provisional limits of another task of its kind."""
        check_task(task)
        of_solutions = solutions_digest(check_kinds("solutions", solutions, Solution))
        return replace(
            self,
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
        """What is calibrated."""
        return f"Limits of the task {quoted(self.task)}, for {self.parameters['runs']} runs a test"

    @property
    def verdict(self) -> str:
        """Whether wrong solutions are told from right ones."""
        return "some wrong solutions pass" if self.missed else "wrong solutions fail"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The promise, and how it is kept."""
        return (
            Quantity("false_fail", "right ones fail, at most", self.false_fail, "", percent),
            Quantity("confidence", "confidence", self.confidence, "", percent),
            Quantity("tests", "tests", self.tests),
            Quantity("pilot_tests", "tests before", self.pilot_tests),
            Quantity("rank", "rank", self.rank),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """The limits, and what the solutions come to."""
        of_limits = [
            Column("full", "full points up to", ""),
            Column("zero", "none from", ""),
            Column("low", "full points down to", ""),
            Column("low_zero", "none from there down", ""),
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
        """What the numbers are, and what is not told apart."""
        remarks = [
            "a test fails if it has less than full points; points and scores are medians over tests"
        ]
        if self.provisional:
            remarks.insert(0, self.why_provisional)
        if self.missed:
            names = listed(quoted(one.name) for one in self.missed)
            remarks.append(
                f"not told from right in {percent(POWER, 0)} of the tests: {names}; more runs a "
                "test, or longer ones, tell more"
            )
        if self.near:
            remarks.append(
                f"more than half of the points: {listed(one.name for one in self.near)}; their "
                f"errors are hardly larger than those of right ones"
            )
        return tuple(remarks)

    def stale(self, task: Task, solutions: Iterable[Solution] | None = None) -> str | None:
        """Return in a sentence why it is to be done again for a task; None = it need not.

        Parameters
        ----------
        task : Task
            The task.
        solutions : iterable of Solution, optional
            The right and the wrong ones. Default: those that ship with robsim.

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
            return "the task is not the one that it was calibrated for: calibrate again"
        if solutions_digest(chosen) != self.solutions_digest:
            return "the solutions are not those that it was calibrated with: calibrate again"
        return None

    def as_record(self) -> dict[str, Any]:
        """Return it as plain data, as a file has it."""
        return {"format": FORMAT} | asdict(self)

    @classmethod
    def from_record(cls, record: Any) -> TaskCalibration:
        """Return what `as_record` returned.

        Raises
        ------
        ValueError
            If it is something else.
        """
        if not isinstance(record, Mapping) or record.get("format") != FORMAT:
            raise ValueError(f"no calibration of format {FORMAT}, got {quoted(record)}")
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
    """Return what tells a task from others whose runs have other numbers."""
    return _digest(
        {
            "task": task.name,
            "parameters": task.parameters,
            "scenario": task.scenario.to_toml(),
            "values": dict(task.values),
            "scores": [asdict(score) for score in task.scores],
        }
    )


def solutions_digest(solutions: Iterable[Solution]) -> str:
    """Return what tells some solutions from others."""
    return _digest(
        [
            [one.name, one.is_right, {name: _lines(text) for name, text in one.files.items()}]
            for one in solutions
        ]
    )


def _lines(source: bytes) -> list[str]:
    return source.decode(errors="replace").splitlines()  # whatever ends them on a system


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
            raise ValueError("it must have names and calibrations")
        return {name: TaskCalibration.from_record(record) for name, record in records.items()}
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{one_line(file)} has no calibrations: {error}") from None


def write_calibrations(file: Path, calibrations: Mapping[str, TaskCalibration]) -> None:
    """Write calibrations by name, as JSON; readers never get half of the file."""
    records = {name: calibration.as_record() for name, calibration in calibrations.items()}
    write_whole(file, (json.dumps(records, indent=1, allow_nan=False) + "\n").encode())


@cache
def shipped_calibrations() -> Mapping[str, TaskCalibration]:
    return read_calibrations(SHIPPED)
