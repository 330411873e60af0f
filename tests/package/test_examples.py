"""Examples in public docstrings print the results shown; all public names have one."""

import doctest
import importlib
import inspect

import matplotlib.pyplot as plt
import numpy as np
import pytest

import robsim

pytestmark = pytest.mark.long

APART = ("estimation.reference", "teach.gym")


def public():
    """Return all public objects by the first name under which users find them."""
    found = {}
    for wing in ("", *robsim._WINGS, *APART):
        module = importlib.import_module(f"robsim.{wing}".rstrip("."))
        for name in module.__all__:
            thing = getattr(module, name)
            if callable(thing) and id(thing) not in {id(one) for one in found.values()}:
                found[f"{module.__name__}.{name}"] = thing
    return found


def examples_of(name, thing):
    """Return the examples of an object and of its methods."""
    things = {name: thing}
    if inspect.isclass(thing):
        things |= {f"{name}.{key}": one for key, one in vars(thing).items() if key[0] != "_"}
    finder = doctest.DocTestParser()
    given = {"robsim": robsim, "np": np}
    for key, one in things.items():
        text = inspect.getdoc(one) or ""
        if ">>>" in text:
            yield finder.get_doctest(text, dict(given), key, None, 0)


EXAMPLES = {name: list(examples_of(name, thing)) for name, thing in public().items()}
RUN = [one for found in EXAMPLES.values() for one in found]


def shows_a_result(example):
    """Whether something in an example runs, and shows a result."""
    skip = doctest.OPTIONFLAGS_BY_NAME["SKIP"]
    return any(one.want and not one.options.get(skip) for one in example.examples)


def is_fault(thing):
    """Whether an object is an error or a warning: these need no example."""
    return inspect.isclass(thing) and issubclass(thing, (Exception, Warning))


@pytest.mark.parametrize("example", RUN, ids=lambda example: example.name)
def test_an_example_prints_what_it_says(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = []
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    doctest.DocTestRunner(optionflags=flags).run(example, out=said.append)
    plt.close("all")
    assert said == [], "".join(said)


def test_all_public_names_have_an_example():
    things = public().items()
    lacking = [
        name
        for name, thing in things
        if not is_fault(thing) and not any(map(shows_a_result, EXAMPLES[name]))
    ]
    assert lacking == []
