"""The line of an estimator that a problem is about, found in its source."""

from __future__ import annotations

import ast
import inspect
import linecache
from collections.abc import Callable, Collection, Iterator
from functools import cache

from robsim.base.source_line import SourceLine
from robsim.teach.doctor._trial import EstimatorUnderTest

_Function = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda


def line_that_reads(estimator: EstimatorUnderTest, *names: str) -> SourceLine | None:
    """Return the first line that reads an attribute such as ``last_u``, or else the definition."""
    return line_where(
        estimator, lambda node: isinstance(node, ast.Attribute) and node.attr in names
    )


def line_where(
    estimator: EstimatorUnderTest, is_meant: Callable[[ast.AST], bool]
) -> SourceLine | None:
    """Return the line of the first node that fits, or else the estimator's definition."""
    found = (line for line, node in nodes_of(estimator) if is_meant(node))
    return next(found, estimator.line)


def line_that_sets(estimator: EstimatorUnderTest, names: Collection[str]) -> SourceLine | None:
    """Return the last line that sets a variable or attribute, or else the definition."""
    setting = [line for line, node in nodes_of(estimator) if _sets(node, names)]
    return setting[-1] if setting else estimator.line


def line_of_measurement(estimator: EstimatorUnderTest) -> SourceLine | None:
    """Return the first line that uses the measured pose, or else the measurement."""
    line = line_where(estimator, _is_measured_pose)
    return line if line != estimator.line else line_that_reads(estimator, "measurement")


def line_of_covariance(estimator: EstimatorUnderTest) -> SourceLine | None:
    """Return the last line that sets the covariance that is returned, or else its return."""
    found = ([*filter(_is_estimate, _walk_within(one))] for _, one in _functions(estimator))
    calls = next(filter(None, found), None)
    if calls is None:
        return estimator.line
    names = {name for call in calls for name in _covariance_names(call)}
    nodes = list(nodes_of(estimator))
    setting = [line for line, node in nodes if _sets(node, names)]
    returning = [line for line, node in nodes if node is calls[-1]]
    return (setting or returning)[-1]


def nodes_of(estimator: EstimatorUnderTest) -> Iterator[tuple[SourceLine, ast.AST]]:
    """Yield the nodes of the estimator's own source with their lines, its class before its bases.

    Yields nothing if the source is unreadable or not the user's.
    """
    for file, function in _functions(estimator):
        name = getattr(function, "name", "<lambda>")
        for node in _walk_within(function):
            if hasattr(node, "lineno"):
                yield SourceLine(file, node.lineno, name), node


def _functions(estimator: EstimatorUnderTest) -> Iterator[tuple[str, ast.AST]]:
    for file, root in _roots(estimator):
        for node in ast.walk(root):
            if isinstance(node, _Function):
                yield file, node


def _roots(estimator: EstimatorUnderTest) -> Iterator[tuple[str, ast.AST]]:
    """Yield file and node of each class of the estimator, or of the function around it."""
    if inspect.isfunction(estimator.made) and estimator.line is not None:
        file, number = estimator.line.file, estimator.line.number
        for node in getattr(_tree(file), "body", ()):
            if node.lineno <= number <= (node.end_lineno or 0):
                yield file, node
        return
    for cls in type(estimator.made).__mro__:
        try:
            file = inspect.getfile(cls)
        except (TypeError, OSError):  # compiled
            continue
        for node in ast.walk(_tree(file)):
            if isinstance(node, ast.ClassDef) and node.name == cls.__name__:
                if SourceLine(file, node.lineno, node.name).is_users:
                    yield file, node
                break


def _walk_within(function: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a function in the order of the source, without functions in it."""
    for child in ast.iter_child_nodes(function):
        if not isinstance(child, _Function):
            yield child
            yield from _walk_within(child)


def _tree(file: str) -> ast.AST:
    return _parsed("".join(linecache.getlines(file)))


@cache
def _parsed(source: str) -> ast.AST:
    try:
        return ast.parse(source)
    except SyntaxError:  # a notebook's cell with a command of the shell
        return ast.Module([], [])


def _name_of(node: ast.AST) -> str | None:
    """Return the name of a variable or of an attribute; None = another node."""
    name: str | None = getattr(node, "attr", getattr(node, "id", None))
    return name


def _is_measured_pose(node: ast.AST) -> bool:
    """Return whether the node is the pose of a variable named like a measurement."""
    if not isinstance(node, ast.Attribute) or node.attr != "pose":
        return False
    return _name_of(node.value) == "measurement"


def _is_estimate(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call) or len(node.args) + len(node.keywords) < 2:
        return False
    return _name_of(node.func) == "Estimate"


def _covariance_names(call: ast.AST) -> set[str]:
    """Return the variables and attributes in the second argument of Estimate(...)."""
    assert isinstance(call, ast.Call)
    named = [one.value for one in call.keywords if one.arg == "covariance"]
    argument = (named or call.args[1:2])[:1]
    nodes = [node for one in argument for node in ast.walk(one)]
    attributes = {node.attr for node in nodes if isinstance(node, ast.Attribute)}
    return attributes or {node.id for node in nodes if isinstance(node, ast.Name)}


def _sets(node: ast.AST, names: Collection[str]) -> bool:
    """Return whether the node sets one of the names or a part of one: P, self.P, self.P[i]."""
    target = node.value if isinstance(node, ast.Subscript) else node
    return isinstance(getattr(node, "ctx", None), ast.Store) and _name_of(target) in names
