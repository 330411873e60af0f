"""Pack solutions of tasks or answers of notebooks: `python write_solutions.py FOLDER FILE`.

A test compares FILE with the folder, so that no change is forgotten.
"""

import sys
from pathlib import Path

from robsim.teach.tasks.solutions import pack


def sources_in(folder: Path) -> dict[str, str]:
    """Return the files of a folder by name: of their task, or their notebook."""
    files = (file for file in sorted(folder.iterdir()) if file.suffix in (".toml", ".py"))
    return {file.stem: file.read_text(encoding="utf-8") for file in files}


if __name__ == "__main__":
    Path(sys.argv[2]).write_bytes(pack(sources_in(Path(sys.argv[1]))))
