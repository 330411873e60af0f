"""The statements of a notebook that count: those that its slots need, and cells with the tag."""

from __future__ import annotations

import ast
import builtins
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from typing import NamedTuple

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.names import refusal
from robsim.teach.submissions.notebook.cells import SKIP, Cell, cells_of
from robsim.teach.submissions.notebook.statements import Fill, Statement, statements_of
from robsim.teach.submissions.python_text import no_slot

#: Names that run a simulation, draw or wait.
RUNS = frozenset(
    {
        *("Simulation", "Experiment", "from_folder", "campaign", "Camera", "SimulatedLab"),
        *("UdpMotors", "SerialMotors", "run", "step", "step_stage", "input", "interact", "sleep"),
        *("system", "play", "panel", "get_ipython", "subplots", "figure", "show", "plot"),
    }
)
#: The rules for people.
COUNTS = """\
The grader takes these parts of a notebook, if a slot needs them:

1. Definitions and imports, also `from task import *`.
2. The line that fills a slot: `def control(step)`, `control = Drive()`, `sim.control = ...`,
   `@sim.control`, `Simulation(control=...)`.
3. Assignments to variables, also in `if` and `for`, unless they run a simulation, draw or wait.
4. A whole cell with the tag `robsim` or the first line `# robsim:`, with priority over others.
5. The grader never takes a cell with the tag `robsim-skip`, a `%` or `!` line, or a bare call.

The grader refuses a notebook with two values for a slot, or without a value that a slot needs."""
_RULE = "definitions, imports and assignments count, unless they run, draw or wait"
_TAG = "tag the cell that counts with robsim (or begin it with the line # robsim:)"
_OF_JUPYTER = ("display", "get_ipython", "In", "Out")
_MOST_TOLD = 4  # names of a chain, statements
_SLOT = "slot "  # the prefix of no name


class Notebook(NamedTuple):
    """The statements of a notebook that count."""

    slots: tuple[str, ...]
    parts: list[Statement]  # run in this order, in one module
    #: The errors of names that only ``import *`` or a cell with the tag can define.
    unknown: dict[str, SubmissionError]
    notes: tuple[str, ...]  # sentences on cells that count or do not


def chosen(content: bytes, file: str, slots: tuple[str, ...]) -> Notebook:
    """Choose the statements of a notebook that count, without running them.

    Raise SubmissionError for an invalid notebook or cell, a slot with two values, no filled slot,
    or a needed name without a value.
    """
    cells = [cell for cell in cells_of(content, file) if cell.tag != SKIP]
    tagged = [cell for cell in cells if cell.tag]
    alone = None
    try:
        with suppress(SubmissionError):
            alone = _Choice(tagged, file, slots).notebook()
        if alone and alone.unknown:
            alone = None
        if alone and len(alone.slots) == len(slots):
            return alone
        return _Choice(cells, file, slots).notebook()
    except SubmissionError as error:
        if alone:  # then the other cells do not matter
            return alone._replace(notes=(*alone.notes, f"{error}"))
        raise
    except RecursionError:
        raise SubmissionError(f"{file} is nested too deeply: split its long expressions") from None


