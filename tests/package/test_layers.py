"""The order of imports that the design draws, in C++ and in Python."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# Each room and the rooms that it may include; none includes one that includes it.
CPP = {
    "simd": set(),
    "text": set(),
    "timing": set(),
    "threads": set(),
    "elementary": set(),
    "geometry": set(),
    "random": {"elementary"},
    "estimation": {"simd", "text"},
    "imaging": {"text", "geometry"},
    "imaging/raw": {"simd", "imaging"},
    "model": {"text", "elementary", "geometry"},
    "world/noise": {"text", "simd", "elementary", "random", "imaging"},
    "world/sprite": {"text", "simd", "elementary", "geometry", "imaging"},
    "world": {"text", "geometry", "imaging", "world/sprite"},
    "vision/color": {"text", "imaging"},
    "vision/pixels": {"simd", "imaging", "vision/color"},
    "vision/fit": {"simd", "elementary", "geometry", "imaging", "vision/color"},
    "vision/light": {"simd", "imaging", "vision/color", "vision/pixels"},
    "vision": {
        *("text", "elementary", "geometry", "imaging"),
        *("vision/color", "vision/pixels", "vision/light", "vision/fit"),
    },
    "capture": {"text", "timing", "threads", "imaging"},
    "capture/firewire": {"timing", "imaging", "imaging/raw", "capture"},
    "capture/gige": {"timing", "threads", "imaging", "imaging/raw", "capture"},
    "motors": {"text", "timing", "threads", "model"},
    "simulation/seam": {"imaging", "model", "vision"},
    "simulation/world": {
        *("text", "timing", "motors", "random", "model", "world", "world/noise"),
        "simulation/seam",
    },
    "simulation/robot": {
        *("text", "random", "estimation", "imaging", "model", "vision"),
        "simulation/seam",
    },
    "simulation/remote": {"text", "timing", "imaging", "simulation/seam", "simulation/robot"},
    "simulation": {"timing", "simulation/seam", "simulation/robot"},
    "laboratory": {
        *("timing", "threads", "elementary", "geometry", "random", "imaging", "model", "world"),
        *("world/noise", "capture", "motors", "simulation/seam", "simulation/world"),
    },
}

# The storeys of the Python package, from the ground up. A room imports from the storeys below its
# own, and from no other room of its own storey: there are no cycles.
PYTHON = {
    "core": {"_core", "_firewire", "_gige"},
    "base": {"_base"},
    "records": {"imaging", "trace"},
    "subjects": {
        *("vision", "control", "identification", "evaluation", "reference"),
        *("calibration", "capture", "motors", "sessions"),
    },
    "robots": {"robots"},
    "loop": {"simulation"},
    "many runs": {"campaigns"},
    "submissions": {"grading", "plotting"},
    "exercises": {"tasks"},
    "views": {"doctor", "live", "gym"},
    "courses": {"assignments"},
    "panels": {"gui"},
    "face": {"__init__"},
    "command line": {"cli"},
    "program": {"__main__"},
}


# A folder that holds more is two rooms (a .cpp and its .hpp count once).
MOST_MODULES = {"cli": 15}
MOST_MODULES_ELSEWHERE = 12


def included_rooms(file):
    return set(re.findall(r'#include "robsim/([\w/]+)/\w+\.hpp"', file.read_text()))


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_cpp_rooms_include_only_what_lies_below_them():
    files = [*(ROOT / "cpp/robsim").rglob("*.?pp")]
    room_of = {file: str(file.parent.relative_to(ROOT / "cpp/robsim")) for file in files}
    assert set(room_of.values()) == set(CPP)
    for file, room in room_of.items():
        assert included_rooms(file) <= CPP[room] | {room}, file
        assert "bindings" not in file.read_text(), file
        assert "pybind11" not in file.read_text(), file


def test_the_order_of_the_cpp_rooms_has_no_circle():
    rooms = list(CPP)
    for room, allowed in CPP.items():
        assert all(rooms.index(below) < rooms.index(room) for below in allowed), room


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_estimation_stands_on_eigen_the_processor_and_text_alone():
    for file in (ROOT / "cpp/robsim/estimation").iterdir():
        includes = re.findall(r"#include [<\"](\S+)[>\"]", file.read_text())
        own = ("Eigen/", "robsim/estimation/", "robsim/simd/", "robsim/text/")
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


@pytest.mark.long
@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_python_rooms_import_only_from_the_storeys_below():
    storey_of = {room: i for i, rooms in enumerate(PYTHON.values()) for room in rooms}
    files = python_files()
    assert set(files.values()) | PYTHON["core"] == set(storey_of)
    for file, room in files.items():
        for imported in set(imported_rooms(file)) - {room}:
            assert storey_of[imported] < storey_of[room], (file, imported)


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_no_room_is_crowded():
    folders = [f for top in ("cpp", "python/robsim") for f in (ROOT / top).rglob("*") if f.is_dir()]
    for folder in [*folders, ROOT / "python/robsim"]:
        modules = {f.stem for f in folder.iterdir() if f.suffix in (".py", ".cpp", ".hpp")}
        most = MOST_MODULES.get(folder.name, MOST_MODULES_ELSEWHERE)
        assert len(modules) <= most, (folder, len(modules))


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_the_architecture_names_every_room():
    text = (ROOT / "python/robsim/ARCHITECTURE.md").read_text()
    rooms = set().union(*PYTHON.values()) - PYTHON["core"] - {"__init__", "__main__"}
    assert rooms == set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
    assert all(f"`{room}`" in text for room in CPP)


CHECK = """
import sys
import robsim
print("numpy" in sys.modules)
robsim.Simulation, robsim.Camera
late = {"matplotlib", "cv2", "pandas", "scipy", "typer", "rich", "tqdm", "tomlkit", "platformdirs"}
print(sorted(late & set(sys.modules)))
import robsim.calibration, robsim.live
trace = robsim.Simulation(control=robsim.DriveAround(), estimate_parameters=True, seed=1).run(60)
robsim.batch_estimate(trace)
print(sorted(name for name in sys.modules if name.startswith("scipy.")))  # a second
robsim.plot_traces
print("matplotlib" in sys.modules, "matplotlib.pyplot" in sys.modules)
"""


@pytest.mark.long
def test_import_robsim_is_quiet_and_loads_late_what_takes_long():
    run = subprocess.run([sys.executable, "-c", CHECK], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines() == ["False", "[]", "[]", "True False"]
    assert run.stderr == ""


@pytest.mark.long
def test_help_loads_nothing_that_computes():
    code = (
        "import sys, atexit; atexit.register(lambda: print('numpy' in sys.modules)); "
        "import robsim.cli; sys.argv = ['robsim', '--help']; robsim.cli.main()"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "assignment" in run.stdout
    assert run.stdout.splitlines()[-1] == "False"
