"""Write the list of public names: `python write_public_api.py FILE`.

A line for each name that users can rely on, with the names of its arguments. A test compares it
with tests/public_api.txt, so that no change of it goes unseen.
"""

import ast
import dataclasses
import importlib
import inspect
import sys
from pathlib import Path

import robsim

STUB = ast.parse(Path(robsim.__file__).with_name("_core.pyi").read_text())


def native_arguments(*path):
    """The names of the arguments of a function of the core, from its stub; None = it is none."""
    nodes = [STUB]
    for name in path:
        nodes = [
            child
            for node in nodes
            for child in node.body
            if isinstance(child, (ast.ClassDef, ast.FunctionDef)) and child.name == name
        ]
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef)]
    if not functions or any("property" in ast.dump(d) for d in functions[-1].decorator_list):
        return None
    arguments = functions[-1].args
    given = [*arguments.posonlyargs, *arguments.args]
    names = [argument.arg for argument in given if argument.arg != "self"]
    if arguments.kwonlyargs:
        names += ["*", *(argument.arg for argument in arguments.kwonlyargs)]
    return names


def arguments_of(function):
    """The names of the arguments of a function of Python."""
    names = []
    kinds = [parameter.kind for parameter in inspect.signature(function).parameters.values()]
    for parameter in inspect.signature(function).parameters.values():
        is_first = parameter.kind is parameter.KEYWORD_ONLY and "*" not in names
        if is_first and parameter.VAR_POSITIONAL not in kinds:
            names.append("*")
        stars = {parameter.VAR_POSITIONAL: "*", parameter.VAR_KEYWORD: "**"}
        names.append(stars.get(parameter.kind, "") + parameter.name)
    return [name for name in names if name not in ("self", "cls")]


def is_native(value):
    owner = value if isinstance(value, type) else getattr(value, "__objclass__", None)
    return getattr(robsim._core, getattr(owner or value, "__name__", ""), None) is (owner or value)


def call(name, arguments):
    return f"{name}({', '.join(arguments)})"


def members(name, cls):
    """A line for the class, and one for each of its public members."""
    native = is_native(cls)
    arguments = native_arguments(cls.__name__, "__init__") if native else arguments_of(cls)
    yield name if arguments is None else call(name, arguments)
    fields = {f.name for f in dataclasses.fields(cls)} if dataclasses.is_dataclass(cls) else set()
    for member in sorted(fields | set(dir(cls)) - set(dir(Exception))):
        if member.startswith("_"):
            continue
        value = inspect.getattr_static(cls, member, None)
        function = getattr(cls, member, None)
        if member in fields or isinstance(value, property) or not callable(function):
            yield f"{name}.{member}"
        elif native:
            yield call(f"{name}.{member}", native_arguments(cls.__name__, member) or [])
        else:
            yield call(f"{name}.{member}", arguments_of(function))


def lines():
    for room in ["", *robsim._WINGS, "estimation.reference", "teach.gym"]:
        module = importlib.import_module(f"robsim.{room}".rstrip("."))
        for public in module.__all__:
            name, value = f"{module.__name__}.{public}", getattr(module, public)
            if room and public in robsim.__all__ and value is getattr(robsim, public):
                yield f"{name} = robsim.{public}"
            elif isinstance(value, type):
                yield from members(name, value)
            elif not callable(value):
                yield name
            elif is_native(value):
                yield call(name, native_arguments(public))
            else:
                yield call(name, arguments_of(value))


if __name__ == "__main__":
    Path(sys.argv[1]).write_text("\n".join(lines()) + "\n")
