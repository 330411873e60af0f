"""The tests of a grading, proved usable before any submission runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from robsim.base.checks import check_bool
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.teach.assignments._own_tests.listing import list_own_tests
from robsim.teach.assignments.assignment import Assignment, TaskTest
from robsim.teach.assignments.limits_file import FILE as LIMITS
from robsim.teach.assignments.marking import references as digests
from robsim.teach.assignments.marking.marking import limit_of
from robsim.teach.assignments.marking.references import References, key_for
from robsim.teach.assignments.marking.work import GradingWork, Unit
from robsim.teach.errors import AssignmentError
from robsim.teach.isolation.check import check_isolation
from robsim.teach.isolation.start import IsolationError


@dataclass(frozen=True)
class Plan:
    """The tests of a grading."""

    work: GradingWork  # the assignment with all tests that have results
    wanted: frozenset[str]  # the names of the tests to run
    digest: str  # of all inputs of the points
    waits: str = ""  # the reason why hidden tests do not run

    @property
    def assignment(self) -> Assignment:
        return self.work.assignment


def now() -> datetime:
    return datetime.now(UTC)


def plan_of(
    assignment: Assignment,
    *,
    only: Iterable[str] | None = None,
    public: bool = False,
    waits: bool = False,
) -> Plan:
    """Return the plan of a grading, for the tests with the names `only`, or for public tests.

    A plan that `waits` leaves out hidden tests until their time.
    Raise AssignmentError if a limit, the key, a reference or a file of tests is missing or broken,
    and ValueError if a test is unknown.
    """
    check_bool("public", public)
    asked = None if only is None else names_of(only)
    tests = [t for t in assignment.all_tests if t.public or not public]
    if not tests:
        raise ValueError(f"{assignment.name} has no public tests")
    if (
        assignment.isolation == "strict"
        and not (report := check_isolation(isolation="strict")).strict
    ):
        raise IsolationError(str(report))
    references = References(assignment)
    for test in tests:
        key_for(assignment, public=test.public)
        if isinstance(test, TaskTest):
            _check_usable(test, references)
    units = []
    for test in tests:
        own = () if isinstance(test, TaskTest) else list_own_tests(assignment, test)
        units.append(Unit(test, own, digests.of_test(assignment, test)))
    names = [name for unit in units for name in unit.names]
    all_names = [*names, *assignment.by_hand]
    if twice := [name for name in all_names if all_names.count(name) > 1]:
        raise AssignmentError(f"duplicate test {quoted(twice[0])}: rename one")
    check_names(f"{assignment.name} has no test", asked or (), names, ValueError)
    start = assignment.hidden_from
    is_early = waits and start is not None and now() < start
    early = {name for unit in units if is_early and not unit.test.public for name in unit.names}
    said = f"Hidden tests will run from {start:%Y-%m-%d %H:%M %Z} on." if early else ""
    wanted = names if asked is None else asked
    work = GradingWork(assignment, tuple(units))
    return Plan(work, frozenset(wanted) - early, digests.of_assignment(assignment), said)


def names_of(only: Iterable[str] | str) -> list[str]:
    """Return the argument `only`, which may be a single name; raise TypeError for other types."""
    names = [only] if isinstance(only, str) else only
    if not isinstance(names, Sequence) or not all(isinstance(one, str) for one in names):
        raise TypeError(f"only must be names, got {quoted(only)}")
    return list(names)


def _check_usable(test: TaskTest, references: References) -> None:
    """Raise AssignmentError unless a test has limits, and its reference runs."""
    for score in test.task.scores:
        limit_of(test, score)
        known = test.reference_values.get(score.name)
        if known is not None and len(known) != test.task.runs:
            raise AssignmentError(
                f"limits.json must have {test.task.runs} reference values for {test.name}, one per "
                f"run, got {len(known)}",
                file=LIMITS,
            )
    references.numbers(test, "", 0)
