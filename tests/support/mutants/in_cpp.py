"""Every place of a C++ file where a fault can be put, by its syntax tree."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import tree_sitter
import tree_sitter_cpp

from mutants.fault import Fault

_OPERATORS = {
    **{"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="},
    **{"+": "-", "-": "+", "*": "/", "/": "*", "&&": "||", "||": "&&", "%": "*"},
    **{"+=": "-=", "-=": "+=", "*=": "/=", "&": "|", "|": "&", "<<": ">>", ">>": "<<"},
}
_PARSER = tree_sitter.Parser(tree_sitter.Language(tree_sitter_cpp.language()))
_NOT_IN = ("static_assert_declaration", "template_argument_list", "preproc_if", "preproc_include")


def faults_in(root: Path, file: str) -> list[Fault]:
    """Return the faults that can be put into a file below a root."""
    source = (root / file).read_bytes()
    tree = _PARSER.parse(source)
    places = _below(tree.root_node)
    return sorted(
        {
            Fault(file, node.start_byte, node.start_point[0] + 1, node.text.decode(), new)
            for node, new in places
        }
    )


def _below(node: tree_sitter.Node) -> Iterator[tuple[tree_sitter.Node, str]]:
    if node.type in _NOT_IN:
        return
    yield from _at(node)
    for child in node.children:
        yield from _below(child)


def _at(node: tree_sitter.Node) -> Iterator[tuple[tree_sitter.Node, str]]:
    text = node.text.decode()
    if node.type in ("binary_expression", "assignment_expression"):
        operator = node.child_by_field_name("operator")
        streams = operator.type in ("<<", ">>") and "<<" in text  # to a stream
        if operator.type in _OPERATORS and not streams:
            yield operator, _OPERATORS[operator.type]
    elif node.type == "number_literal":
        if re.fullmatch(r"\d+", text):
            yield node, str(int(text) + 1)
        elif re.fullmatch(r"[\d.]+(e-?\d+)?f?", text):
            yield node, f"({text} + 1)"
    elif node.type in ("true", "false"):
        yield node, "false" if text == "true" else "true"
    elif node.type in ("if_statement", "while_statement"):
        condition = node.child_by_field_name("condition")
        inner = condition.child_by_field_name("value")
        if inner is not None and inner.type != "declaration":
            yield inner, f"!({inner.text.decode()})"
    elif node.type in ("break_statement", "continue_statement"):
        yield node, ";"
    elif node.type == "expression_statement" and node.named_children:
        inner = node.named_children[0].type
        if inner in ("call_expression", "assignment_expression"):
            yield node, ";"
