"""`check_folder`: the checks of callback files, alone or for a task."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from os import PathLike
from typing import TYPE_CHECKING

from robsim.base.text import quoted
from robsim.teach.doctor._run_checks import telling
from robsim.teach.doctor.callbacks.folder import FolderReport, Surroundings, report_of

if TYPE_CHECKING:
    from robsim.teach.tasks.definition import Task


def check_folder(
    path: str | PathLike[str],
    *,
    slots: str | Iterable[str] | None = None,
    task: str | Task | None = None,
    progress: Callable[[str], object] | None = None,
) -> FolderReport:
    """Check all callbacks of a folder, or one callback file, and report their problems.

    Each callback is checked alone, by the check for its slot: `check_controller`,
    `check_measurement`, `check_estimator`, `check_parameter_estimator`, `check_model`,
    `check_motion`, `check_background`. With a task, `robsim.teach.try_solution` also runs the
    callbacks on the task, and the worst run is examined.

    Parameters
    ----------
    path : path
        A folder of callbacks, as ``robsim new`` writes it, one of its files, or a notebook.
    slots : str or iterable of str, optional
        The slots to check. Default: all that have a file.
    task : str or Task, optional
        The task that the folder is to solve, or its name. The check then uses the task's world,
        its inputs and its slots.
    progress : callable, optional
        Called with a line, such as ``print``, when a check is done.

    Returns
    -------
    FolderReport
        True if all checks pass. A file that fails to load is a problem, too. With a task, a
        `TaskReport`, which is True if the callbacks solve the task and all checks pass.

    Raises
    ------
    FileNotFoundError
        If the file or folder is missing.
    TypeError, ValueError
        If there are no callback files, a slot or a task is unknown, or `progress` is not callable.

    Examples
    --------
    >>> from pathlib import Path
    >>> Path("mine").mkdir()
    >>> size = Path("mine/control.py").write_text("def control(step): return 0.5")
    >>> print(robsim.teach.check_folder("mine").problems[0].sentence)
    control.py: it returns 0.5, not (u1, u2), the voltages of the left and the right motor
    """
    if progress is not None and not callable(progress):
        raise TypeError(
            f"progress must be a function of a line of text, or None, got {quoted(progress)}"
        )
    token = telling.set(telling.get() if progress is None else progress)
    try:
        if task is None:
            return report_of(path, slots, Surroundings())
        from robsim.teach.doctor.task_checks.checking import check_for_task  # tasks take their time

        return check_for_task(path, slots, task)
    finally:
        telling.reset(token)
