"""The commands ``robsim tasks``: list, show and try tasks."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.command import command, command_group
from robsim.cli.shared import Json

Name = Annotated[str, "TASK: Name of the task, from robsim tasks list."]


def list_tasks() -> None:
    """List the tasks, and their callbacks.

    Example: robsim tasks list
    """
    from robsim.teach.tasks import TASKS

    rows = [(name, kind.title, ", ".join(kind.slots)) for name, kind in TASKS.items()]
    errors.print_rows(("task", "aim", "callbacks"), rows)


def show(name: Name, to: Path | None = None) -> None:
    """Show a task: its aim, its data, and its scores.

    With --to, the command writes sheet.md to a folder, with a start file for each callback to
    write. The values of the task are in task.py. Existing files are kept.

    --to FOLDER: Folder for the sheet and the start files; created if needed.

    Example: robsim tasks show park --to parking
    """
    from robsim.teach.tasks import task

    one = task(name)
    if to is None:
        _print(one.sheet)
        return
    files = one.begin(to)
    errors.say(f"written to {to}: {', '.join(file.name for file in files)}")
    errors.say(f"read {to / 'sheet.md'}; then: robsim tasks try {name} {to}")


def _print(sheet: str) -> None:
    """Print Markdown, formatted in a terminal."""
    if not sys.stdout.isatty():
        errors.show(sheet)
        return
    from rich.markdown import Markdown

    errors.print_page([Markdown(sheet)])


def try_solution(
    name: Name,
    path: Path,
    runs: int | None = None,
    seed: int = 1,
    time_limit: float | None = None,
    figure: Path | None = None,
    as_json: Json = False,
) -> None:
    """Try a solution of a task, and a reference in the same runs.

    The command prints the scores, and each fault with its line. The exit status is 0 if the
    solution is as good as the reference, 1 if it is worse, 2 without a solution. The solution runs
    in this process, like your own code: grade the code of other people with robsim grade.

    FILE|FOLDER: A folder with the callbacks, a single callback's file, or a notebook.
    --runs N: Number of runs. Default: the number of the task.
    --seed N: Seed of the runs.
    --time-limit SECONDS: Maximum time of each call of a callback. Default: no limit.
    --figure FILE: File for a figure of the worst run: PNG, PDF or SVG.

    Example: robsim tasks try park parking --figure park.png
    """
    from robsim.cli.results import check_figure_name, check_file, save_figure
    from robsim.teach.tasks import task, try_solution

    with errors.report_errors(path if path.is_dir() else path.parent):
        if figure is not None:
            check_figure_name(figure)
            check_file(figure)
        trial = try_solution(task(name), path, runs=runs, seed=seed, time_limit=time_limit)
        if figure is not None and trial.worst is not None:
            save_figure(figure, trial.figure())
    errors.show(trial.to_json() if as_json else trial)
    if figure is not None:
        drawn = f"run {trial.worst} is drawn in {figure}"
        errors.print_note(drawn if trial.worst is not None else "all runs failed: no run is drawn")
    if not trial.is_solved:
        errors.print_note(f"why: robsim check {one_line(path)} --task {trial.task.name}")
        raise typer.Exit(1)


HELP = (
    "A task is a world, the callbacks that you write for it, and scores. robsim tasks show --to "
    "writes the sheet and the start files. Edit the files, and try your solution as often as you "
    "like: it runs on the same seeds as a reference."
)
app = command_group("Start with: robsim tasks list")
command(app, "list")(list_tasks)
command(app)(show)
command(app, "try")(try_solution)
