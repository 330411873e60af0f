"""The package: its metadata, and the files of its wheel."""

import importlib.metadata
import importlib.util
import re
import tomllib
from pathlib import Path

import pytest

import check_release
import robsim

# --- metadata


ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOWS = ROOT / ".github/workflows"


def requirements():
    extras = PROJECT["optional-dependencies"]
    return [*PROJECT["dependencies"], *(one for name in extras for one in extras[name])]


def test_every_dependency_has_a_lowest_version():
    """Which `./run lowest` tries."""
    for requirement in requirements():
        assert requirement.startswith("robsim[") or ">=" in requirement


def test_the_same_dependency_has_the_same_bound_everywhere():
    bounds = {}
    for requirement in requirements():
        bounds.setdefault(re.split(r"[^\w.-]", requirement)[0], set()).add(requirement)
    assert [several for several in bounds.values() if len(several) > 1] == []


@pytest.mark.skipif(not WORKFLOWS.is_dir(), reason="the sdist has no workflows")
def test_the_conda_recipe_and_the_pinned_build_have_the_same_requirements():
    recipe = (ROOT / "conda/recipe.yaml").read_text(encoding="utf-8")
    run = recipe.partition("  run:\n")[2].partition("\n\n")[0]
    needed = {re.sub(r";.*", "", one).replace(">=", " >=") for one in PROJECT["dependencies"]}
    listed = re.findall(r"- (.*)", run.replace("matplotlib-base", "matplotlib"))
    assert {*listed} == {*needed, "python"}
    pinned = (ROOT / ".github/build-requirements.txt").read_text(encoding="utf-8")
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]
    for requirement in table["requires"]:
        assert f"\n{re.split('[>=]', requirement)[0]}==" in f"\n{pinned}"


@pytest.mark.skipif(not WORKFLOWS.is_dir(), reason="the sdist has no workflows")
def test_the_actions_of_workflows_are_pinned_by_hash():
    """Since a tag can be moved; the version stands beside it."""
    used = [line for file in WORKFLOWS.glob("*.yml") for line in file.read_text().splitlines()]
    used = [line.strip() for line in used if "uses:" in line]
    assert used
    for line in used:
        assert re.fullmatch(r"- uses: [\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", line), line


def test_versions_agree_and_the_owner_has_one_file_to_fill_in():
    assert [*check_release.faults_of_tree(rehearse=True)] == []
    if not (ROOT / ".git").exists():
        return
    blanks = [*check_release.faults_of_tree(rehearse=False)]
    assert all(blank.startswith(("pyproject.toml", "CHANGELOG.md", "the tree")) for blank in blanks)
    for file in (*ROOT.glob("*.*"), *ROOT.glob("notebooks/site/*.md")):
        if file.name != "pyproject.toml" and file.is_file():
            text = file.read_text(encoding="utf-8", errors="replace")
            assert not re.search("OWNER[/@.]", text), file


def test_pytest_finds_its_plugin():
    """A package of its own, as each run of pytest on a machine loads it."""
    assert PROJECT["entry-points"]["pytest11"] == {"pytest_robsim": "pytest_robsim"}
    assert importlib.util.find_spec("pytest_robsim") is not None


# --- the wheel


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
    "robsim/teach/assignments/marking/references.py",
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
    assert compiled <= {"_core", "_firewire", "_gige", "librobsim"}
