"""A JupyterLab for tests, on this machine alone, with settings of its own; and its notebooks."""

import json
import os
import secrets
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager

import nbformat

QUIET = {"fetchNews": "false", "checkForUpdates": False}


@contextmanager
def lab_server(folder, *, theme="JupyterLab Light"):
    """A running server: its address with the token, for notebooks in a folder."""
    settings = {"notification": QUIET, "themes": {"theme": theme}}
    for name, values in settings.items():
        file = folder / "settings/@jupyterlab/apputils-extension" / f"{name}.jupyterlab-settings"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(values))
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    token = secrets.token_hex(16)
    arguments = [
        *("--no-browser", "--allow-root", f"--ServerApp.root_dir={folder}"),
        *(f"--ServerApp.port={port}", "--ServerApp.ip=127.0.0.1", "--ServerApp.port_retries=0"),
        f"--IdentityProvider.token={token}",
    ]
    with open(folder / "lab.log", "w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *arguments],
            env=os.environ | _folders(folder),
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    address = f"http://127.0.0.1:{port}"
    try:
        _wait_until_up(process, f"{address}/api/status?token={token}")
        yield address, token
    finally:
        _end(process)


def _folders(folder):
    """Nothing of the user's is read or written."""
    return {
        name: str(folder / name.lower())
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR")
    } | {
        "JUPYTERLAB_SETTINGS_DIR": str(folder / "settings"),
        "JUPYTERLAB_WORKSPACES_DIR": str(folder / "workspaces"),
    }


def _wait_until_up(process, address, seconds=60):
    end = time.monotonic() + seconds
    while True:
        try:
            with urllib.request.urlopen(address):
                return
        except OSError:
            assert process.poll() is None, "JupyterLab has ended"
            assert time.monotonic() < end, "JupyterLab does not answer"
            time.sleep(0.2)


def _end(process):
    process.terminate()  # which ends its kernels
    try:
        process.wait(15)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def write_notebook(file, cells):
    """Write a notebook of code cells."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(code) for code in cells])
    python = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook.metadata.kernelspec = python
    nbformat.write(notebook, file)


class Lab:
    """A notebook that is open in a browser."""

    def __init__(self, context, server, file):
        address, token = server
        self.page = context.new_page()
        self.page.set_default_timeout(60_000)
        self.page.goto(f"{address}/lab/tree/{file}?token={token}&reset")
        self.wait_until_idle()

    def wait_until_idle(self):
        indicator = ".jp-NotebookPanel-toolbar .jp-Notebook-ExecutionIndicator[data-status=idle]"
        self.page.wait_for_selector(indicator)
        self.page.wait_for_selector("#jp-main-statusbar >> text=/Idle$/")

    def cell(self, i):
        return self.page.locator(".jp-Notebook .jp-CodeCell").nth(i)

    def run(self, i, *, until_done=True):
        """Run a cell. Right after the notebook is loaded, keys are lost: try again."""
        before = self._number(i)
        for _ in range(8):
            self.cell(i).locator(".cm-content").click(position={"x": 5, "y": 5})
            self.page.keyboard.press("Control+Enter")
            self.page.wait_for_timeout(500)
            while self.is_busy(i):
                if not until_done:
                    return
                self.page.wait_for_timeout(50)
            if self._number(i) != before:
                return
        raise AssertionError("the cell does not run")

    def _number(self, i):
        return self.cell(i).locator(".jp-InputPrompt").first.inner_text()

    def is_busy(self, i):
        return "*" in self._number(i)

    def output(self, i):
        return self.cell(i).locator(".jp-OutputArea").inner_text()

    def command(self, name):
        """Press a button of the toolbar."""
        self.page.locator(f"[data-command='{name}']").first.click()

    def saved(self, file):
        """Save the notebook; what is in its file then."""
        before = file.stat().st_mtime_ns
        self.page.keyboard.press("Control+s")
        while True:
            self.page.wait_for_timeout(100)
            text = file.read_text()
            if file.stat().st_mtime_ns != before and text.endswith("}\n"):
                return nbformat.reads(text, 4)
