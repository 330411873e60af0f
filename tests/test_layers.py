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

# Each layer of modules imports from the layers above it only: there are no cycles.
PYTHON = [
    {"_core", "files", "numbers", "opencv", "pictures", "seeds", "slots", "templates"},
    {
        "chi_square",
        "four_points",
        "frame_source",
        "frames",
        "light",
        "options",
        "shipped",
        "time_limit",
    },
    {"folder_modules", "spelling", "trace", "waypoints", "whiteness"},
    {"fits", "samples"},
    {"identifiability"},
    {
        "clip",
        "colors",
        "controllers",
        "convergence",
        "cramer_rao",
        "excitation",
        "folders",
        "identification",
        "metrics",
        "not_seen",
        "path_score",
        "recordings",
    },
    {"color_picture", "color_score", "consistency", "robots", "video"},
    {"scene"},
    {"simulation"},
    {"doctor", "plotting"},
    {"results"},
    {"bench", "demo"},
    {"cli"},
    {"__main__", "reference"},  # nothing imports them
]


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


def imported_modules(file):
    """The modules of robsim that a file imports, those for type checking left out."""
    tree = ast.parse(file.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            node.body = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("robsim"):
            parts = node.module.split(".")
            yield from [parts[1]] if len(parts) > 1 else [alias.name for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name.split(".") for alias in node.names]
            yield from (parts[1] for parts in names if parts[0] == "robsim" and len(parts) > 1)


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_python_modules_import_only_what_lies_below_them():
    layer_of = {module: i for i, layer in enumerate(PYTHON) for module in layer}
    package = ROOT / "python/robsim"
    files = {
        file: file.relative_to(package).parts[0].removesuffix(".py")
        for file in package.rglob("*.py")
    }
    files = {file: module for file, module in files.items() if module != "__init__"}
    assert set(files.values()) | {"_core"} == set(layer_of)
    for file, module in files.items():
        for imported in set(imported_modules(file)) - {module}:
            assert layer_of[imported] < layer_of[module], (file, imported)


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
