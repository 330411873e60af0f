"""A task as a challenge: its current score, and the best score on this machine."""

from __future__ import annotations

import json
import math
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from robsim.base.files import read_text, write_whole
from robsim.base.files.reading import parse_json
from robsim.gui.panels.analysis.statistics import Summary
from robsim.gui.panels.places import is_ours
from robsim.gui.panels.settings.owners import owners_of
from robsim.simulation import Simulation
from robsim.simulation.options import OPTIONS
from robsim.simulation.slots import SLOTS
from robsim.vision.robots.lookup import data_folder

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
    from robsim.teach.tasks import Task
    from robsim.trace import Trace

_FILE = "challenges.json"  # in the user's folder: points by challenge
_MOST_KEPT = 200
_FREE = {"seed", *SLOTS}  # of the options of a scenario


class Challenge(Summary):
    """Sends the score of one run of a task, with the metrics of `try_solution`."""

    def __init__(self, panel: PanelView, task: Task) -> None:
        super().__init__(panel)
        self._task = task
        self._reference: Trace | None = None

    def setup(self) -> dict[str, Any]:
        task = self._task
        told = {"title": task.title, "steps": task.steps, "slots": [*task.slots]}
        return {"challenge": told}

    def message(self, trace: Trace) -> dict[str, Any]:
        from robsim.teach.tasks.trial import reference_run, stars_of, trial_of

        runner, task = self.panel.runner, self._task
        assert isinstance(runner, Simulation)
        run = trace[: task.steps]
        head: dict[str, Any] = {"type": "score", "points": None, "stars": 0, "rows": []}
        head |= {"rule": None, "changed": self._changed_options(runner)}
        head |= {"by_hand": self._not_own(runner), "best": None}
        try:
            if self._reference is None:
                self._reference = reference_run(task, runner._seed)
            trial = trial_of(task, run, self._reference)
        except (ValueError, IndexError):  # too few steps yet
            return head
        rows = [[row.title, row.unit, *map(_known, row.values)] for row in trial.tables[0].rows]
        head |= {"rows": rows, "rule": trial.rule}
        if trial.rule is None and not math.isnan(trial.points):
            head |= {"points": trial.points, "stars": stars_of(trial)}
        is_over = len(trace) >= task.steps and not head["changed"]
        points = head["points"] if is_over else None
        head["best"] = _best(f"{_name(task)}{':by hand' if head['by_hand'] else ''}", points)
        return head

    def _changed_options(self, runner: Simulation) -> list[str]:
        """Return the options of the world that differ from the task."""
        asked, now = self._task.scenario, runner.scenario
        other = {name for name in OPTIONS if getattr(asked, name) != getattr(now, name)}
        return sorted((other | {*runner._changed}) - _FREE)

    def _not_own(self, runner: Simulation) -> list[str]:
        """Return the slots of the task without the user's code."""
        owners = owners_of(runner)
        return [
            slot
            for slot in self._task.slots
            if owners.of(slot) != "mine" or is_ours(runner._callbacks[slot])
        ]


def _known(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _name(task: Task) -> str:
    from robsim.teach.tasks.marks.calibration import task_digest

    return f"{task.name} {task_digest(task)[:16]}"


def _best(name: str, points: float | None) -> float | None:
    """Return the best points of a challenge on this machine; save `points` if they are better."""
    kept = _kept()
    best = kept.get(name)
    if points is None or (best is not None and best >= points):
        return best
    kept.pop(name, None)
    newest = dict([*kept.items()][1 - _MOST_KEPT :])
    file = data_folder() / _FILE
    with suppress(OSError):  # the run does not need the file
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, json.dumps(newest | {name: points}).encode())
    return points


def _kept() -> dict[str, float]:
    """Return the saved points; empty for a missing or damaged file."""
    try:
        told = parse_json(read_text(data_folder() / _FILE))
    except (OSError, ValueError):
        return {}
    pairs = told.items() if isinstance(told, dict) else ()
    return {n: float(p) for n, p in pairs if isinstance(p, (int, float)) and 0 <= p <= 1}
