"""The check of callback files for a task: their trial, its findings, and the usual checks."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import redirect_stdout
from dataclasses import fields
from os import PathLike

from robsim.base.check_report import CheckReport, Problem
from robsim.base.text import quoted
from robsim.simulation.slots import RobotSlots
from robsim.teach.doctor._run_checks import telling
from robsim.teach.doctor._trial import TIME_LIMIT, StdoutCapture
from robsim.teach.doctor.callbacks.folder import FolderReport, Surroundings, report_of
from robsim.teach.doctor.callbacks.scenes import Setting
from robsim.teach.doctor.task_checks.drives import drive_findings
from robsim.teach.doctor.task_checks.estimates import (
    measured_findings,
    parameter_findings,
    state_findings,
)
from robsim.teach.doctor.task_checks.report import REFUSED, TaskReport
from robsim.teach.doctor.task_checks.seen_run import SeenRun
from robsim.teach.tasks.by_name import task as named_task
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.solutions import MODULE, Solution, module_source
from robsim.teach.tasks.trial import TaskTrial, try_solution, why_not_own

_LOOKS = {
    RobotSlots.control.name: drive_findings,
    RobotSlots.measure.name: measured_findings,
    RobotSlots.estimate_state.name: state_findings,
    RobotSlots.estimate_parameters.name: parameter_findings,
}
#: Kinds of problems that spoil no run.
_NO_CAUSE = {"prints", "too slow"}


def check_for_task(
    path: str | PathLike[str], slots: str | Iterable[str] | None, task: str | Task
) -> TaskReport:
    """Check callback files for a task; `check_folder` documents the arguments."""
    if not isinstance(task, (str, Task)):
        raise TypeError(f"task must be a Task, or its name, got {quoted(task)}")
    chosen = named_task(task) if isinstance(task, str) else task
    solution = Solution.load(path, chosen.slots, is_right=False)
    around = _surroundings(chosen)
    report = report_of(path, slots, around)
    is_loaded = all(problem.kind != "not loaded" for problem in report.problems)
    reason = why_not_own(chosen, solution) if is_loaded else ""
    trial = _trial(chosen, path) if is_loaded and not reason else None
    if trial is not None:
        telling.get()(f"runs of the task: {'' if trial.is_solved else 'not '}solved")
    kinds = {problem.kind for problem in report.problems}
    found = () if trial is None else _findings(trial, solution, is_known=bool(kinds - _NO_CAUSE))
    findings = around.with_allowed(one for one in found if one.kind not in kinds)
    known = {field.name: getattr(report, field.name) for field in fields(report)}
    not_own = [Problem(kind=REFUSED, sentence=reason)] if reason else []
    known["problems"] = (*_once(report), *not_own, *findings)
    known["remarks"] = (*_remarks(report, chosen, solution), *report.remarks)
    known["tables"] = (*(() if trial is None else trial.tables), *report.tables)
    return TaskReport(**known, task=chosen, trial=trial, findings=findings)


def _surroundings(task: Task) -> Surroundings:
    simulation = task.simulation()
    on = {slot for slot in simulation.SLOTS if simulation._is_on(slot)}
    return Surroundings(
        setting=Setting.of(task.scenario),
        slots=task.slots,
        on=frozenset(on.union(task.slots)),
        given={MODULE: module_source(task)},
        dt=simulation.model.dt,
        masked=task.masked,
    )


def _trial(task: Task, path: str | PathLike[str]) -> TaskTrial:
    with redirect_stdout(StdoutCapture()), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the usual checks report them
        return try_solution(task, path, time_limit=TIME_LIMIT, progress=False)


def _findings(trial: TaskTrial, solution: Solution, *, is_known: bool) -> Iterator[Problem]:
    """Yield the findings of the runs if points are missing.

    A cause that the checks of the files have found explains the worst run.
    """
    if trial.is_solved:
        return
    for run, text in list(trial.failed.items())[:1]:
        yield Problem(
            kind="run fails",
            sentence=f"{len(trial.failed)} of {trial.runs} runs end with an error: {text}",
            situation=f"run {run} of the task",
        )
    if is_known and trial.rule is None:
        return
    with redirect_stdout(StdoutCapture()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        seen = SeenRun.of(trial, solution)
        for slot, findings in _LOOKS.items():
            if seen is not None and slot in trial.task.slots:
                yield from findings(seen)


def _remarks(report: FolderReport, task: Task, solution: Solution) -> Iterator[str]:
    """Yield the files that the task does not use, and the slots that are off."""
    unused = [f"{slot}.py" for slot, verdict in report.verdicts.items() if verdict == "not used"]
    if unused:
        asked = ", ".join(f"{slot}.py" for slot in task.slots)
        is_are = "is" if len(unused) == 1 else "are"
        yield f"{', '.join(unused)} {is_are} not used: the task {task.name} uses {asked}"
    for slot in task.slots:
        if slot in solution.files and isinstance(report.checks.get(slot), str):
            yield f"{slot}.py is switched off: set ENABLED = True in it"


def _once(report: FolderReport) -> Iterator[Problem]:
    checks = [check for check in report.checks.values() if isinstance(check, CheckReport)]
    of_files = [problem for check in checks for problem in check.problems]
    known = set()
    for problem, of_file in zip(report.problems, of_files, strict=True):
        if (found := (of_file.kind, of_file.sentence)) not in known:
            known.add(found)
            yield problem
