"""The command ``robsim tasks try``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.option import argument, integer_option, number_option, option
from robsim.cli.shared import Json
from robsim.cli.tasks.showing import Name

EXAMPLE = "Example: robsim tasks try park parking --figure park.png"
HELP = (
    "Try a solution of a task, beside a reference in the same runs.\n\n"
    "It says what the scores come to, and what fails in which line. The exit status is 0 if the "
    "solution is as good as the reference, 1 if it is not, 2 if there is nothing to try. It is run "
    "in this process, as your own code: grade those of others with robsim grade."
)


def try_solution(
    name: Name,
    path: Annotated[
        Path,
        argument(
            "FILE|FOLDER", "A folder with the callbacks, or the file of one.", show_default=False
        ),
    ],
    runs: Annotated[
        int | None, integer_option("--runs", "N", "Number of runs. Default: the task's.")
    ] = None,
    seed: Annotated[int, integer_option("--seed", "N", "Another number: other runs.")] = 1,
    time_limit: Annotated[
        float | None,
        number_option(
            "--time-limit", "SECONDS", "Longest duration of a call of a callback. Default: none."
        ),
    ] = None,
    figure: Annotated[
        Path | None, option("--figure", "FILE", "Draw the worst run there: a PNG, PDF or SVG file.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Try a solution of a task."""
    from robsim.cli.results import check_figure_name, check_file, save_figure
    from robsim.teach.tasks.by_name import task

    with errors.report_errors(path if path.is_dir() else path.parent):
        if figure is not None:
            check_figure_name(figure)
            check_file(figure)
        trial = task(name).try_out(path, runs=runs, seed=seed, time_limit=time_limit)
        if figure is not None and trial.worst is not None:
            save_figure(figure, trial.figure())
    errors.show(trial.to_json() if as_json else trial)
    if figure is not None:
        drawn = f"run {trial.worst} is drawn in {figure}"
        errors.print_note(drawn if trial.worst is not None else "all runs failed: none is drawn")
    if not trial.is_solved:
        errors.print_note(f"why: robsim check {one_line(path)} --task {trial.task.name}")
        raise typer.Exit(1)
