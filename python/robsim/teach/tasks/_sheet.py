"""The sheet of a task: what students read."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from robsim.base.text import listed
from robsim.simulation.slots import ONCE, SLOTS

if TYPE_CHECKING:
    from robsim.teach.tasks.definition import Task

_SHEETS = Path(__file__).parent / "sheets"

_GIVEN = {
    "frames": "The camera's frame, `step.frame`, and the coloured blobs found in it, `step.blobs`.",
    "blobs": "The coloured blobs in the camera's frame, `step.blobs`, but not the frame itself.",
    "pose": "The measured pose, `step.measurement`, or None where the robot was not seen.",
}


def sheet_of(task: Task) -> str:
    """Return the sheet of a task: its own part, and what all have."""
    own = (_SHEETS / f"{task.name}.md").read_text(encoding="utf-8")
    parts = [own.format_map(task.parameters).strip(), *_common(task)]
    return "\n\n".join(parts) + "\n"


def _common(task: Task) -> Iterator[str]:
    yield "## What you write"
    yield "\n".join(_files(task))
    yield "## What you are given"
    example = f"`from task import {next(iter(task.values))}`"
    yield f"{_GIVEN[task.given]} And from the module `task`, as {example}:"
    yield "\n".join(["| name | value |", "| --- | --- |", *_rows_of_values(task)])
    yield (
        "A run is from a seed of its own, and so differs from others. You may import numpy, what "
        f"Python brings along, files of your own, and robsim without {listed(_masked(task))}."
    )
    yield "## How it is scored"
    yield "\n".join(
        ["| score | unit | share of the points |", "| --- | --- | --- |", *_rows_of_scores(task)]
    )
    yield (
        f"Your code is run {task.runs} times for {task.steps} steps, and so is a reference in the "
        "same runs. What counts is how many times the reference's your numbers are, as the "
        "geometric mean over the runs: about as good as the reference gives all points, and what a "
        "naive solution reaches gives none. A run that ends with an error has no points."
    )
    yield "## Try it"
    yield "\n".join(
        [
            "```",
            f"robsim tasks show {task.name} --to mine",
            f"robsim tasks try {task.name} mine",
            f"robsim check mine --task {task.name}  # which score is short, and why",
            "```",
        ]
    )


def _files(task: Task) -> Iterator[str]:
    for slot in (SLOTS[name] for name in task.slots):
        when = "once, at the start" if slot.when == ONCE else "at each step"
        yield f"- `{slot.name}.py` with `{slot.signature}`, called {when}: {slot.result}."


def _rows_of_values(task: Task) -> Iterator[str]:
    for name, value in task.values.items():
        yield f"| `{name}` | `{value!r}` |"


def _rows_of_scores(task: Task) -> Iterator[str]:
    for score in task.scores:
        yield f"| {score.title} | {score.unit} | {100 * score.share:.0f} % |"


def _masked(task: Task) -> list[str]:
    """Return what is masked, once: a name at the top is that of its room, too."""
    names = {name.rpartition(".")[2]: name for name in sorted(task.masked, reverse=True)}
    return [f"`{name}`" for name in sorted(names.values())]
