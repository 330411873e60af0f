"""What fills a slot in a notebook: by decorator, name, attribute, or argument of a simulation."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from robsim.base.text import one_line
from robsim.simulation.slots import SLOTS
from robsim.teach.submissions.notebook.statements import Statement, at_the_top, needs_of

_MOST_TOLD = 4  # two are too many
_FACES = ("Simulation", "Experiment")
#: Where the slots of a function's decorators are kept once these are taken off.
_TAKEN = "_robsim_slots"


@dataclass(frozen=True)
class Value:
    """A value for a slot."""

    slot: str
    statement: Statement
    expression: ast.expr
    way: str  # how it is given, for messages
    identity: object  # two values with the same one are the same
    #: Whether its statement sets an attribute, which becomes a variable.
    replaces: bool = False
    #: Whether it is evaluated after all cells, because its statement is not run.
    is_last: bool = False

    @property
    def told(self) -> str:
        return f"{one_line(self.way)} in {self.statement.cell.title}"

    @property
    def needs(self) -> set[str]:
        """The global names that it needs, by itself or by its statement."""
        if self.replaces or self.is_last:
            return needs_of(self.expression)
        return self.statement.needs


def freed(node: ast.stmt) -> ast.stmt:
    """Take the decorators ``@sim.SLOT`` off a function; `values_of` still finds them."""
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        slots = [slot for one in node.decorator_list if (slot := _attribute(one)) is not None]
        node.decorator_list = [one for one in node.decorator_list if _attribute(one) is None]
        setattr(node, _TAKEN, slots)
    return node


def with_variable(node: ast.stmt, slot: str, variable: str) -> ast.stmt:
    assert isinstance(node, (ast.Assign, ast.AnnAssign))
    value = node.value
    assert value is not None
    given = node.targets if isinstance(node, ast.Assign) else [node.target]
    name = ast.Name(variable, ast.Store())
    targets = [name if _attribute(one) == slot else one for one in given]
    changed = ast.Assign(targets=targets, value=value)
    return ast.fix_missing_locations(ast.copy_location(changed, node))


def values_of(statements: list[Statement], slot: str) -> tuple[list[Value], list[Value]]:
    """Return the values for a slot: those of statements of their own, those of arguments."""
    binders: dict[str, list[Statement]] = {}
    for each in statements:
        for name in each.binds:
            binders.setdefault(name, []).append(each)
    explicit = [value for each in statements for value in _explicit(each, slot)]
    given = [value for each in statements for value in _arguments(each, slot)]
    return (
        [named for value in explicit for named in _by_definition(value, binders)],
        [named for value in given for named in _by_definition(value, binders)],
    )


def _attribute(node: ast.expr) -> str | None:
    """Return the slot of ``sim.SLOT``; None = it is none."""
    is_slot = (
        isinstance(node, ast.Attribute) and node.attr in SLOTS and isinstance(node.value, ast.Name)
    )
    return node.attr if is_slot and isinstance(node, ast.Attribute) else None


def _explicit(each: Statement, slot: str) -> Iterator[Value]:
    node = each.node
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        taken = getattr(node, _TAKEN, [])
        if slot in taken or (node.name == slot and not taken):
            way = f"@sim.{slot}" if slot in taken else f"def {slot}"
            yield Value(slot, each, ast.Name(node.name, ast.Load()), way, each)
        return
    if not isinstance(node, (ast.Assign, ast.AnnAssign)) or node.value is None:
        return
    if isinstance(node.value, ast.Constant):  # off, or the default
        return
    for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
        if _attribute(target) == slot:
            way = f"sim.{slot} = {ast.unparse(node.value)[:40]}"
            yield Value(slot, each, node.value, way, ast.dump(node.value), replaces=True)
        elif isinstance(target, ast.Name) and target.id == slot:
            yield Value(slot, each, ast.Name(slot, ast.Load()), f"{slot} = ...", each)


def _arguments(each: Statement, slot: str) -> Iterator[Value]:
    for node in at_the_top(each.node):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "attr", getattr(node.func, "id", None))
        for keyword in node.keywords if name in _FACES else ():
            if keyword.arg == slot and not isinstance(keyword.value, ast.Constant):
                value = keyword.value
                way = f"{name}({slot}={ast.unparse(value)[:40]})"
                yield Value(slot, each, value, way, ast.dump(value), is_last=True)


def _by_definition(value: Value, binders: Mapping[str, list[Statement]]) -> Iterator[Value]:
    """Yield a value once for each statement that defines the function or class that it names.

    A name that gets two values in a notebook is two values, as far as anybody can tell.
    """
    is_call = isinstance(value.expression, ast.Call)
    named = value.expression.func if isinstance(value.expression, ast.Call) else value.expression
    found = binders.get(named.id, []) if isinstance(named, ast.Name) else []
    if value.identity is value.statement or len(found) < (2 if is_call else 1):
        yield value
        return
    for binder in found[:_MOST_TOLD]:
        way = f"{value.way}, of {binder.place}," if len(found) > 1 else value.way
        yield replace(value, way=way, identity=binder)
