"""Open a user's file in an editor, without waiting for the editor."""

from __future__ import annotations

import functools
import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

from robsim.gui._link import Refused

_PLUS, _ALONE = ("+{line}", "{file}"), ("{file}",)
_NAMED = ("--line", "{line}", "{file}")
#: Editors with a window, and their arguments for the line.
_EDITORS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(
        ("code", "code-insiders", "codium", "cursor", "windsurf"), ("--goto", "{file}:{line}")
    ),
    **dict.fromkeys(("subl", "sublime_text", "zed", "zeditor", "mate"), ("{file}:{line}",)),
    **dict.fromkeys(("gedit", "gnome-text-editor", "xed", "pluma", "geany", "gvim"), _PLUS),
    **dict.fromkeys(("emacs", "emacsclient"), _PLUS),
    **dict.fromkeys(("kate", "kwrite", "pycharm", "charm", "mousepad"), _NAMED),
}
#: Editors that need a terminal, which a panel does not have.
_IN_TERMINAL = {
    *("vi", "vim", "nvim", "ex", "ed", "red", "nano", "rnano", "pico", "micro", "emacs-nox", "mg"),
    *("helix", "hx", "joe", "jed", "jove", "ne", "mcedit", "kak", "tilde", "dte"),
    "sensible-editor",
}
_NO_WINDOW = {"-nw", "--no-window-system", "-t", "--tty"}  # of emacs
_started: list[subprocess.Popen[bytes]] = []  # processes outlive a panel


def open_in_editor(file: Path, line: int) -> subprocess.Popen[bytes] | None:
    """Open a file in ``$VISUAL``, ``$EDITOR`` or the system's editor, but never in a terminal.

    Return the process; None = the process is unknown. `Refused` if there is no editor.
    """
    command = _users_editor(file, line) or _systems_editor(file)
    if command is None and sys.platform == "win32":
        os.startfile(file, "edit")  # "open" would run it
        return None
    if command is None:
        raise Refused(
            "no editor with a window was found: set the variable VISUAL, for example to "
            f"'code' or 'gedit', before you start Python, or open {file} yourself"
        )
    _started[:] = [editor for editor in _started if editor.poll() is None]
    try:
        editor = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,  # it lives on when Python is interrupted or ends
        )
    except OSError as error:
        raise Refused(f"{command[0]} could not be started: {error.strerror}") from None
    _started.append(editor)
    return editor


def _users_editor(file: Path, line: int) -> list[str] | None:
    for variable in ("VISUAL", "EDITOR"):
        try:
            words = shlex.split(os.environ.get(variable, ""), posix=sys.platform != "win32")
        except ValueError:
            continue
        program = shutil.which(words[0]) if words else None
        # A shell would read a batch file, and may take a file's name for a command.
        if program is None or program.lower().endswith((".cmd", ".bat")):
            continue
        name = Path(words[0]).stem.lower()
        if not _needs_terminal(name, program, words[1:]):
            where = _EDITORS.get(name, _ALONE)
            return [program, *words[1:], *(one.format(file=file, line=line) for one in where)]
    return None


def _needs_terminal(name: str, program: str, options: list[str]) -> bool:
    """Return whether an editor runs in a terminal, also under a name such as ``editor``."""
    if name in _EDITORS:
        return name.startswith("emacs") and not _NO_WINDOW.isdisjoint(options)
    return not _IN_TERMINAL.isdisjoint({name, Path(program).resolve().stem})


def _systems_editor(file: Path) -> list[str] | None:
    if sys.platform == "darwin":
        return ["open", "-t", str(file)]
    has_screen = os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    program = shutil.which("xdg-open") if has_screen else None
    return None if program is None else [program, str(file)]


def lab_link(file: Path) -> str | None:
    """Return the JupyterLab address of a file, as the path of a URL; None = not available."""
    server = _server()
    if server is None:
        return None
    root, base_url = server
    try:
        inside = file.resolve().relative_to(root)
    except ValueError:  # a file outside of the server's folder
        return None
    return f"{base_url}lab/tree/{quote(inside.as_posix())}"


@functools.cache
def _server() -> tuple[Path, str] | None:
    """Return the folder that the server of this kernel shows, and its base URL.

    Each server describes itself in a file with its process number, the parent of its kernels.
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
