"""Make it mine: create a callback's file in the user's folder from the default's example."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

from robsim.base.files import write_whole
from robsim.simulation import Experiment, Simulation
from robsim.simulation.callback_folder import CallbackFolder
from robsim.simulation.slots import AT_START, SLOTS

_FOLDER = "mine"  # of a run without a folder
_OFF = re.compile(r"^ENABLED *= *False", re.MULTILINE)


def can_make(runner: Simulation | Experiment, slot: str) -> bool:
    """Return whether a slot can get a new file, or has a file that can be switched on."""
    return runner._folder is None or slot in runner._folder._slots


def make_mine(runner: Simulation | Experiment, slot: str) -> Path:
    """Write the file of a slot, and fill the slot from the file; in the thread of the run.

    An existing file is kept, and switched on. The next reset fills a slot of the start.
    If the file has an error, the slot keeps its callback.
    """
    folder = runner._folder or CallbackFolder(_free_folder(), runner.SLOTS)
    file = folder._absolute / f"{slot}.py"
    source = file if file.exists() else SLOTS[slot].template
    text = source.read_text("utf-8")
    file.parent.mkdir(parents=True, exist_ok=True)
    if source != file or _OFF.search(text):
        write_whole(file, _OFF.sub("ENABLED = True", text).encode())
    before = runner._folder, runner._given[slot]
    runner._folder, runner._given[slot] = folder, None
    if not (slot in AT_START and runner._core.has_started):
        try:
            runner._use(folder.load_saved())
        except BaseException:
            runner._folder, runner._given[slot] = before
            raise
    return file


def _free_folder() -> Path:
    names = itertools.chain([_FOLDER], (f"{_FOLDER}{n}" for n in itertools.count(2)))
    return next(path for path in map(Path, names) if not path.exists())
