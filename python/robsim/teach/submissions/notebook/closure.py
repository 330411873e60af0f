"""What the slots of a notebook need, and whether it exists without running a cell."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.notebook.slots import Value
from robsim.teach.submissions.notebook.statements import RUNS, Statement

_MOST_TOLD = 4  # names of a chain


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
    value: Value, touching: Mapping[str, list[Statement]], runs: frozenset[str], file: str
) -> set[int]:
    kept = set() if value.is_last else {id(value.statement)}
    needed_by = dict.fromkeys(sorted(value.needs), value.slot)
    waiting = [*needed_by]
    while waiting:
        name = waiting.pop()
        for each in touching.get(name, ()):
            if (each is not value.statement or value.is_last) and not _is_kept(each, runs):
                raise _by_running(each, _chain(name, needed_by, value.slot), touching, file)
            if id(each) not in kept:
                kept.add(id(each))
                new = sorted(each.needs - needed_by.keys())
                needed_by |= dict.fromkeys(new, name)
                waiting += new
    return kept


def _chain(name: str, needed_by: Mapping[str, str], slot: str) -> list[str]:
    """Return the slot and the names that lead from it to a name."""
    chain = [name]
    while (by := needed_by[chain[0]]) != slot:
        chain.insert(0, by)
    return [slot, *chain]


def _is_kept(each: Statement, runs: frozenset[str]) -> bool:
    return each.defines and (each.is_harmless or not each.mentions & runs)


def _by_running(
    each: Statement, chain: list[str], touching: Mapping[str, list[Statement]], file: str
) -> SubmissionError:
    """Return the error for a name that has its value by a statement that is not kept."""
    slot, *names = chain
    way = f"{slot} needs {names[0]}"
    if len(names) > 1:
        way += f", which needs {', which needs '.join(names[1:][-_MOST_TOLD:])}"
    exists = "exists only" if names[-1] in each.binds else "has its value only"
    number = next(name for name in (*names, names[-1]) if _is_value(name, touching))
    return SubmissionError(
        f"{file}: {way}; {names[-1]} {exists} by running {each.place} ({each.text}), which the "
        f"grader does not run: give {number} a value that needs no run, or tag the cells that "
        "count with robsim",
        slot=slot,
        file=each.cell.place,
        line=each.node.lineno,
    )


def _is_value(name: str, touching: Mapping[str, list[Statement]]) -> bool:
    """Return whether a name is that of a value, and not of a function, a class, or a module."""
    return not all(each.is_harmless for each in touching.get(name, ()))


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
