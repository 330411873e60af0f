"""The order of imports that the design draws, in C++ and in Python."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

# Each room and the rooms that it may include.
CPP = {
    "cpu": set(),
    "geometry": set(),
    "random": set(),
    "estimation": {"cpu"},
    "imaging": {"geometry"},
    "model": {"geometry"},
    "world": {"cpu", "geometry", "imaging", "model", "random"},
    "vision": {"cpu", "geometry", "imaging", "model"},
    "simulation": {"geometry", "random", "estimation", "imaging", "model", "world", "vision"},
}

# The storeys of the Python package, from the ground up. A room imports from the storeys below its
# own, and from no other room of its own storey: there are no cycles.
PYTHON = {
    "core": {"_core"},
    "base": {"_base"},
    "records": {"imaging", "trace"},
    "subjects": {"vision", "control", "identification", "evaluation", "reference"},
    "robots": {"robots"},
    "loop": {"simulation"},
    "views": {"plotting", "doctor", "bench"},
    "face": {"__init__"},
    "command line": {"cli"},
    "program": {"__main__"},
}


def included_rooms(file):
    return set(re.findall(r'#include "robsim/(\w+)/', file.read_text()))


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_cpp_rooms_include_only_what_lies_below_them():
    rooms = {path.name for path in (ROOT / "cpp/robsim").iterdir()}
    assert rooms == set(CPP)
    for room, allowed in CPP.items():
        files = list((ROOT / "cpp/robsim" / room).iterdir())
        assert files
        for file in files:
            assert included_rooms(file) <= allowed | {room}, file
            assert "bindings" not in file.read_text(), file
            assert "pybind11" not in file.read_text(), file


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_estimation_stands_on_eigen_and_the_processor_alone():
    for file in (ROOT / "cpp/robsim/estimation").iterdir():
        includes = re.findall(r"#include [<\"](\S+)[>\"]", file.read_text())
        own = ("Eigen/", "robsim/estimation/", "robsim/cpu/")
        foreign = [i for i in includes if "/" in i and not i.startswith(own)]
        assert not foreign, file


def imported_rooms(file):
    """The rooms of robsim that a file imports, those for type checking left out."""
    tree = ast.parse(file.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            node.body = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("robsim"):
            parts = node.module.split(".")
            if len(parts) > 1:
                yield parts[1]
            else:
                names = {alias.name for alias in node.names}
                rooms = set().union(*PYTHON.values())
                yield from (names & rooms) or {"__init__"}
        elif isinstance(node, ast.Import):
            names = [alias.name.split(".") for alias in node.names]
            yield from (parts[1] for parts in names if parts[0] == "robsim" and len(parts) > 1)


def python_files():
    package = ROOT / "python/robsim"
    return {
        file: file.relative_to(package).parts[0].removesuffix(".py")
        for file in package.rglob("*.py")
    }


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_python_rooms_import_only_from_the_storeys_below():
    storey_of = {room: i for i, rooms in enumerate(PYTHON.values()) for room in rooms}
    files = python_files()
    assert set(files.values()) | {"_core"} == set(storey_of)
    for file, room in files.items():
        for imported in set(imported_rooms(file)) - {room}:
            assert storey_of[imported] < storey_of[room], (file, imported)


CHECK = """
import sys
import robsim
late = {"matplotlib", "cv2", "pandas", "scipy", "typer", "rich", "tqdm", "tomlkit", "platformdirs"}
print(sorted(late & set(sys.modules)))
robsim.plot_traces
print("matplotlib" in sys.modules, "matplotlib.pyplot" in sys.modules)
"""


def test_import_robsim_is_quiet_and_loads_no_drawing():
    run = subprocess.run([sys.executable, "-c", CHECK], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == ["[]", "True False"]
    assert run.stderr == ""


def test_everything_in_all_is_there():
    import robsim

    assert robsim.__all__ == sorted(
        robsim.__all__, key=lambda n: (not n.isupper(), not n[0].isupper(), n)
    )
    for name in robsim.__all__:
        assert getattr(robsim, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'plot_nothing'"):
        _ = robsim.plot_nothing
