"""What the package says of itself, of what it needs, and of how it is built."""

import importlib.util
import re
import tomllib
from pathlib import Path

import pytest

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
def test_the_actions_of_workflows_are_pinned_by_hash():
    """Since a tag can be moved; the version stands beside it."""
    used = [line for file in WORKFLOWS.glob("*.yml") for line in file.read_text().splitlines()]
    used = [line.strip() for line in used if "uses:" in line]
    assert used
    for line in used:
        assert re.fullmatch(r"- uses: [\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", line), line


def test_pytest_finds_its_plugin():
    """A package of its own, as each run of pytest on a machine loads it."""
    assert PROJECT["entry-points"]["pytest11"] == {"pytest_robsim": "pytest_robsim"}
    assert importlib.util.find_spec("pytest_robsim") is not None