class _Choice:
    def __init__(self, cells: list[Cell], file: str, slots: tuple[str, ...]) -> None:
        self.cells, self.file, self.slots = cells, file, slots
        self.all = [*statements_of(cells, file, slots)]
        self.binding, self.touching = self._by_name("binds"), self._by_name("touches")
        self.needed_by: dict[str, str] = {}
        self.runs: set[str] = set()  # with the notebook's functions that reach one of them
        mentioning, waiting = self._by_name("mentions"), [*RUNS]
        while waiting:
            self.runs.add(name := waiting.pop())
            for each in mentioning.pop(name, ()):
                waiting += each.binds if each.is_function else ()

    def _by_name(self, attribute: str) -> dict[str, list[Statement]]:
        """Return the statements of each name; cells with the tag take precedence."""
        tagged = {name for each in self.all if each.cell.tag for name in each.binds}
        found = defaultdict[str, list[Statement]](list)
        for each in self.all:
            for name in getattr(each, attribute) - (set() if each.cell.tag else tagged):
                found[name].append(each)
        return {**found}

    def notebook(self) -> Notebook:
        values = self._values()
        if not values:
            defined = {name for each in self.all if each.is_definition for name in each.binds}
            unread = [f"; {one.command} does not count" for one in self.cells if one.command]
            told = no_slot(self.file, defined, self.slots)
            raise SubmissionError("".join([str(told), *unread[:1]]), file=self.file)
        kept = self._kept(values)
        parts = [each for each in self.all if each in kept]
        parts.sort(key=lambda each: isinstance(each, Fill) and each.is_argument)
        unknown = self._unknown(parts)
        if unknown and not any(each.is_star or each.cell.tag for each in parts):
            raise next(iter(unknown.values()))
        slots = tuple(fill.slot for fill in values)
        notes = islice(self._notes(kept, values), _MOST_TOLD)
        return Notebook(slots, parts, unknown, tuple(notes))

    def _values(self) -> list[Fill]:
        """Return one value of each filled slot; raise SubmissionError if a slot has two."""
        values = []
        for slot in self.slots:
            found = [each for each in self.all if isinstance(each, Fill) and each.slot == slot]
            found = [each for each in found if each.cell.tag] or found
            found = [each for each in found if not each.is_argument] or found
            origins = {key: one for each in found for key, one in self._origins(each).items()}
            if len(origins) > 1:
                told = " and ".join(one.told for one in [*origins.values()][:_MOST_TOLD])
                said = f"{slot} has more than one value: {told}: {_TAG}, or the others with"
                at = found[-1].cell.place
                raise SubmissionError(f"{self.file}: {said} robsim-skip", slot=slot, file=at)
            values += found[-1:]
        return values

    def _origins(self, fill: Fill) -> dict[object, Statement]:
        """Return the origins of a value; two values with the same origins are the same."""
        if fill.definition:
            return {fill.definition: fill.definition}
        is_call = isinstance(fill.value, ast.Call)
        named = fill.value.func if isinstance(fill.value, ast.Call) else fill.value
        found = self.binding.get(named.id, []) if isinstance(named, ast.Name) else []
        if len(found) > is_call:
            return {each: each for each in found}
        return {ast.dump(fill.value): fill}

    def _kept(self, values: list[Fill]) -> set[Statement]:
        """Return the statements for values and those with the tag; refuse values from a run."""
        whole = [e for e in self.all if (e.is_star or e.cell.tag) and not isinstance(e, Fill)]
        waiting: list[tuple[Statement, str]] = [(e, f"cell {e.cell.number}") for e in whole]
        waiting += [(each, f"{_SLOT}{each.slot}") for each in values]
        kept: set[Statement] = set()
        while waiting:
            each, name = waiting.pop()
            may_run = each.is_definition or each.fills or not each.mentions & self.runs
            if each.awaits or not (each.cell.tag or (may_run and not each.loops)):
                raise self._left_out(each, name)
            if each not in kept:
                kept.add(each)
                new = sorted(each.needs - self.needed_by.keys())
                self.needed_by |= dict.fromkeys(new, name)
                waiting += [(one, need) for need in new for one in self.touching.get(need, ())]
        return kept

    def _left_out(self, each: Statement, name: str) -> SubmissionError:
        chain = [name]
        while chain[0] in self.needed_by:
            chain.insert(0, self.needed_by[chain[0]])
        first, *names = dict.fromkeys(one.removeprefix(_SLOT) for one in chain)
        way = f"{first} needs {', which needs '.join(names[-_MOST_TOLD:])}; " if names else ""
        last = [first, *names][-1]
        free = next((n for n in names if not self.touching[n][0].is_definition), last)
        return SubmissionError(
            f"{self.file}: {way}{last} gets its value only by running {each.told}, which does not "
            f"count: {_RULE}. Give {free} a value that needs no run, or {_TAG}",
            slot=first if first in self.slots else None,
            file=each.cell.place,
            line=each.line,
        )

    def _unknown(self, parts: list[Statement]) -> dict[str, SubmissionError]:
        """Return an error for each needed name that no statement visibly defines."""
        known = {*self.binding, *vars(builtins), *_OF_JUPYTER}.union(*(one.sets for one in parts))
        found: dict[str, SubmissionError] = {}
        for each in parts:
            missing = each.needs - known
            for node in ast.walk(each.node) if missing else ():
                if isinstance(node, ast.Name) and node.id in missing:
                    said = f": no cell that counts gives {node.id} a value: {_RULE}. Write one"
                    error = refusal(each.cell.place, f"{said}, or {_TAG}", node.lineno)
                    found.setdefault(node.id, error)
        return found

    def _notes(self, kept: set[Statement], values: list[Fill]) -> Iterator[str]:
        """Yield the cells that count, and statements that a student may expect to count."""
        lines = {(each.cell.number, each.line) for each in kept}
        partly = {number for number, line in {(e.cell.number, e.line) for e in self.all} - lines}
        told = [f"{n} (in part)" if n in partly else f"{n}" for n in sorted({n for n, _ in lines})]
        yield f"{self.file}: these cells count: {', '.join(told)}"
        origins = {key for each in values for key in self._origins(each)}
        for each in self.all:
            if isinstance(each, Fill):
                is_lost = not origins.issuperset(self._origins(each))
            else:
                changes = each.called in self.needed_by and each not in kept
                imported = all(one.is_import for one in self.touching.get(each.called, ()))
                is_lost = changes and not imported and not each.mentions & self.runs
            if is_lost:
                yield f"{self.file}: {each.told} does not count: {_TAG} if it must"
