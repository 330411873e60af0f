"""The picture of a run of a test, and its path."""

from __future__ import annotations

from robsim.base.checks import Floats
from robsim.teach.assignments.assignment import TaskTest
from robsim.trace import Trace


def picture_of(test: TaskTest, trace: Trace, reference: Trace | None) -> tuple[bytes, str]:
    """Return a run of a submission, beside that of the reference, as PNG, and what it shows."""
    from robsim.plotting.runs.beside import as_png, draw_run  # matplotlib takes its time

    task = test.task
    figure, caption = draw_run(
        trace, reference, slots=task.slots, goals=task.goals, unscored=task.unscored
    )
    return as_png(figure), caption


def path_of(trace: Trace) -> list[list[float]]:
    """Return the path of a run, (N, 2), to a tenth of a pixel of the work area."""
    path: Floats = trace.pose_true[:, :2]
    rounded: list[list[float]] = path.round(1).tolist()
    return rounded
