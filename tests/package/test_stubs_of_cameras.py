"""The stubs of the extensions that read cameras, against the extensions where they are built."""

import ast
import re
from pathlib import Path

import pytest

import robsim
from needs import needs_extension

# pybind11's words for what a function takes, in those of the stubs.
WORDS = [
    (r"typing\.SupportsInt \| typing\.SupportsIndex", "int"),
    (r"typing\.SupportsFloat \| typing\.SupportsIndex", "float"),
    (
        r"typing\.Annotated\[collections\.abc\.Sequence\[(\w+)\], \"FixedSize\(4\)\"\]",
        r"tuple[\1, \1, \1, \1]",
    ),
    (r"(collections\.abc|robsim\.\w+)\.", ""),
]
# What pybind11 knows of a result of Python's; the stub says more.
VAGUE = {"dict": ("dict[", "Info"), "list": ("list[",), "object": ("Info",)}


def parsed(doc, name, owner):
    """Return the first line of a function's doc as a function of the stub."""
    line = doc.strip().splitlines()[0]
    for pattern, word in WORDS:
        line = re.sub(pattern, word, line)
    line = re.sub(rf"^\w*\((self|arg0): {owner}\b", "(self", line)
    return ast.parse(f"def {name}{line.removeprefix(name)}: ...").body[0]


def compare(real, written, place):
    assert ast.unparse(real.args) == ast.unparse(written.args), place
    result, said = ast.unparse(real.returns), ast.unparse(written.returns)
    assert result == said or said.startswith(VAGUE.get(result, "-")), f"{place} -> {said}"


def doc_of(value):
    return (value.fget if isinstance(value, property) else value).__doc__


def is_public(name):
    return not name.startswith("_") or name == "__init__"


def stub_of(module):
    """Return the nodes of a stub by their names, its own names for types put in."""
    text = Path(robsim.__file__).with_name(f"{module}.pyi").read_text()
    for alias, value in re.findall(r"^(_\w+) = (.+)$", text, re.MULTILINE):
        text = re.sub(rf"\b{alias}\b", value, text)
    nodes = ast.parse(text).body
    named = {n.name: n for n in nodes if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
    named |= {n.target.id: n for n in nodes if isinstance(n, ast.AnnAssign)}
    ours = ("TypedDict", "Identity")  # of the stub alone
    return {
        k: n for k, n in named.items() if not any(b.id in ours for b in getattr(n, "bases", ()))
    }


@pytest.mark.parametrize("name", ["firewire", "gige"])
def test_the_stub_has_the_names_and_signatures_of_the_extension(name):
    extension, stub = needs_extension(name), stub_of(f"_{name}")
    real = {key: value for key, value in vars(extension).items() if is_public(key)}
    assert real.keys() == stub.keys()
    for key, value in real.items():
        node = stub[key]
        if isinstance(value, str):
            assert ast.unparse(node.annotation) == "str"
        elif not isinstance(value, type):
            compare(parsed(value.__doc__, key, ""), node, key)
        else:
            compare_class(value, node)


def compare_class(value, node):
    bases = [base.__name__ for base in value.__bases__ if base.__name__ != "pybind11_object"]
    assert bases == [base.id for base in node.bases]
    members = {key: one for key, one in vars(value).items() if is_public(key)}
    written = {one.name: one for one in node.body if isinstance(one, ast.FunctionDef)}
    assert members.keys() == written.keys(), value.__name__
    for key, one in members.items():
        compare(parsed(doc_of(one), key, value.__name__), written[key], f"{value.__name__}.{key}")
        decorators = [decorator.id for decorator in written[key].decorator_list]
        assert decorators == ["property"] * isinstance(one, property), key
