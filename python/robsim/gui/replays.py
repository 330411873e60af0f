"""Replay files: scenario, callbacks and changes of a run. `replay` runs it again, to the bit."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np

from robsim.base.checks import check_bool
from robsim.base.files import as_path, read_text
from robsim.base.files.reading import parse_json
from robsim.base.text import one_line
from robsim.gui.facade import Panel
from robsim.gui.hosted import answers_to
from robsim.gui.panels.record import Record
from robsim.gui.panels.view import PanelView
from robsim.simulation import Scenario, Simulation
from robsim.simulation.slots import SLOTS

FORMAT = "robsim replay 1"
_MOST_BYTES = 1 << 26
_MOST_STEPS = 1_000_000
_KINDS = {"format": str, "scenario": str, "slots": list, "files": dict, "changes": list}
_MESSAGES = ("set", "go_to", "path")  # of the browser, that change a run


@dataclass(frozen=True)
class ReplayFile:
    """A run: its start, and each change with its step, stage and message or files."""

    scenario: str  # TOML
    slots: Sequence[str]  # that files fill
    files: Mapping[str, str]  # source of Python modules by name, without .py
    changes: Sequence[Sequence[Any]]
    steps: int
    digest: str
    format: str = FORMAT

    def to_text(self) -> str:
        return json.dumps(asdict(self), indent=1)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> ReplayFile:
        """Read a file; nothing in it runs. ValueError: it is damaged."""
        file = as_path(path)
        try:
            told = parse_json(read_text(file, _MOST_BYTES))
            kinds = {**_KINDS, "steps": int, "digest": str}
            if not isinstance(told, dict) or told.get("format") != FORMAT:
                raise ValueError("it is no replay file of this version")
            if told.keys() != kinds.keys() or any(type(told[n]) is not k for n, k in kinds.items()):
                raise ValueError("it lacks a part")
            found = cls(**told)
            found._check()
        except ValueError as error:
            raise ValueError(f"{one_line(file)}: {error}") from None
        return found

    def _check(self) -> None:
        ks = [self._checked_change(change)[0] for change in self.changes]
        if not 0 <= self.steps <= _MOST_STEPS or ks != sorted(ks) or ks[-1:] > [self.steps]:
            raise ValueError("its steps are in no order")
        sources = [self.files, *(told for *_, told in self.changes if "type" not in told)]
        for name, text in (item for files in sources for item in files.items()):
            if not (name.isidentifier() and isinstance(text, str)):  # no path, such as ../x
                raise ValueError("its Python files have wrong names")
        if any(slot not in list(SLOTS) for slot in self.slots):
            raise ValueError("it fills unknown slots")

    @staticmethod
    def _checked_change(change: Any) -> tuple[int, str, dict[str, Any]]:
        if isinstance(change, list) and [*map(type, change)] == [int, str, dict]:
            k, stage, told = change
            if k >= 0 and told.get("type", _MESSAGES[0]) in _MESSAGES:
                return k, stage, told
        raise ValueError("a change is damaged")

    @property
    def code(self) -> dict[str, int]:
        """The lines of each Python file that would run, by name."""
        files = [self.files, *(told for *_, told in self.changes if "type" not in told)]
        texts = {name: text for one in files for name, text in one.items()}
        return {f"{name}.py": len(text.splitlines()) for name, text in texts.items()}


def digest_of(record: Record) -> str:
    """Return a checksum of all that was recorded."""
    columns = record.columns()
    parts = (np.ascontiguousarray(columns[name]).tobytes() for name in sorted(columns))
    return hashlib.sha256(b"".join(parts)).hexdigest()


def replay(path: str | PathLike[str], *, trust: bool = False) -> Panel:
    """Run a shared run again, and return its panel, paused at the last step.

    Parameters
    ----------
    path : path
        A replay file, as *Share* of a panel gives it.
    trust : bool
        Run the Python code that the file carries, with your rights. Default: a file with code is
        refused before anything of it runs.

    Returns
    -------
    Panel
        The panel; its run can go on.

    Raises
    ------
    PermissionError
        If the file carries code, and `trust` is false; the message names the code.
    TypeError, ValueError, OSError
        If it is no replay file, or cannot be read.

    Warns
    -----
    UserWarning
        If the run came out differently: another version of robsim or of numpy, or callbacks that
        depend on the clock, on other files, or on random numbers beyond the seed.

    Examples
    --------
    >>> robsim.gui.replay("run.replay")  # doctest: +SKIP
    """
    from robsim.base.warn import warn_user

    check_bool("trust", trust)
    file = ReplayFile.load(path)
    if file.code and not trust:
        named = ", ".join(f"{name} ({lines} lines)" for name, lines in file.code.items())
        raise PermissionError(
            f"{one_line(path)} carries Python code, which would run with your rights: {named}; "
            "read it, then give trust=True, in the shell --trust"
        )
    panel = Panel(_begun(file), float("inf"))
    _run_again(panel._view, file)
    if digest_of(panel._view.record) != file.digest:
        warn_user("the run came out differently: see the notes of robsim.gui.replay")
    return panel


def _begun(file: ReplayFile) -> Simulation:
    scenario = Scenario.from_toml(file.scenario)
    if not file.files:
        return Simulation(scenario)
    folder = Path(mkdtemp(prefix="robsim-replay-"))  # stays: the panel shows and edits its files
    _write(folder, file.files)
    return Simulation.from_folder(folder, slots=file.slots, scenario=scenario)


def _write(folder: Path, files: Mapping[str, str]) -> None:
    for name, text in files.items():
        (folder / f"{name}.py").write_bytes(text.encode())


def _run_again(view: PanelView, file: ReplayFile) -> None:
    runner = view.runner
    assert isinstance(runner, Simulation)

    def go_to(k: int, stage: str) -> None:
        if k > runner.n_steps:
            runner.run(1)
            view.share.take(runner.last_step)  # notes files that were changed before that step
            runner.run(k - runner.n_steps)
        while runner.stage != stage and runner.n_steps == k:
            runner.step_stage()

    for k, stage, told in file.changes:
        view.driver.ask(partial(go_to, k, stage))
        if "type" in told:
            answers_to(view, told["type"], {n: v for n, v in told.items() if n != "type"})
        elif runner._folder is not None:
            _write(runner._folder._absolute, told)
    view.driver.ask(partial(go_to, file.steps, "world"))
