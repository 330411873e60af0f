"""Statements of a notebook: the names that they bind, change, need and fill, without a run."""

from __future__ import annotations
import __future__

import ast
import dis
from collections.abc import Iterator
from functools import reduce
from inspect import CO_COROUTINE
from operator import or_
from types import CodeType

from robsim.simulation.slots import SLOTS
from robsim.teach.submissions.notebook.cells import AWAIT, Cell, parsed
from robsim.teach.submissions.python_text import compiled

_MUTATORS = frozenset(
    {
        *("append", "extend", "insert", "update", "pop", "remove", "clear", "sort", "reverse"),
        *("fill", "add", "discard", "setdefault", "popitem", "put", "resize", "setflags"),
    }
)
#: The prefix of the variables of slots.
FILLED = "robsim_slot_"
_FUTURES = reduce(or_, (getattr(__future__, n).compiler_flag for n in __future__.all_feature_names))
_LOADS = ("LOAD_NAME", "LOAD_GLOBAL", "LOAD_FROM_DICT_OR_GLOBALS")
_NAMED = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_WITH_CLASS = ("__init__", "__new__", "__post_init__")  # run when an object is made


class Statement:
    """A statement at the top of a cell, compiled; SubmissionError if Python cannot compile it."""

    def __init__(self, cell: Cell, node: ast.stmt, flags: int) -> None:
        self.cell, self.node, self.line = cell, node, node.lineno
        module = ast.fix_missing_locations(ast.Module([node], []))
        self.code: CodeType = compiled(module, cell.source, cell.place, flags | AWAIT)
        top, codes = [*_at_the_top(node)], [*_codes(self.code)]
        self.is_star = isinstance(node, ast.ImportFrom) and node.names[0].name == "*"
        self.is_import = isinstance(node, (ast.Import, ast.ImportFrom))
        self.is_function = isinstance(node, _NAMED)
        self.is_definition = self.is_import or self.is_function
        self.fills = False  # a slot
        self.loops = any(isinstance(each, ast.While) for each in top)
        self.awaits = bool(self.code.co_flags & CO_COROUTINE)
        #: Global names: with a new value, also with a changed value, set by inner functions.
        self.binds = _names(self.code, "STORE_NAME", "STORE_GLOBAL")
        self.touches = self.binds.union(map(_changed, top))
        self.sets = {name for code in codes[1:] for name in _names(code, "STORE_GLOBAL")}
        #: The global names that the statement or a function in it looks up.
        self.needs = _names(self.code, *_LOADS)
        if isinstance(node, ast.For):  # its own variable, also if other code uses the name
            self.needs -= {one.id for one in ast.walk(node.target) if isinstance(one, ast.Name)}
        for code in codes[1:]:
            self.needs |= _names(code, *_LOADS) - _names(code, "STORE_NAME")  # of a class
        #: All names that a run of the statement or its function reaches, with attributes.
        made = [c for c in codes if not isinstance(node, ast.ClassDef) or c.co_name in _WITH_CLASS]
        self.mentions = {name for code in made for name in code.co_names}
        #: The variable whose method the statement calls without any other effect.
        self.called = ""
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            self.called = _root(node.value.func) if hasattr(node.value.func, "attr") else ""

    @property
    def told(self) -> str:
        return self.cell.told(self.line)


class Fill(Statement):
    """A value of a slot, assigned to a variable."""

    def __init__(self, slot: str, value: ast.expr, of: Statement, flags: int, *, way: str) -> None:
        self.is_argument = way == "argument"  # of a simulation, which is not run
        node = ast.Assign(targets=[ast.Name(f"{FILLED}{slot}", ast.Store())], value=value)
        ast.copy_location(node, value if self.is_argument else of.node)
        super().__init__(of.cell, node, flags)
        self.fills = True
        of.fills |= not self.is_argument
        self.slot, self.value, self.definition = slot, value, of if way == "name" else None


def statements_of(cells: list[Cell], file: str, slots: tuple[str, ...]) -> Iterator[Statement]:
    """Yield the statements of cells, each followed by its values for slots."""
    flags = 0
    for cell, node in parsed(cells, file):
        if _is_check(node):
            continue
        values = [each for each in _values(node) if each[0] in slots]
        if not getattr(node, "targets", [node]):  # of ``sim.SLOT = ...``
            node = ast.copy_location(ast.Pass(), node)
        yield (statement := Statement(cell, node, flags))
        flags |= statement.code.co_flags & _FUTURES
        yield from (Fill(slot, value, statement, flags, way=way) for slot, value, way in values)


def _is_check(node: ast.stmt) -> bool:
    """Return whether a statement is ``name = robsim.teach.checked(name)``."""
    match node:
        case ast.Assign(
            targets=[ast.Name(id=name)],
            value=ast.Call(
                func=ast.Attribute(attr="checked") | ast.Name(id="checked"),
                args=[ast.Name(id=given)],
            ),
        ):
            return name == given
    return False


def _values(node: ast.stmt) -> Iterator[tuple[str, ast.expr, str]]:
    """Yield the values of slots; remove ``@sim.SLOT`` and ``sim.SLOT =`` from the statement."""
    if isinstance(node, _NAMED):
        slots = [slot for one in node.decorator_list if (slot := _slot(one))]
        node.decorator_list = [one for one in node.decorator_list if not _slot(one)]
        for slot in slots or [node.name]:
            yield slot, ast.Name(node.name, ast.Load()), "name"
    elif isinstance(node, (ast.Assign, ast.AnnAssign)):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets if _is_on(node.value) else ():
            name = getattr(target, "id", "")
            yield name, ast.Name(name, ast.Load()), "name"
            yield _slot(target), node.value or target, "attribute"
        if isinstance(node, ast.Assign):
            node.targets = [one for one in targets if not _slot(one)]
    for call in _at_the_top(node):
        match call:
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), keywords=given):
                for one in given if name in ("Simulation", "Experiment") else ():
                    if _is_on(one.value):
                        yield one.arg or "", one.value, "argument"


def _slot(node: ast.expr) -> str:
    """Return the slot of ``sim.SLOT``, or an empty text."""
    is_one = isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
    return name if is_one and (name := str(getattr(node, "attr", ""))) in SLOTS else ""


def _is_on(value: ast.expr | None) -> bool:
    return value is not None and not isinstance(value, ast.Constant)  # which may be the default


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for inner in code.co_consts:
        if isinstance(inner, CodeType) and inner.co_name != "__annotate__":  # not run, since 3.14
            yield from _codes(inner)


def _names(code: CodeType, *kinds: str) -> set[str]:
    names = {str(i.argval) for i in dis.get_instructions(code) if i.opname in kinds}
    return {name for name in names if not name.startswith("__")}


def _at_the_top(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a node and its inner nodes that run at the same time, without bodies of functions."""
    waiting = [node]
    while waiting:
        yield (each := waiting.pop())
        if isinstance(each, _NAMED):
            waiting += each.decorator_list
        elif not isinstance(each, ast.Lambda):
            waiting += ast.iter_child_nodes(each)


def _changed(node: ast.AST) -> str:
    """Return the variable of an assigned part, or of a changed container."""
    if isinstance(node, ast.Call):
        return _root(node.func) if getattr(node.func, "attr", "") in _MUTATORS else ""
    if isinstance(node, (ast.Subscript, ast.Attribute)) and not isinstance(node.ctx, ast.Load):
        return _root(node)
    return ""


def _root(node: ast.AST) -> str:
    while isinstance(node, (ast.Subscript, ast.Attribute)):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""
