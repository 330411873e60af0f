"""What students begin with: the files that ship with a task, and the module with its numbers."""

from __future__ import annotations

from robsim.tasks import Task
from robsim.tasks._solutions import MODULE, SHIPPED, module_source

_START = "start"


def starting_files(task: Task) -> dict[str, str]:
    """Return the files by name."""
    place = SHIPPED / task.name / _START
    files = {file.name: file.read_text(encoding="utf-8") for file in place.glob("*.py")}
    return files | {f"{MODULE}.py": module_source(task).decode()}
