"""The files of a class that is graded: what is there already is not done again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from robsim.base.checks import Floats
from robsim.base.files import write_whole
from robsim.base.text import quoted
from robsim.teach.assignments.results import SubmissionResult
from robsim.teach.errors import AssignmentError
from robsim.teach.reports.writing import RESULT, write_student

PATHS = "paths.json"
_TAKEN = frozenset({"class.html", "class.csv", "results.json"})
_MOST = 2**26  # bytes


class ResultFolder:
    """Where the results of submissions lie, each in a folder of its own.

    Parameters
    ----------
    folder : Path
        The folder.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def of(self, student: str) -> Path:
        """Return the folder of a submission."""
        if student in _TAKEN or "/" in student or "\\" in student:
            raise AssignmentError(f"no submission can have the name {quoted(student)}: rename it")
        return self.folder / student

    def read(self, student: str) -> SubmissionResult | None:
        """Return what came of a submission; None = nothing, or nothing that can be read."""
        try:
            text = (self.of(student) / RESULT).read_bytes()[:_MOST].decode()
            return SubmissionResult.from_json(text)
        except (OSError, ValueError):
            return None

    def students(self) -> list[str]:
        return sorted(file.parent.name for file in self.folder.glob(f"*/{RESULT}"))

    def write(
        self,
        result: SubmissionResult,
        pictures: Mapping[str, bytes],
        paths: Mapping[str, list[list[float]]],
    ) -> None:
        """Write what came of a test: its picture and path, then the result so far."""
        place = self.of(result.student)
        place.mkdir(parents=True, exist_ok=True)
        for test in result.tests:
            if test.picture and test.name in pictures:
                write_whole(place / test.picture, pictures[test.name])
        if paths:
            known = {**self._paths(result.student), **paths}
            write_whole(place / PATHS, json.dumps(known).encode())
        write_whole(place / RESULT, (result.to_json() + "\n").encode())

    def write_whole(self, result: SubmissionResult) -> None:
        """Write all files of a submission that is done."""
        write_student(self.of(result.student), result)

    def pictures(self, result: SubmissionResult) -> dict[str, bytes]:
        """Return the pictures of a result that are there, by test."""
        files = {
            one.name: self.of(result.student) / one.picture for one in result.tests if one.picture
        }
        return {name: file.read_bytes() for name, file in files.items() if file.is_file()}

    def paths(self, student: str) -> dict[str, Floats]:
        """Return the path of the best run of each test, (N, 2)."""
        return {name: np.asarray(path, float) for name, path in self._paths(student).items()}

    def _paths(self, student: str) -> dict[str, list[list[float]]]:
        try:
            data = json.loads((self.of(student) / PATHS).read_bytes())
        except (OSError, ValueError):
            return {}
        return data if isinstance(data, dict) else {}
