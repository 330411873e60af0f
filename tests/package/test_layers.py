"""The order of imports that the design draws, in C++ and in Python."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# Each room and the rooms that it may include; none includes one that includes it. A file of base is
# a separate room.
CPP = {
    "base/simd": set(),
    "base/system": set(),
    "base/elementary": set(),
    "base/geometry": set(),
    "estimation": {"base/simd", "base/system"},
    "imaging": {"base/system", "base/geometry"},
    "imaging/raw": {"base/simd", "base/system", "imaging"},
    "model": {"base/system", "base/elementary", "base/geometry"},
    "world": {"base/system", "base/simd", "base/elementary", "base/geometry", "imaging"},
    "vision/color": {"base/system", "imaging"},
    "vision/pixels": {"base/simd", "base/system", "imaging", "vision/color"},
    "vision/fit": {"base/simd", "base/elementary", "base/geometry", "imaging", "vision/color"},
    "vision": {
        *("base/system", "base/elementary", "base/geometry", "imaging"),
        *("vision/color", "vision/pixels", "vision/fit"),
    },
    "lab/capture": {"base/system", "imaging"},
    "lab/capture/firewire": {"base/system", "imaging", "imaging/raw", "lab/capture"},
    "lab/capture/gige": {"base/system", "imaging", "imaging/raw", "lab/capture"},
    "lab/motors": {"base/system", "model"},
    "simulation/seam": {"imaging", "model", "vision"},
    "simulation/world": {
        *("base/system", "base/elementary", "lab/motors", "model", "world"),
        "simulation/seam",
    },
    "simulation/robot": {
        *("base/system", "base/elementary", "estimation", "imaging", "model", "vision"),
        "simulation/seam",
    },
    "simulation/remote": {"base/system", "imaging", "simulation/seam", "simulation/robot"},
    "simulation": {"base/system", "simulation/seam", "simulation/robot"},
    "lab": {"lab/capture", "lab/motors", "simulation/seam", "simulation/world"},
    "lab/laboratory": {
        *("base/system", "base/elementary", "base/geometry", "imaging", "model", "world"),
        *("lab/capture", "lab/motors", "simulation/seam", "simulation/world"),
    },
}

# The rooms of the Python package, wing by wing: a room imports from those before it in this list
# only. What users have at the top is there late.
ROOMS = (
    *("_core", "_firewire", "_gige", "base"),
    *("vision", "vision.imaging", "vision.markers", "vision.robots"),
    *("trace", "control"),
    *("estimation", "estimation.identification", "estimation.evaluation", "estimation.reference"),
    *("simulation", "campaigns"),
    *("lab", "lab.motors", "lab.cameras", "lab.calibration", "lab.rehearsal"),
    "plotting",
    *(
        "teach",
        "teach.errors",
        "teach.texts",
        "teach.submissions",
        "teach.isolation",
        "teach.grading",
    ),
    *("teach.tasks", "teach.doctor", "teach.gym", "teach.exercises"),
    *("teach.results", "teach.reports", "teach.assignments"),
    *("gui", "cli", "__main__"),
)
WINGS = {room.partition(".")[0] for room in ROOMS if not room.startswith("_")}


# A folder that holds more is two rooms (a .cpp and its .hpp count once).
MOST_MODULES = 20


def cpp_room(file):
    """The room of a file of the core."""
    return (file.with_suffix("") if file.parent.name == "base" else file.parent).as_posix()


def included_rooms(file):
    included = re.findall(r'#include "robsim/([\w/]+\.hpp)"', file.read_text())
    return {cpp_room(Path(one)) for one in included}


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_cpp_rooms_include_only_what_lies_below_them():
    files = [*(ROOT / "cpp/robsim").rglob("*.?pp")]
    room_of = {file: cpp_room(file.relative_to(ROOT / "cpp/robsim")) for file in files}
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
        own = ("Eigen/", "robsim/estimation/", "robsim/base/simd/", "robsim/base/system.hpp")
        foreign = [i for i in includes if "/" in i and not i.startswith(own)]
        assert not foreign, file


def room_of(module):
    parts = module.split(".")[1:]
    return next((r for r in (".".join(parts[:2]), parts[0] if parts else "") if r in ROOMS), "")


def imported_names(file):
    """The names of robsim that a file imports at run time, with their modules."""
    tree = ast.parse(file.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            node.body = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("robsim"):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
            yield from (name for name in names if name.startswith("robsim."))


def module_of(file):
    parts = file.relative_to(ROOT / "python").with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_python_rooms_import_only_from_those_before_them():
    package = ROOT / "python/robsim"
    used = set()
    for file in package.rglob("*.py"):
        room = room_of(module_of(file))
        used.add(room)
        for imported in {*map(room_of, imported_names(file))} - {room, ""}:
            assert ROOMS.index(imported) < ROOMS.index(room or "__main__"), (file, imported)
    assert used - {""} == {*ROOMS} - {"_core", "_firewire", "_gige"}


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_no_circle_of_imports_at_run_time():
    """The doors of packages are left out, since they import their modules."""
    modules = (f for f in (ROOT / "python/robsim").rglob("*.py") if not f.stem.startswith("__"))
    files = {module_of(file): file for file in modules}
    left = {
        module: {name for one in imported_names(file) for name in (one, one.rpartition(".")[0])}
        for module, file in files.items()
    }
    while ends := [module for module, imported in left.items() if not imported & {*left}]:
        for module in ends:
            del left[module]
    assert not left


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_folders_are_few_and_shallow():
    package = ROOT / "python/robsim"
    folders = {file.parent for file in package.rglob("*.py")} - {package}
    assert {folder.relative_to(package).parts[0] for folder in folders} == WINGS
    assert len(WINGS) <= 12
    data = {"templates", "start"}
    for folder in folders:
        parts = folder.relative_to(package).parts
        if not data & {*parts}:
            assert len(parts) <= 3, folder
            assert len([*folder.glob("*.py")]) + len([*folder.glob("*/__init__.py")]) > 2, folder


@pytest.mark.skipif(not (ROOT / "cpp").is_dir(), reason="needs the sources")
def test_no_room_is_crowded():
    folders = [f for top in ("cpp", "python/robsim") for f in (ROOT / top).rglob("*") if f.is_dir()]
    for folder in [*folders, ROOT / "python/robsim"]:
        modules = {f.stem for f in folder.iterdir() if f.suffix in (".py", ".cpp", ".hpp")}
        assert len(modules) <= MOST_MODULES, (folder, len(modules))


@pytest.mark.skipif(not (ROOT / "python").is_dir(), reason="needs the sources")
def test_the_architecture_names_every_room():
    text = (ROOT / "python/robsim/ARCHITECTURE.md").read_text()
    named = set(re.findall(r"^\| `([\w.]+)` \|", text, re.MULTILINE))
    assert {room for room in ROOMS if not room.startswith("_")} <= named
    assert all(f"`{room}`" in text for room in CPP)


CHECK = """
import sys
import robsim
print("numpy" in sys.modules)
robsim.Simulation, robsim.Camera
late = {"matplotlib", "cv2", "pandas", "scipy", "typer", "rich", "tqdm", "tomlkit", "platformdirs"}
late |= {"mcap", "jinja2"}
print(sorted(late & set(sys.modules)))
import robsim.lab, robsim.lab
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
