"""Which statements of a notebook count: those of tagged cells, or those that the slots need."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.module_file import no_slot
from robsim.teach.submissions.notebook.cells import SKIP, WHOLE, Cell, cells_of
from robsim.teach.submissions.notebook.closure import needed
from robsim.teach.submissions.notebook.magics import is_command, parsed
from robsim.teach.submissions.notebook.slots import Value, freed, values_of, with_variable
from robsim.teach.submissions.notebook.statements import (
    Statement,
    compiled,
    flags_of,
    is_future,
    statement,
)
from robsim.teach.submissions.python_text import not_python

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
    """What counts of a notebook.

    Attributes
    ----------
    parts : tuple of Part
        What to run, in this order, in one module.
    variables : dict of str to str
        The name in that module of what fills each slot.
    notes : tuple of str
        What was left out, as sentences.
    """

    parts: tuple[Part, ...]
    variables: dict[str, str]
    notes: tuple[str, ...]

    @property
    def slots(self) -> tuple[str, ...]:
        return tuple(self.variables)


def chosen(content: bytes, file: str, slots: tuple[str, ...]) -> Notebook:
    """Choose what counts of a notebook; nothing of it is run.

    Parameters
    ----------
    content : bytes
        The notebook.
    file : str
        Its name.
    slots : tuple of str
        The slots that it may fill.

    Raises
    ------
    SubmissionError
        If it is no notebook, if a cell is no Python, if a slot has two values or none is filled, or
        if something exists only by running a cell.
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
        if len({value.identity for value in candidates}) > 1:
            raise SubmissionError(
                f"{file}: {slot} has more than one value: "
                f"{' and '.join(value.told for value in _first_of_each(candidates)[:4])}: {_TAG}",
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
    """Return the error for a notebook that fills no slot, with what may be meant."""
    defined = {name for each in statements if each.is_definition for name in each.binds}
    unread = [cell.title for cell in cells if is_command(cell)]
    hint = f"; {unread[0]} is a command of the notebook, and does not count" if unread else ""
    return SubmissionError(f"{no_slot(file, defined, slots)}{hint}", file=file)


def _first_of_each(values: Iterable[Value]) -> list[Value]:
    return list({value.identity: value for value in reversed(list(values))}.values())[::-1]


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
