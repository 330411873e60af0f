"""What the slots of a notebook need, and whether it exists without running a cell."""

from __future__ import annotations

from collections.abc import Iterable

from robsim.grading._errors import SubmissionError
from robsim.grading._submissions.notebook.slots import Value
from robsim.grading._submissions.notebook.statements import RUNS, Statement


def needed(statements: list[Statement], values: Iterable[Value], file: str) -> list[Statement]:
    """Return the statements that define what the values of slots need, in their order.

    Raises
    ------
    SubmissionError
        If one of the names gets its value by something that is not kept, such as a run.
    """
    touching: dict[str, list[Statement]] = {}
    for each in statements:
        for name in each.touches:
            touching.setdefault(name, []).append(each)
    runs = _names_that_run(statements)
    kept: set[int] = set()
    for value in values:
        kept |= _needed_by(value, touching, runs, file)
    return [each for each in statements if id(each) in kept]


def _needed_by(
    value: Value, touching: dict[str, list[Statement]], runs: frozenset[str], file: str
) -> set[int]:
    kept = set() if value.is_last else {id(value.statement)}
    wanted = [(name, value.slot) for name in sorted(value.needs)]
    seen: set[str] = set()
    while wanted:
        name, by = wanted.pop()
        if name in seen:
            continue
        seen.add(name)
        for each in touching.get(name, ()):
            if each is not value.statement or value.is_last:
                _check_kept(each, name, by, value.slot, runs, file)
            if id(each) not in kept:
                kept.add(id(each))
                wanted += [(other, name) for other in sorted(each.needs)]
    return kept


def _check_kept(
    each: Statement, name: str, by: str, slot: str, runs: frozenset[str], file: str
) -> None:
    if each.defines and (each.is_harmless or not each.mentions & runs):
        return
    how = f"{slot} needs {name}" if by == slot else f"{slot} needs {by}, which needs {name}"
    does = "exists only" if name in each.binds else "has its value only"
    raise SubmissionError(
        f"{file}: {how}, and {name} {does} by running {each.place}, which the grader does not run: "
        f"write the value of {name} into a cell, or tag the cells that count with robsim",
        slot=slot,
        file=each.cell.place,
        line=each.node.lineno,
    )


def _names_that_run(statements: list[Statement]) -> frozenset[str]:
    """Return `RUNS` and the functions of the notebook that reach one of them."""
    mentioning: dict[str, list[Statement]] = {}
    for each in statements:
        for name in each.mentions if each.is_definition else ():
            mentioning.setdefault(name, []).append(each)
    runs = set(RUNS)
    waiting = [*RUNS]
    while waiting:
        for each in mentioning.get(waiting.pop(), ()):
            waiting += each.binds - runs
            runs |= each.binds
    return frozenset(runs)
