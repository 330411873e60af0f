"""The results of a run as files: figures, trace, batch estimate; called by run, track and demo."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import robsim
from robsim.base.files import write_whole
from robsim.base.report import Report
from robsim.base.text import one_line
from robsim.estimation.identification.batch import BatchEstimate, batch_estimate
from robsim.simulation import Experiment, Simulation
from robsim.trace import Trace

#: The file of the run itself.
TRACE = "trace.npz"
_FIGURES = ("camera.jpg", "traces.png", "parameters.png", "batch.png")


@dataclass(frozen=True, kw_only=True)
class Results:
    """The results of a run, with further reports by name, and the written files."""

    report: BatchEstimate | None  # if parameters were estimated
    tracking: Report | None  # if the robot was tracked
    files: tuple[Path, ...]
    more: Mapping[str, Report] = field(default_factory=dict)

    @property
    def reports(self) -> dict[str, Report]:
        reports = {"batch_estimate": self.report, "tracking": self.tracking, **self.more}
        return {name: report for name, report in reports.items() if report is not None}

    def to_dict(self) -> dict[str, Any]:
        """Return the numbers of each report by its name."""
        return {name: report.to_dict() for name, report in self.reports.items()}

    def __str__(self) -> str:
        return "\n\n".join(map(str, self.reports.values()))


def check_folder(out: Path) -> None:
    """Raise the OSError of an unwritable folder for results, before the run."""
    if out.exists() and not out.is_dir():
        raise NotADirectoryError(f"{out} is a file, not a folder: use another name")
    there = next(folder for folder in (out.absolute(), *out.absolute().parents) if folder.exists())
    if not there.is_dir():
        raise NotADirectoryError(f"{out}: {there} is a file, not a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise PermissionError(f"{out}: the folder {there} is not writable")


def check_file(file: Path) -> None:
    """Raise the OSError of an unwritable file, before the long work."""
    if file.is_dir():
        raise IsADirectoryError(f"{file} is a folder, not a file: name a file in it")
    check_folder(file.absolute().parent)
    if file.exists() and not os.access(file, os.W_OK):
        raise PermissionError(f"{file} is not writable")


def check_figure_name(file: Path) -> None:
    """Raise ValueError unless the suffix of a file names a format of figures."""
    from matplotlib.backend_bases import FigureCanvasBase

    if file.suffix[1:].lower() not in FigureCanvasBase.get_supported_filetypes():
        raise ValueError(
            f"{one_line(file)}: the name of a figure must end in .png, .pdf, .svg or similar"
        )


def save_figure(file: Path, figure: Any) -> None:
    """Write a figure to a file in the format that its suffix names."""
    check_figure_name(file)
    # Noise does not compress: a camera's image is a fifth as large as JPEG.
    quality = {"pil_kwargs": {"quality": 90}} if file.suffix == ".jpg" else {}
    file.parent.mkdir(parents=True, exist_ok=True)
    content = io.BytesIO()
    figure.savefig(content, format=file.suffix[1:].lower(), **quality)
    write_whole(file, content.getvalue())


def write_results(
    out: Path,
    simulation: Simulation | Experiment,
    *,
    method: str = "least_squares",
    more: Mapping[str, Report] | None = None,
    unit: str = "px",
    scale: float | None = None,
) -> Results:
    """Write the figures and the trace of a run.

    The files are camera.jpg, traces.png, trace.npz; with an estimator, also parameters.png and
    batch.png. The batch estimate uses the `method`, and `more` are other reports of the run.
    `scale` is the length of a px of the work area (mm), by default from the run's calibration.
    """
    trace = simulation.trace.in_unit(unit, mm_per_px=scale)
    is_tracked = trace.is_tracked
    out.mkdir(parents=True, exist_ok=True)
    trace.save(out / TRACE)
    figures: dict[str, Any] = {
        "camera.jpg": _camera_figure(simulation),
        "traces.png": robsim.plotting.plot_traces(trace),
    }
    report = _report(trace, method)
    if np.isfinite(trace.parameters).any() and np.isfinite(trace.pose_true).any():
        figures["parameters.png"] = robsim.plotting.plot_parameters(trace)
    if report is not None:
        figures["batch.png"] = robsim.plotting.plot_batch(report).get_figure()
    for name in _FIGURES:
        if name in figures:
            save_figure(out / name, figures[name])
        else:  # remove the figure of an earlier run
            (out / name).unlink(missing_ok=True)
    files = tuple(out / name for name in (*figures, TRACE))
    tracking = trace.tracking() if is_tracked else None
    return Results(report=report, tracking=tracking, files=files, more=more or {})


def _camera_figure(simulation: Simulation | Experiment) -> Any:
    step = simulation.last_step
    is_tracked = simulation.trace.is_tracked
    axes = robsim.plotting.plot_frame(
        simulation.frame,
        blobs=step.blobs if is_tracked else None,
        measurement=step.measurement,
        outline=simulation.robot.to_robot_frame(simulation.robot.outline),
        trace=simulation.trace,
    )
    return axes.get_figure()


def _report(trace: Trace, method: str) -> BatchEstimate | None:
    """Return the batch estimate, if the run had an estimator and the record is long enough."""
    if not np.isfinite(trace.parameters).any():
        return None
    try:
        return batch_estimate(trace, method=method)
    except ValueError:
        return None
