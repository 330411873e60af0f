"""Which statements of a notebook count: those of tagged cells, or those that the slots need."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.notebook.cells import SKIP, WHOLE, Cell, cells_of, is_command, parsed
from robsim.teach.submissions.notebook.slots import Value, freed, values_of, with_variable
from robsim.teach.submissions.notebook.statements import (
    RUNS,
    Statement,
    compiled,
    flags_of,
    is_future,
    statement,
)
from robsim.teach.submissions.python_text import no_slot, not_python

_MOST_TOLD = 4  # names of a chain


def needed(statements: list[Statement], values: Iterable[Value], file: str) -> list[Statement]:
    """Return the statements that the values of slots need, in their order.

    Raise SubmissionError if a name gets its value by a dropped statement, such as a run.
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
            is_kept = each.defines and (each.is_harmless or not each.mentions & runs)
            if (each is not value.statement or value.is_last) and not is_kept:
                raise _by_running(each, _chain(name, needed_by, value.slot), touching, file)
            if id(each) not in kept:
                kept.add(id(each))
                new = sorted(each.needs - needed_by.keys())
                needed_by |= dict.fromkeys(new, name)
                waiting += new
    return kept


def _chain(name: str, needed_by: Mapping[str, str], slot: str) -> list[str]:
    chain = [name]
    while (by := needed_by[chain[0]]) != slot:
        chain.insert(0, by)
    return [slot, *chain]


def _by_running(
    each: Statement, chain: list[str], touching: Mapping[str, list[Statement]], file: str
) -> SubmissionError:
    slot, *names = chain
    way = f"{slot} needs {names[0]}"
    if len(names) > 1:
        way += f", which needs {', which needs '.join(names[1:][-_MOST_TOLD:])}"
    exists = "exists only" if names[-1] in each.binds else "has its value only"
    values = (n for n in names if not all(one.is_harmless for one in touching.get(n, ())))
    number = next(values, names[-1])
    return SubmissionError(
        f"{file}: {way}; {names[-1]} {exists} by running {each.place} ({each.text}), which the "
        f"grader does not run: give {number} a value that needs no run, or tag the cells that "
        "count with robsim",
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


_TAG = (
    "tag the cell that counts, and those that it needs, with robsim (or begin it with the line "
    "# robsim:), or the others with robsim-skip"
)


@dataclass(frozen=True)
class Part:
    """Statements of a cell that are to be run, with the cell's own line numbers."""

    place: str
    source: str
    code: Any


@dataclass(frozen=True)
class Notebook:
    """The parts of a notebook that count."""

    parts: tuple[Part, ...]  # run in this order, in one module
    variables: dict[str, str]  # the name in that module of what fills each slot
    notes: tuple[str, ...]  # sentences on the omitted parts

    @property
    def slots(self) -> tuple[str, ...]:
        return tuple(self.variables)


def chosen(content: bytes, file: str, slots: tuple[str, ...]) -> Notebook:
    """Choose the parts of a notebook that count, without a run of them.

    Raise SubmissionError for an invalid notebook or cell, a slot with two values, no filled slot,
    or a value that exists only after a run.
    """
    cells = [cell for cell in cells_of(content, file) if cell.tag != SKIP]
    try:
        return _chosen(cells, file, slots)
    except RecursionError:
        raise SubmissionError(f"{file} is nested too deeply: split its long expressions") from None


def _chosen(cells: list[Cell], file: str, slots: tuple[str, ...]) -> Notebook:
    tagged = [cell for cell in cells if cell.tag == WHOLE]
    statements, flags = _statements(tagged or cells, file)
    values, notes = _one_each(statements, file, slots)
    if not values:
        raise _no_slot(cells, statements, file, slots)
    kept = statements if tagged else needed(statements, values, file)
    return _assembled(kept, values, flags, notes)


def _statements(cells: list[Cell], file: str) -> tuple[list[Statement], int]:
    nodes = parsed(cells, file)
    flags = flags_of(node for _, node in nodes)
    found = []
    for cell, node in nodes:
        if is_future(node):
            continue
        try:
            found.append(statement(cell, freed(node), flags))
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise not_python(error, cell.source, cell.place) from None
    return found, flags


def _one_each(
    statements: list[Statement], file: str, slots: tuple[str, ...]
) -> tuple[list[Value], tuple[str, ...]]:
    """Return the one value of each slot that has one; raise SubmissionError where there are two."""
    values, notes = [], []
    for slot in slots:
        explicit, given = values_of(statements, slot)
        candidates = explicit or given
        first = {value.identity: value for value in reversed(candidates)}
        if len(first) > 1:
            raise SubmissionError(
                f"{file}: {slot} has more than one value: "
                f"{' and '.join(value.told for value in [*first.values()][::-1][:4])}: {_TAG}",
                slot=slot,
                file=candidates[-1].statement.cell.place,
            )
        if candidates:
            values.append(candidates[-1])
        if explicit and (others := [v for v in given if v.identity != explicit[0].identity]):
            notes.append(f"{slot} is {explicit[-1].told}, and not {others[0].told}")
    return values, tuple(notes)


def _no_slot(
    cells: list[Cell], statements: list[Statement], file: str, slots: tuple[str, ...]
) -> SubmissionError:
    defined = {name for each in statements if each.is_definition for name in each.binds}
    unread = [cell.title for cell in cells if is_command(cell)]
    hint = f"; {unread[0]} is a command of the notebook, and does not count" if unread else ""
    return SubmissionError(f"{no_slot(file, defined, slots)}{hint}", file=file)


def _assembled(
    kept: list[Statement], values: list[Value], flags: int, notes: tuple[str, ...]
) -> Notebook:
    variables = {value.slot: f"robsim_slot_{value.slot}" for value in values}
    nodes: dict[Cell, list[ast.stmt]] = {}
    for each in kept:
        here = nodes.setdefault(each.cell, [])
        mine = [value for value in values if value.statement is each and not value.is_last]
        here += _filling(each, mine, variables)
    parts = [_part(cell, body, flags) for cell, body in nodes.items()]
    for value in values:
        if value.is_last:
            node = _assignment(variables[value.slot], value.expression, value.statement.node)
            parts.append(_part(value.statement.cell, [node], flags))
    return Notebook(tuple(parts), variables, notes)


def _part(cell: Cell, nodes: list[ast.stmt], flags: int) -> Part:
    return Part(cell.place, cell.source, compiled(nodes, cell.place, flags))


def _filling(each: Statement, values: list[Value], variables: dict[str, str]) -> list[ast.stmt]:
    """Return a statement with what keeps the values that it gives to slots."""
    node = each.node
    added = []
    for value in values:
        variable = variables[value.slot]
        if value.replaces:
            node = with_variable(node, value.slot, variable)
        else:
            added.append(_assignment(variable, value.expression, each.node))
    return [node, *added]


def _assignment(name: str, value: ast.expr, at: ast.stmt) -> ast.stmt:
    node = ast.Assign(targets=[ast.Name(name, ast.Store())], value=value)
    return ast.fix_missing_locations(ast.copy_location(node, at))
