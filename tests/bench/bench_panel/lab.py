"""A JupyterLab on this machine alone, with settings of its own, and its notebooks in a browser."""

from __future__ import annotations

import contextlib
import json
import os
import secrets
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from playwright.sync_api import BrowserContext

_PATIENCE = 60.0  # s
_QUIET = {"fetchNews": "false", "checkForUpdates": False}
_TICK = 50  # ms


@dataclass(frozen=True)
class Server:
    """A JupyterLab that runs; `folder` has its notebooks and all that it writes."""

    folder: Path
    address: str
    token: str


@contextmanager
def lab_server(folder: Path) -> Iterator[Server]:
    """Start a JupyterLab; its kernels end with it."""
    name = "notification.jupyterlab-settings"
    settings = folder / "settings/@jupyterlab/apputils-extension" / name
    settings.parent.mkdir(parents=True)
    settings.write_text(json.dumps(_QUIET))
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    server = Server(folder, f"http://127.0.0.1:{port}", secrets.token_hex(16))
    with open(folder / "lab.log", "w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *_arguments(folder, port)],
            env=os.environ | _environment(server),
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        _wait_until_up(process, server)
        yield server
    finally:
        _end(process)


def _arguments(folder: Path, port: int) -> list[str]:
    return [
        *("--no-browser", "--allow-root", f"--ServerApp.root_dir={folder}"),
        *(f"--ServerApp.port={port}", "--ServerApp.ip=127.0.0.1", "--ServerApp.port_retries=0"),
        f"--NotebookNotary.data_dir={folder}",
    ]


def _environment(server: Server) -> dict[str, str]:
    """Return what makes it write nothing but in its folder."""
    names = ("JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    own = {name: str(server.folder / name.lower()) for name in names}
    return own | {
        "JUPYTERLAB_SETTINGS_DIR": str(server.folder / "settings"),
        "JUPYTERLAB_WORKSPACES_DIR": str(server.folder / "workspaces"),
        "JUPYTER_TOKEN": server.token,  # not an argument, which all users of the machine can read
    }


def _wait_until_up(process: subprocess.Popen[bytes], server: Server) -> None:
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            with urllib.request.urlopen(f"{server.address}/api/status?token={server.token}"):
                return
        except OSError:
            if process.poll() is not None or time.monotonic() > end:
                log = (server.folder / "lab.log").read_text()
                raise RuntimeError(f"JupyterLab does not start:\n{log}") from None
            time.sleep(0.1)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()  # which ends its kernels
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(15)
    if process.poll() is None:
        if sys.platform == "win32":
            process.kill()
        else:
            os.killpg(process.pid, signal.SIGKILL)  # kernels end when they notice
        process.wait()


def write_notebook(file: Path, cells: Sequence[str]) -> None:
    """Write a notebook of code cells."""
    about: dict[str, object] = {"cell_type": "code", "metadata": {}, "execution_count": None}
    python = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook = {
        "cells": [
            {**about, "id": f"cell-{i}", "source": code, "outputs": []}
            for i, code in enumerate(cells)
        ],
        "metadata": {"kernelspec": python},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    file.write_text(json.dumps(notebook))


class Lab:
    """A notebook that is open in a browser.

    Attributes
    ----------
    page : playwright.sync_api.Page
        The tab of the browser.
    """

    def __init__(self, context: BrowserContext, server: Server, file: Path) -> None:
        self._file = file
        self._address = f"{server.address}/lab/tree/{file.name}?token={server.token}&reset"
        self.page = context.new_page()
        self.page.set_default_timeout(1000 * _PATIENCE)
        self.open()

    def open(self) -> None:
        """Open the notebook as it is in its file; its kernel goes on, or begins."""
        self.page.goto(self._address)
        self.wait_until_idle()

    def wait_until_idle(self) -> None:
        """Wait for the notebook and its kernel."""
        indicator = ".jp-NotebookPanel-toolbar .jp-Notebook-ExecutionIndicator[data-status=idle]"
        self.page.wait_for_selector(indicator)
        self.page.wait_for_selector("#jp-main-statusbar >> text=/Idle$/")

    def run(self, i: int, *, until_done: bool = True) -> None:
        """Run a cell."""
        before = self._number(i)
        for _ in range(8):  # right after the notebook is loaded, keys are lost
            self._cell(i).locator(".cm-content").click(position={"x": 5, "y": 5})
            self.page.keyboard.press("Control+Enter")
            for _ in range(1000 // _TICK):
                if has_begun := self._number(i) != before:  # the same again in a new kernel
                    break
                self.page.wait_for_timeout(_TICK)
            while until_done and self.is_busy(i):
                self.page.wait_for_timeout(_TICK)
            if has_begun:
                return
        raise RuntimeError(f"cell {i} does not run")

    def is_busy(self, i: int) -> bool:
        """Return whether a cell runs, or waits for others."""
        return "*" in self._number(i)

    def output(self, i: int) -> str:
        """Return the text below a cell."""
        return str(self._cell(i).locator(".jp-OutputArea").inner_text())

    def command(self, name: str) -> None:
        """Press a button of the toolbar."""
        self.page.locator(f"[data-command='{name}']").first.click()

    def saved(self) -> str:
        """Save the notebook; return what is in its file then."""
        before = self._file.stat().st_mtime_ns
        self.page.keyboard.press("Control+s")
        for _ in range(10_000 // _TICK):
            self.page.wait_for_timeout(_TICK)
            text = self._file.read_text()
            if self._file.stat().st_mtime_ns != before and text.endswith("}\n"):
                return text
        raise RuntimeError("the notebook is not saved")

    def _cell(self, i: int) -> Any:
        return self.page.locator(".jp-Notebook .jp-CodeCell").nth(i)

    def _number(self, i: int) -> str:
        return str(self._cell(i).locator(".jp-InputPrompt").first.inner_text())
