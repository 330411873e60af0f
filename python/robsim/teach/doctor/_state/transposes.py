"""F P F in the place of F P F': found in the source, confirmed by the matrices of a run."""

from __future__ import annotations

import ast
import sys
from types import CodeType, FrameType
from typing import Any

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.source_line import SourceLine
from robsim.teach.doctor._lines import nodes_of
from robsim.teach.doctor._state.trials import Trials

_STEPS = 12
_ASYMMETRY = 1e-9  # of the largest entry


def transpose_problem(trials: Trials) -> Problem | None:
    """Return the first line that multiplies by the same unsymmetric matrix on both sides."""
    suspects: dict[tuple[str, int], tuple[SourceLine, str, CodeType]] = {}
    for line, node in nodes_of(trials.estimator):
        factor = _factor(node)
        if factor is not None:
            code = compile(ast.Expression(factor), line.file, "eval")
            suspects[line.file, line.number] = (line, ast.unparse(node), code)
    if not suspects:
        return None
    unsymmetric = _unsymmetric(trials, {where: code for where, (*_, code) in suspects.items()})
    for where, (line, text, _) in suspects.items():
        if where in unsymmetric:
            return Problem(
                kind="missing transpose",
                sentence=f"it computes {text}, with the same matrix on both sides, which is not "
                "symmetric: a covariance becomes F P F', in Python F @ P @ F.T",
                situation=trials.weaves.name,
                line=line,
            )
    return None


def _factor(node: ast.AST) -> ast.expr | None:
    """Return F of the product F P F; None = it is another expression."""
    factors = _factors(node)
    if len(factors) != 3 or not _is_named(factors[0]):
        return None
    return factors[0] if ast.dump(factors[0]) == ast.dump(factors[2]) else None


def _factors(node: Any) -> list[ast.expr]:
    """Return the factors of a matrix product: A @ B, A.dot(B), np.dot(A, B), np.matmul(A, B)."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        return _factors(node.left) + _factors(node.right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        if node.func.attr in ("dot", "matmul") and len(node.args) == 2:
            return _factors(node.args[0]) + _factors(node.args[1])
        if node.func.attr == "dot" and len(node.args) == 1:
            return _factors(node.func.value) + _factors(node.args[0])
    return [node]


def _is_named(node: ast.AST) -> bool:
    """Return whether it is a plain name such as F or self.F, which can be looked up again."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, ast.Name)


def _unsymmetric(trials: Trials, codes: dict[tuple[str, int], CodeType]) -> set[tuple[str, int]]:
    """Return the places at which the factor is not symmetric when a trial comes by."""
    found = set()
    files = {file for file, _ in codes}

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        file = frame.f_code.co_filename
        if file not in files:
            return None
        code = codes.get((file, frame.f_lineno)) if event == "line" else None
        if code is not None and _is_unsymmetric(code, frame):
            found.add((file, frame.f_lineno))
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        trials.estimator.try_in(trials.weaves.first(_STEPS))
    finally:
        sys.settrace(before)
    return found


def _is_unsymmetric(code: CodeType, frame: FrameType) -> bool:
    try:
        F = np.asarray(eval(code, frame.f_globals, frame.f_locals), dtype=float)
    except Exception:
        return False  # not there yet
    return F.ndim == 2 and bool(abs(F - F.T).max() > _ASYMMETRY * abs(F).max())
