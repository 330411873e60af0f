"""Links to files in JupyterLab."""

from __future__ import annotations

import functools
import json
import os
from pathlib import Path
from urllib.parse import quote


def lab_link(file: Path) -> str | None:
    """Return where JupyterLab shows a file, as the path of a URL; None = it does not."""
    server = _server()
    if server is None:
        return None
    root, base_url = server
    try:
        inside = file.resolve().relative_to(root)
    except ValueError:  # a file outside of what the server shows
        return None
    return f"{base_url}lab/tree/{quote(inside.as_posix())}"


@functools.cache
def _server() -> tuple[Path, str] | None:
    """Return the folder that the server of this kernel shows, and its base URL.

    A kernel is not told the folder. But each server describes itself in a file under the number of
    its process, which is the parent of its kernels.
    """
    parent = os.environ.get("JPY_PARENT_PID", "")
    if not parent.isdecimal():
        return None
    try:
        from jupyter_core.paths import jupyter_runtime_dir

        file = Path(jupyter_runtime_dir()) / f"jpserver-{parent}.json"
        told = json.loads(file.read_text("utf-8"))
        return Path(told["root_dir"]).resolve(), str(told["base_url"])
    except (ImportError, OSError, ValueError, KeyError, TypeError):
        return None  # a kernel of another host, such as VS Code
