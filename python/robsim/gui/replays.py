"""`replay`: rerun a shared run in a panel."""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from contextlib import ExitStack
from functools import partial
from os import PathLike
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp

from robsim.base.checks import check_bool
from robsim.base.files import write_whole
from robsim.base.text import one_line
from robsim.base.warn import warn_user
from robsim.gui.facade import Panel
from robsim.gui.hosted import answers_to
from robsim.gui.panels.replay_file import ReplayFile, digest_of
from robsim.gui.panels.view import PanelView
from robsim.simulation import Scenario, Simulation


def replay(path: str | PathLike[str], *, trust: bool = False) -> Panel:
    """Rerun a shared run, and return its panel, which is paused at the last step.

    Parameters
    ----------
    path : path
        A replay file, made by *Share* in a panel.
    trust : bool
        Whether to run the Python code in the file, with your rights. By default, a file with code
        is refused before any of its code runs.

    Returns
    -------
    Panel
        The panel; its run can continue. The callbacks' files are in a temporary folder, which is
        removed when the panel is closed.

    Raises
    ------
    PermissionError
        If the file contains code, and `trust` is false; the message names the code.
    TypeError, ValueError, OSError
        If the file is not a replay file, or cannot be read.

    Warns
    -----
    UserWarning
        If the result differs from the original run. Reasons: another version of robsim or numpy,
        or callbacks that depend on the clock, on other files, or on unseeded random numbers.

    Examples
    --------
    >>> import json, pathlib
    >>> parts = {"format": "robsim replay 1", "scenario": "", "slots": ["control"],
    ...          "files": {"control": "def control(step): return 0, 0"},
    ...          "changes": [], "steps": 0, "digest": ""}
    >>> size = pathlib.Path("run.replay").write_text(json.dumps(parts))
    >>> robsim.gui.replay("run.replay")
    Traceback (most recent call last):
        ...
    PermissionError: run.replay contains Python code, which would run with your rights: control.py
    (1 lines); read the code, then pass trust=True, or --trust in the shell
    """
    check_bool("trust", trust)
    file = ReplayFile.load(path)
    if file.code and not trust:
        named = ", ".join(f"{name} ({lines} lines)" for name, lines in file.code.items())
        raise PermissionError(
            f"{one_line(path)} contains Python code, which would run with your rights: {named}; "
            "read the code, then pass trust=True, or --trust in the shell"
        )
    return run_again(file)


def run_again(file: ReplayFile) -> Panel:
    """Rerun a loaded file, with its code; see `replay`."""
    folder = Path(mkdtemp(prefix="robsim-replay-"))  # the panel shows and edits its files
    with ExitStack() as undo:
        undo.callback(rmtree, folder, ignore_errors=True)
        panel = undo.enter_context(Panel(_begun(file, folder), float("inf")))
        _run_again(panel._view, file)
        undo.pop_all()
    weakref.finalize(panel, rmtree, folder, ignore_errors=True)
    if digest_of(panel._view.record.columns()) != file.digest:
        warn_user("the rerun differs from the original run; see the warnings in robsim.gui.replay")
    return panel


def _begun(file: ReplayFile, folder: Path) -> Simulation:
    scenario = Scenario.from_toml(file.scenario)
    if not file.files:
        return Simulation(scenario)
    _write(folder, file.files)
    return Simulation.from_folder(folder, slots=file.slots, scenario=scenario)


def _write(folder: Path, files: Mapping[str, str]) -> None:
    for name, text in files.items():
        write_whole(folder / f"{name}.py", text.encode())


def _run_again(view: PanelView, file: ReplayFile) -> None:
    runner = view.runner
    assert isinstance(runner, Simulation)

    def go_to(k: int, stage: str) -> None:
        if k > runner.n_steps:
            runner.run(1)
            view.share.take(runner.last_step)  # notes changes of files before that step
            runner.run(k - runner.n_steps)
            view.share.take(runner.last_step)
        while runner.stage != stage and runner.n_steps == k:
            runner.step_stage()

    for k, stage, told in file.changes:
        view.driver.ask(partial(go_to, k, stage))
        if "type" in told:
            answers_to(view, told["type"], {n: v for n, v in told.items() if n != "type"})
        elif runner._folder is not None:
            _write(runner._folder._absolute, told)
    view.driver.ask(partial(go_to, file.steps, "world"))
