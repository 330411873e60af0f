"""Public names and their stubs."""

import ast
import importlib
import inspect
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import robsim
from robsim import Scenario, Simulation
from surroundings import needs_extension
from write_options import written

# --- names


TESTS = Path(__file__).parents[1]
ROOMS = (*robsim._WINGS, "estimation.reference", "teach.gym")
MODULES = ["robsim", *(f"robsim.{room}" for room in ROOMS)]


@pytest.mark.long
def test_the_list_of_public_names_is_up_to_date(tmp_path):
    script = TESTS / "support" / "write_public_api.py"
    subprocess.run([sys.executable, script, tmp_path / "api.txt"], check=True)
    written = (tmp_path / "api.txt").read_text()
    listed = (TESTS / "public_api.txt").read_text()
    assert written == listed, "look at the difference; ./run stubs writes the list anew"


def test_a_module_offers_what_it_says_and_nothing_else():
    for module in map(importlib.import_module, MODULES):
        assert module.__all__ == sorted(
            module.__all__, key=lambda name: (not name.isupper(), not name[0].isupper(), name)
        )
        # It may hold modules of its own, never one of somebody else's.
        visible = {
            name
            for name, value in vars(module).items()
            if not name.startswith("_")
            and getattr(value, "__name__", "") != f"{module.__name__}.{name}"
        }
        assert visible <= set(module.__all__), module
    assert {"Simulation", "vision", "plotting"} <= set(dir(robsim))
    assert not hasattr(robsim, "_nothing")


def test_a_name_says_where_it_is_public():
    for module in map(importlib.import_module, MODULES):
        for name in module.__all__:
            value = getattr(module, name)
            if not isinstance(value, (str, tuple, Mapping)):
                at_the_top = name in robsim.__all__ and value is getattr(robsim, name)
                home = "robsim" if at_the_top else module.__name__
                assert value.__module__ == home, name
    assert "robsim._core" not in robsim.find_blobs.__doc__
    with pytest.raises(TypeError, match="step") as caught:
        robsim.Spin()(3)
    assert "robsim._core" not in str(caught.value)


def public_calls():
    for module in map(importlib.import_module, MODULES):
        for name in filter(lambda one: callable(getattr(module, one)), module.__all__):
            value = getattr(module, name)
            yield name, value
            for one, member in vars(value).items() if isinstance(value, type) else ():
                if callable(member) and not one.startswith("_"):
                    yield f"{name}.{one}", member


def test_what_is_public_has_a_docstring():
    found = dict(public_calls())
    assert len(found) > 400
    assert [name for name, value in found.items() if not inspect.getdoc(value)] == []


AT_ONCE = """
import random, threading
import robsim

errors, names = [], [name for name in (*robsim.__all__, *robsim._WINGS) ]


def ask(seed):
    for name in random.Random(seed).sample(names, len(names)):
        try:
            getattr(robsim, name)
        except Exception as error:
            errors.append((name, error))


threads = [threading.Thread(target=ask, args=(seed,)) for seed in range(12)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(errors)
"""


@pytest.mark.parametrize("name", ["robsim.plotting", "robsim.lab.cameras"])
@pytest.mark.parametrize("double", [None, object()])
def test_tests_may_set_a_double_instead_of_a_module(monkeypatch, name, double):
    home, _, module = name.rpartition(".")
    monkeypatch.setattr(name, double)
    assert getattr(importlib.import_module(home), module) is double


@pytest.mark.long
def test_threads_that_ask_for_rooms_at_once_get_whole_ones():
    run = subprocess.run([sys.executable, "-c", AT_ONCE], capture_output=True, text=True)
    assert (run.stdout, run.stderr) == ("[]\n", "")


def test_signatures_and_docstrings_say_what_the_rows_of_options_and_slots_say():
    for file, content in written(Path(robsim.__file__).parent).items():
        assert file.read_text() == content, f"{file.name}: ./run stubs writes it again"


# --- misspelled names


@pytest.mark.parametrize(
    ("call", "error", "named"),
    [
        (lambda: Simulation(mesure=True), TypeError, "'mesure'.*'measure'"),
        (lambda: Scenario(boundary="bonce"), ValueError, "'bounce'"),
        (lambda: setattr(Simulation(), "mesure", True), AttributeError, "'mesure'.*'measure'"),
        (lambda: robsim.nees, AttributeError, "robsim.estimation.nees"),
        (lambda: robsim.goToPoint, AttributeError, "'GoToPoint'"),
        (lambda: robsim.lab.Experiment, AttributeError, r"use robsim\.Experiment"),
        (lambda: robsim.simulation.Camera, AttributeError, r"use robsim\.Camera"),
        (lambda: robsim.control.Goto, AttributeError, "'GoToPoint'"),
        (lambda: Simulation(control=False), TypeError, "False switches off .*estimate_state only"),
        (lambda: Simulation(estimate_state="default"), ValueError, "estimate_state has no default"),
    ],
)
def test_what_may_be_meant_is_told(call, error, named):
    with pytest.raises(error) as caught:
        call()
    assert re.search(named, str(caught.value))


def test_a_misspelled_file(tmp_path):
    robsim.vision.save_colors(tmp_path / "mine.toml", robsim.load_colors())
    with pytest.raises(FileNotFoundError, match=r"main\.toml; .*'mine\.toml'"):
        robsim.load_colors(tmp_path / "main.toml")


# --- the stub of the core


SCRIPT = Path(__file__).parents[1] / "support" / "write_stub.py"


@pytest.mark.long
def test_the_stub_of_the_core_is_up_to_date(tmp_path):
    if not shutil.which("pybind11-stubgen", path=str(Path(sys.executable).parent)):
        raise RuntimeError("the tests need pybind11-stubgen: pip install pybind11-stubgen")
    subprocess.run([sys.executable, SCRIPT, tmp_path], check=True, capture_output=True)
    shipped = Path(robsim.__file__).with_name("_core.pyi").read_text()
    assert (tmp_path / "robsim/_core.pyi").read_text() == shipped, "write it anew: ./run stubs"


def test_the_package_says_that_it_is_typed():
    assert Path(robsim.__file__).with_name("py.typed").is_file()


# --- stubs of cameras


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
