"""Every place of a Python file where a fault can be put, by its syntax tree."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from mutants.fault import Fault

_OPERATORS: dict[type[ast.AST], tuple[str, str]] = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.In: (" in ", " not in "),
    ast.NotIn: (" not in ", " in "),
    ast.Is: (" is ", " is not "),
    ast.IsNot: (" is not ", " is "),
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.And: (" and ", " or "),
    ast.Or: (" or ", " and "),
}
_REMOVED = (ast.Break, ast.Continue, ast.Raise, ast.AugAssign)


def faults_in(root: Path, file: str) -> list[Fault]:
    """Return the faults that can be put into a file below a root."""
    return sorted(set(_Places(root, file).all()))


class _Places:
    def __init__(self, root: Path, file: str) -> None:
        self.file = file
        self.source = (root / file).read_bytes()
        self.starts = [0]
        for line in self.source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))

    def all(self) -> Iterator[Fault]:
        yield from self._below(ast.parse(self.source))

    def _below(self, node: ast.AST) -> Iterator[Fault]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.JoinedStr) or _is_declaration(node, child):
                continue  # texts and types
            yield from self._at(child)
            yield from self._below(child)

    def _at(self, node: ast.AST) -> Iterator[Fault]:
        if isinstance(node, ast.Compare):
            ends = [node.left, *node.comparators]
            for operator, left, right in zip(node.ops, ends, ends[1:], strict=False):
                yield from self._between(left, right, operator)
        elif isinstance(node, ast.BinOp):
            yield from self._between(node.left, node.right, node.op)
        elif isinstance(node, ast.BoolOp):
            for left, right in zip(node.values, node.values[1:], strict=False):
                yield from self._between(left, right, node.op)
        elif isinstance(node, (ast.If, ast.While, ast.IfExp)):
            start, end = self._span(node.test)
            yield self._fault(start, end, f"(not ({self._text(start, end)}))")
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
            value = (not node.value) if type(node.value) is bool else node.value + 1
            yield self._fault(*self._span(node), repr(value))
        elif isinstance(node, ast.Return) and node.value is not None:
            yield self._fault(*self._span(node.value), "None")
        elif isinstance(node, _REMOVED) or _is_call(node):
            yield self._fault(*self._span(node), "pass")

    def _between(self, left: ast.AST, right: ast.AST, operator: ast.AST) -> Iterator[Fault]:
        if type(operator) in _OPERATORS:
            old, new = _OPERATORS[type(operator)]
            start, end = self._span(left)[1], self._span(right)[0]
            between = self._text(start, end)
            if between.count(old) == 1 and "#" not in between:
                yield self._fault(start, end, between.replace(old, new))

    def _span(self, node: ast.AST) -> tuple[int, int]:
        start = self.starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
        end = self.starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
        return start, end

    def _text(self, start: int, end: int) -> str:
        return self.source[start:end].decode()

    def _fault(self, start: int, end: int, new: str) -> Fault:
        line = self.source.count(b"\n", 0, start) + 1
        return Fault(self.file, start, line, self._text(start, end), new)


def _is_call(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)


def _is_declaration(node: ast.AST, child: ast.AST) -> bool:
    if isinstance(node, (ast.arg, ast.AnnAssign)) and child is node.annotation:
        return True
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and child is node.returns:
        return True
    return isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING"
