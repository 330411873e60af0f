"""One fault at a time: put in, built, and tried by the tests of one or more trees."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from mutants.fault import Fault

_LONGEST = 3600  # s, of a build or a run of tests; what hangs is caught
_LONGEST_IN_CPP = 120  # s
_LONGEST_TEST = 120  # s; whoever waits longer for what a fault keeps from happening has caught it
#: Folders of tests that take long, by the folder of the fault; other faults: folders of its name.
_RELATED = {
    "base": "files geometry trace robots simulation fuzz digests",
    "assignments": "assignments cli",
    "bindings": "bindings simulation threads fuzz vision",
    "calibration": "calibration live",
    "cameras": "capture live",
    "capture": "capture live",
    "cli": "cli",
    "elementary": "elementary simulation digests world",
    "estimation": "estimation identification simd digests",
    "evaluation": "evaluation reference statistics",
    "grading": "grading assignments",
    "identification": "identification doctor statistics",
    "imaging": "imaging capture fuzz simd vision",
    "isolation": "grading",
    "laboratory": "live",
    "markers": "vision fuzz simulation",
    "model": "model simulation digests",
    "motors": "motors live simulation",
    "rehearsal": "live",
    "reports": "assignments",
    "simd": "simd vision world",
    "sessions": "sessions live",
    "submissions": "grading fuzz",
    "simulation": "simulation threads grading digests",
    "tasks": "tasks assignments doctor guards",
    "vision": "vision simd fuzz simulation digests",
    "world": "world simd simulation digests",
}


def run(command: list[str], **options) -> subprocess.CompletedProcess[str]:
    """Run a command, and return what it printed."""
    options = {"timeout": _LONGEST} | options
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


@dataclass(frozen=True)
class Bench:
    """A folder with a copy of the tree, its build, and what is installed of it."""

    root: Path
    folder: Path

    @property
    def tree(self) -> Path:
        return self.folder / "tree"

    @property
    def site(self) -> Path:
        return self.folder / "site"

    def prepare(self) -> None:
        """Copy the tree, and build it."""
        shutil.rmtree(self.tree, ignore_errors=True)
        self.tree.mkdir(parents=True)
        for name in ("cpp", "python", "assets", "notebooks"):
            shutil.copytree(self.root / name, self.tree / name)
        for name in ("CMakeLists.txt", "pyproject.toml", "README.md", "LICENSE"):
            shutil.copy2(self.root / name, self.tree)
        (self.tree / "tests").mkdir()
        for name in ("core", "doubles"):
            shutil.copytree(self.root / "tests" / name, self.tree / "tests" / name)
        packages = run([sys.executable, "-c", "import site; print(site.getsitepackages()[0])"])
        configured = run(
            [
                *("cmake", "-S", str(self.tree), "-B", str(self.folder / "cmake"), "-G", "Ninja"),
                *("-DCMAKE_BUILD_TYPE=Release", "-DROBSIM_TESTS=ON"),
                f"-DCMAKE_PREFIX_PATH={packages.stdout.strip()}",
                f"-DPython_EXECUTABLE={sys.executable}",
            ],
            env=_path(),
        )
        assert configured.returncode == 0, configured.stderr
        assert self.build() is None, self.build()

    def build(self) -> str | None:
        """Compile what changed and install all of it; return what the compiler says if it fails."""
        targets = ("all", "robsim_doubles")
        command = ["cmake", "--build", str(self.folder / "cmake"), "--target", *targets]
        built = run(command, env=_path())
        if built.returncode:
            return built.stdout[-2000:]
        shutil.rmtree(self.site, ignore_errors=True)
        shutil.copytree(self.tree / "python", self.site)
        command = ["cmake", "--install", str(self.folder / "cmake"), "--prefix", str(self.site)]
        installed = run(command, env=_path())
        assert installed.returncode == 0, installed.stderr
        return None

    def restore(self, file: str) -> None:
        """Take a fault out of a file."""
        shutil.copyfile(self.root / file, self.tree / file)

    def core_tests(self) -> str | None:
        """Return the first C++ test that fails, None if all pass."""
        command = [str(self.folder / "cmake/robsim_tests"), "--gtest_brief=1"]
        try:
            done = run(command, timeout=_LONGEST_IN_CPP)
        except subprocess.TimeoutExpired:
            return "C++ tests: they do not end"
        if done.returncode == 0:
            return None
        failed = re.search(r"\[  FAILED  \] (\S+)", done.stdout)
        return f"C++ {failed[1]}" if failed else f"C++ tests: exit status {done.returncode}"

    def caught_by(self, tests: Path, fault: Fault) -> str | None:
        """Return the first test that fails: of the fault's folders, of all, of its long ones."""
        if fault.file.startswith("cpp") and (found := self.core_tests()) is not None:
            return found
        rooms = [part for part in Path(fault.file).parts[:-1] if part in _RELATED]
        room = rooms[-1] if rooms else Path(fault.file).parts[2]
        folders = [f"tests/{one}" for one in _RELATED.get(room, room).split()]
        folders = [folder for folder in folders if (tests / folder).is_dir()]
        quick, others = "not slow and not long", "slow or long"
        for marks, where in ((quick, folders), (quick, ["tests"]), (others, folders)):
            if where and (found := self._pytest(tests, marks, where)) is not None:
                return found
        return None

    def _pytest(self, root: Path, marks: str, folders: list[str]) -> str | None:
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "2", "-p", "no:cacheprovider"]
        command += ["-o", f"timeout={_LONGEST_TEST}"]
        path = f"{self.site}{os.pathsep}{self.folder / 'cmake/tests/doubles'}"
        environment = os.environ | {"PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1"}
        try:
            done = run([*command, "-m", marks, *folders], cwd=root, env=environment)
        except subprocess.TimeoutExpired:
            return "the tests do not end"
        if done.returncode in (0, 5):  # 5: none is marked so
            return None
        failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
        return failed[1] if failed else f"pytest: exit status {done.returncode}"


def _path() -> dict[str, str]:
    return os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
