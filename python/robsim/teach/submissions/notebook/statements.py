"""What a statement of a notebook defines, changes and needs, told without running it."""

from __future__ import annotations
import __future__

import ast
import dis
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from types import CodeType
from typing import Any

from robsim.base.text import one_line
from robsim.teach.submissions.notebook.cells import AWAIT, Cell
from robsim.teach.submissions.python_text import quiet

#: What runs a simulation, waits for somebody, or draws: a value that calls it is not kept.
RUNS = frozenset(
    {
        *("Simulation", "Experiment", "from_folder", "campaign", "Camera", "SimulatedLab"),
        *("UdpMotors", "SerialMotors", "run", "step", "step_stage"),
        *("input", "open", "play", "panel"),
        *("subplots", "figure", "show", "get_ipython", "interact", "sleep", "system"),
    }
)
_MUTATORS = frozenset(
    {
        *("append", "extend", "insert", "update", "pop", "remove", "clear", "sort", "reverse"),
        *("fill", "add", "discard", "setdefault", "popitem", "put", "resize", "setflags"),
    }
)
_LONGEST_LINE = 50  # characters
_LOADS = frozenset({"LOAD_NAME", "LOAD_GLOBAL", "LOAD_FROM_DICT_OR_GLOBALS"})
_STORES = frozenset({"STORE_NAME", "STORE_GLOBAL"})
_DEFINITIONS: tuple[type, ...] = (
    *(ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom, ast.Pass),
    *filter(None, [getattr(ast, "TypeAlias", None)]),  # from Python 3.12 on
)
_CALLED_WITH_CLASS = frozenset({"__init__", "__new__", "__post_init__"})
_FUTURES = {name: getattr(__future__, name).compiler_flag for name in __future__.all_feature_names}


@dataclass(eq=False)
class Statement:
    """A statement at the top of a cell."""

    cell: Cell
    node: ast.stmt
    #: The names that it gives a value, and those whose value it changes.
    binds: set[str] = field(default_factory=set)
    changes: set[str] = field(default_factory=set)
    #: The global names that it, or a function in it, looks up.
    needs: set[str] = field(default_factory=set)
    #: All names in it, of attributes, too, that count for `RUNS`.
    mentions: set[str] = field(default_factory=set)
    defines: bool = False  # whether it only defines

    @property
    def touches(self) -> set[str]:
        """The names whose value depends on it."""
        return self.binds | self.changes

    @property
    def is_definition(self) -> bool:
        return isinstance(self.node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))

    @property
    def is_harmless(self) -> bool:
        return self.is_definition or isinstance(self.node, (ast.Import, ast.ImportFrom))

    @property
    def place(self) -> str:
        return f"cell {self.cell.number}, line {self.node.lineno}"

    @property
    def text(self) -> str:
        line = self.cell.source.split("\n")[self.node.lineno - 1].strip()
        return one_line(line if len(line) <= _LONGEST_LINE else f"{line[:_LONGEST_LINE]}...")


def flags_of(nodes: Iterable[ast.stmt]) -> int:
    """Return the flags for `compile` of the statements ``from __future__ import ...``."""
    flags = AWAIT
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module == "__future__":
            for alias in node.names:
                flags |= _FUTURES.get(alias.name, 0)
    return flags


def is_future(node: ast.stmt) -> bool:
    return isinstance(node, ast.ImportFrom) and node.module == "__future__"


def statement(cell: Cell, node: ast.stmt, flags: int) -> Statement:
    """Look at a statement; raise what `compile` raises."""
    code = compiled([node], cell.place, flags)
    found = Statement(cell, node)
    found.binds = _names(code, _STORES)
    found.needs = _needs(code)
    if isinstance(node, ast.For):  # its own variable, whatever has the name elsewhere
        found.needs -= {one.id for one in ast.walk(node.target) if isinstance(one, ast.Name)}
    found.changes = {*_changed(node)}
    found.mentions = _mentions(node, code)
    found.defines = _defines(node)
    return found


def compiled(nodes: list[ast.stmt], place: str, flags: int) -> CodeType:
    module = ast.Module(body=nodes, type_ignores=[])
    with quiet():
        code = compile(module, place, "exec", flags, dont_inherit=True)
    assert isinstance(code, CodeType)
    return code


def at_the_top(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a node and those in it that are run with it: nothing of a function's body."""
    waiting = [node]
    while waiting:
        each = waiting.pop()
        yield each
        if isinstance(each, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            waiting += each.decorator_list
        elif not isinstance(each, ast.Lambda):
            waiting += ast.iter_child_nodes(each)


def needs_of(expression: ast.expr) -> set[str]:
    """Return the global names that an expression, or a function in it, looks up."""
    node = ast.copy_location(ast.Expr(expression), expression)
    return _needs(compiled([node], "<expression>", AWAIT))


def _names(code: CodeType, kinds: frozenset[str]) -> set[str]:
    return {str(i.argval) for i in dis.get_instructions(code) if i.opname in kinds}


def _inner(code: CodeType) -> Iterator[CodeType]:
    waiting = [code]
    while waiting:
        each = waiting.pop()
        yield each
        waiting += [value for value in each.co_consts if isinstance(value, CodeType)]


def _needs(code: CodeType) -> set[str]:
    needs = _names(code, _LOADS)
    for inner in _inner(code):
        if inner is not code:  # of a class, its own names are no global ones
            needs |= _names(inner, _LOADS) - _names(inner, _STORES)
    return {name for name in needs if not name.startswith("__")}


def _mentions(node: ast.stmt, code: CodeType) -> set[str]:
    """Return the names of globals and attributes; of a class, what making an object reaches."""
    if not isinstance(node, ast.ClassDef):
        return {name for inner in _inner(code) for name in inner.co_names}
    return {
        name
        for inner in _inner(code)
        if inner.co_name in _CALLED_WITH_CLASS
        for name in inner.co_names
    }


def _root(node: ast.AST) -> str | None:
    while isinstance(node, (ast.Subscript, ast.Attribute, ast.Starred)):
        node = node.value
    return node.id if isinstance(node, ast.Name) else None


def _changed(node: ast.stmt) -> Iterator[str]:
    for each in at_the_top(node):
        root: str | None = None
        if isinstance(each, (ast.Subscript, ast.Attribute)) and not isinstance(each.ctx, ast.Load):
            root = _root(each)
        elif isinstance(each, ast.AugAssign):
            root = _root(each.target)
        elif isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute):
            root = _root(each.func.value) if each.func.attr in _MUTATORS else None
        if root is not None:
            yield root


def _defines(node: ast.stmt) -> bool:
    if isinstance(node, _DEFINITIONS):
        return True
    if isinstance(node, (ast.Assign, ast.AugAssign)):
        return not _awaits(node)
    if isinstance(node, ast.AnnAssign):
        return node.value is not None and not _awaits(node)
    if isinstance(node, ast.Expr):
        call = node.value
        return (
            isinstance(call, ast.Call)
            and isinstance(call.func, ast.Attribute)
            and call.func.attr in _MUTATORS
            and not _awaits(node)
        )
    if isinstance(node, (ast.If, ast.For, ast.Try)):
        return all(map(_defines, _leaves(node)))
    return False


def _leaves(node: Any) -> Iterator[ast.stmt]:
    for name in ("body", "orelse", "finalbody"):
        yield from getattr(node, name, ())
    for handler in getattr(node, "handlers", ()):
        yield from handler.body


def _awaits(node: ast.stmt) -> bool:
    return any(isinstance(each, (ast.Await, ast.Yield, ast.YieldFrom)) for each in ast.walk(node))
