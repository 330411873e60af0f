"""Parts of robsim that Python in a browser lacks."""

from __future__ import annotations

import sys


def check_has_threads(part: str) -> None:
    """Raise NotImplementedError in a browser (Pyodide), where Python has no threads."""
    if sys.platform == "emscripten":
        raise NotImplementedError(
            f"{part} needs threads, and Python in a browser has no threads. Runs, tracking, "
            "estimation and figures work here; for everything else, install robsim on a computer."
        )
