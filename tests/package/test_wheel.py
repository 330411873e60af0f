"""What a wheel holds: what users need. What only developers ask for stays in the clone."""

import importlib.metadata
import re
from pathlib import Path

import robsim

PACKAGE = Path(robsim.__file__).parent

#: Words in the names of what only developers need.
OF_DEVELOPERS = {
    *("bench", "benches", "conftest", "digest", "digests"),
    *("double", "doubles", "fake", "solutions", "test", "tests", "virtual"),
}

#: What is called so, and is for users: the command `robsim bench`, what a grade rests on, and the
#: tests that teachers write.
OF_USERS = (
    *("robsim/cli/simulated/bench.py", "robsim/cli/simulated/bench.py"),
    # which read them, packed
    *("robsim/teach/tasks/solutions.py", "robsim/teach/tasks/solutions.bin"),
    "robsim/teach/assignments/grading/references.py",
    *("robsim/teach/assignments/_own_tests/", "robsim/teach/assignments/templates/tests/"),
)


def files_of_wheel():
    """What the wheel lists that is installed; where the tree is used as it is, its package."""
    listed = importlib.metadata.files("robsim") or ()
    if any(file.locate() == PACKAGE / "__init__.py" for file in listed):
        files = [file.as_posix() for file in listed]
    else:
        found = (file for file in PACKAGE.rglob("*") if file.is_file())
        files = [file.relative_to(PACKAGE.parent).as_posix() for file in found]
    return [file for file in files if "__pycache__" not in file]


def test_a_wheel_has_the_packages_alone():
    packages = r"(robsim|pytest_robsim|robsim-[^/]*\.dist-info|robsim\.libs)/"
    programs = r"(\.\./)+(bin|Scripts)/robsim"
    files = files_of_wheel()
    assert [file for file in files if not re.match(f"{packages}|{programs}", file)] == []


def test_a_wheel_has_nothing_that_only_developers_need():
    files = files_of_wheel()
    assert "robsim/cli/simulated/bench.py" in files
    named = [file for file in files if OF_DEVELOPERS & {*re.split(r"[^a-z]+", file)}]
    assert [file for file in named if not file.startswith(OF_USERS)] == []


def test_rooms_and_their_data_are_there_and_nothing_else_is_compiled():
    files = [Path(file).parts[1:] for file in files_of_wheel() if file.startswith("robsim/")]
    folders = {parts[0] for parts in files if len(parts) > 1}
    assert folders == {*robsim._WINGS, "base", "cli", "assets", "notebooks"}
    compiled = {
        parts[-1].partition(".")[0] for parts in files if parts[-1].endswith((".so", ".pyd"))
    }
    assert compiled <= {"_core", "_firewire", "_gige"}
