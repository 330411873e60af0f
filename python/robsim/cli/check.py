"""The command ``robsim check``: problems of callbacks, and their lines."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from robsim.base.checks import check_choice
from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.errors import styled
from robsim.cli.shared import Json
from robsim.simulation.slots import SLOTS

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

    from robsim.teach.doctor import FolderReport, TaskReport


_STYLES = {"well": "green", "remark": "yellow", "ill": "bold red"}


def check(
    path: Path,
    slot: Annotated[str | None, f"--slot NAME: Check only this slot: {', '.join(SLOTS)}."] = None,
    task: str | None = None,
    as_json: Json = False,
) -> None:
    """Check callbacks.

    Each file of the folder is tried in many situations: an unseen robot, a heading that passes
    +-180 degrees, the wall, a long run. The exit status is 0 if all files pass, 1 if one fails, 2
    if the folder has no callbacks. A check stops calls longer than 5 s, and prints a line to stderr
    at its end.

    With --task, the callbacks also run in the world of this task, as in robsim tasks try. The
    report shows whether they solve the task, each score that misses its limit, and the reason. The
    exit status is 0 if they solve the task, and all files pass.

    FILE|FOLDER: A folder with callbacks, one of its files, or a notebook.
    --task NAME: Also try the callbacks on this task; see robsim tasks list.

    Example: robsim check mine
    """
    os.environ["MPLBACKEND"] = "agg"  # plt.show returns at once
    progress = None if as_json else errors.print_note
    if progress:
        progress(f"checking {one_line(path)}")
    from robsim.teach.doctor import check_folder

    if slot is not None:
        check_choice("--slot", slot, tuple(SLOTS))
    report = check_folder(path, slots=slot, task=task, progress=progress)
    if as_json:
        errors.show(report.to_json())
    else:
        errors.print_page(_page(report))
    if not report.ok:
        raise typer.Exit(1)


def _page(report: FolderReport) -> Iterator[RenderableType]:
    """Yield the page of a folder: a line for each slot, then the problems of each slot."""
    from rich.table import Table

    from robsim.teach.doctor import TaskReport

    yield styled(report.headline, "bold")
    if isinstance(report, TaskReport):
        yield from _scores(report)
    table = Table.grid(padding=(0, 3), pad_edge=True)
    for slot, verdict in report.verdicts.items():
        if isinstance(report, TaskReport) and slot not in (*report.task.slots, *report.not_used):
            continue  # the task does not use this slot
        file = "" if isinstance(one := report.checks[slot], str) else one.name
        table.add_row(slot, styled(verdict, _STYLES.get(verdict, "dim")), file)
    yield table
    of_files: set[str] = set()
    for one in report.checks.values():
        if not isinstance(one, str):
            if one.problems or one.remarks:
                yield from _numbered(one.name, one.problems)
            for remark in one.remarks:
                yield _hanging("-", remark)
            of_files |= {f"{one.name}: {remark}" for remark in one.remarks}
    if isinstance(report, TaskReport) and report.findings:
        yield from _numbered("findings in the runs of the task", report.findings)
    for remark in report.remarks:
        if remark not in of_files:
            yield ""
            yield _hanging("-", remark)


def _scores(report: TaskReport) -> Iterator[RenderableType]:
    """Yield a line for each score of a task that is short of its limit."""
    for sentence in report.short.values():
        yield _hanging("<", sentence)
    yield ""


def _numbered(title: str, problems: Sequence[Any]) -> Iterator[RenderableType]:
    yield ""
    yield styled(title, "bold")
    for number, problem in enumerate(problems, 1):
        yield _hanging(f"{number}.", problem.sentence)
        if problem.where:
            yield _hanging("", problem.where, "dim")
        if problem.code:
            yield _hanging("", f"> {problem.code}", "cyan")


def _hanging(mark: str, text: str, style: str = "") -> Table:
    """Return a text beside a mark, all its lines indented alike."""
    from rich.table import Table

    grid = Table.grid(padding=(0, 1), pad_edge=True)
    grid.add_column(width=3, justify="right")
    grid.add_column(overflow="fold")
    grid.add_row(mark, styled(text, style))
    return grid
