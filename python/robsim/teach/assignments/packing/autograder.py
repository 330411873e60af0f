"""The program that Gradescope runs for each submission.

``python -m robsim.teach.assignments.packing.autograder`` gets the folder of the autograder,
``/autograder`` on Gradescope. It always writes a ``results/results.json``: Gradescope shows
students nothing else.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

from robsim.base.files import write_whole
from robsim.teach.assignments.packing.gradescope import ASSIGNMENT

#: Exit statuses of ``robsim grade`` with results.
_GRADED = (0, 1)

_ENDED = (
    "The grader ended before it had a result, without a fault of your submission: tell your "
    "teacher."
)
_FAILED = "The grader failed, without a fault of your submission: tell your teacher."


def main(root: Path) -> int:
    results = root / "results/results.json"
    _write(results, _ENDED)
    with tempfile.TemporaryDirectory(prefix="robsim-graded-") as out:
        status = subprocess.run(
            [
                *(sys.executable, "-I", "-m", "robsim", "grade"),
                *(str(root / "source" / ASSIGNMENT), str(root / "submission")),
                *("--student", student_in(root / "submission_metadata.json")),
                *("--gradescope", str(results), "--out", out),
            ],
            check=False,
        ).returncode
    told = json.loads(results.read_text(encoding="utf-8"))
    if status not in _GRADED and told.get("output") == _ENDED:
        _write(results, _FAILED)
    return 0 if status in _GRADED else status


def student_in(metadata: Path) -> str:
    """Return the sorted names of all authors: the seed of hidden tests."""
    try:
        users = json.loads(metadata.read_text(encoding="utf-8"))["users"]
        names = [str(user.get("email") or user["id"]) for user in users]
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        names = []
    return "+".join(sorted(names)) or "submission"


def _write(results: Path, sentence: str) -> None:
    results.parent.mkdir(parents=True, exist_ok=True)
    content = {"score": 0, "output": sentence, "stdout_visibility": "hidden"}
    write_whole(results, json.dumps(content).encode())


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1])))
