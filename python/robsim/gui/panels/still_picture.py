"""The picture of a panel, drawn by matplotlib, which loads slowly."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from robsim._core import Estimate, Measurement
from robsim.base.checks import Floats
from robsim.base.text import one_line
from robsim.estimation.evaluation.errors import usual_limits
from robsim.gui._link import small_png
from robsim.gui._worker import drawing
from robsim.gui.panels.analysis.statistics import longest_valid
from robsim.gui.panels.record import Record
from robsim.gui.panels.run.camera import Shot
from robsim.plotting import draw_overlay
from robsim.plotting import style as style
from robsim.plotting.charts.errors import draw_histogram
from robsim.plotting.charts.traces import draw_all_poses
from robsim.plotting.images.frame import draw_goals
from robsim.trace import Trace

_SIZE = (1000, 500)  # px
_DPI = 100
_MOST_STEPS = 3000  # of the traces; more would take long
_UNITS = ("px", "px", "deg")


def still_picture(
    record: Record, shot: Shot | None, state: str, goals: Floats | None = None
) -> bytes:
    """Return a picture of the newest step, the traces and the histograms (PNG)."""
    with drawing:
        figure = _figure(record, shot, state, goals)
        canvas = io.BytesIO()
        figure.savefig(canvas, format="png", dpi=_DPI)
    return small_png(Image.open(canvas).convert("RGB"))


@style.applied
def _figure(record: Record, shot: Shot | None, state: str, goals: Floats | None) -> Figure:
    trace = record.trace[-_MOST_STEPS:]
    figure = Figure(figsize=(_SIZE[0] / _DPI, _SIZE[1] / _DPI), dpi=_DPI)
    parts: Any = figure.subfigures(1, 2, width_ratios=(1, 1.16))
    left, right = parts
    _draw_camera(left.add_subplot(), record, shot, goals)
    title = one_line(_title(record, shot, state))
    left.suptitle(title, x=0.01, ha="left", size=10, parse_math=False)
    if len(trace):
        _draw_record(right, trace)
    else:
        right.text(0.5, 0.5, "nothing has run yet", ha="center", color=style.GUIDE, size=10)
    return figure


def _title(record: Record, shot: Shot | None, state: str) -> str:
    when = "" if shot is None else f"   k {shot.k}   t {shot.t:.1f} s"
    return f"{record.title}   {state}{when}"


def _draw_camera(axes: Axes, record: Record, shot: Shot | None, goals: Floats | None) -> None:
    axes.set(xticks=(), yticks=())
    axes.grid(False)
    axes.spines[["top", "right"]].set_visible(True)
    if shot is None or shot.frame is None:
        axes.set(xlim=(0, record.area[0]), ylim=(record.area[1], 0), aspect="equal")
        axes.text(0.5, 0.5, "no picture", transform=axes.transAxes, ha="center", color=style.GUIDE)
        return
    axes.imshow(_camera_picture(record, shot), interpolation="antialiased")
    axes.set_anchor("N")
    if goals is not None:
        axes.set_autoscale_on(False)
        draw_goals(axes, goals, shot.frame.plane_map.to_pixel)


def _camera_picture(record: Record, shot: Shot) -> Any:
    assert shot.frame is not None
    is_tracked = "pose_measured" in record.columns() and shot.k < record.n_steps
    estimate = None
    if shot.estimate and shot.estimate["covariance"]:
        covariance = np.reshape(shot.estimate["covariance"], (3, 3))
        estimate = Estimate(shot.estimate["pose"], covariance)
    return draw_overlay(
        shot.frame,
        measurement=None if shot.measured is None else Measurement(shot.measured),
        blobs=record.find_blobs(shot.frame) if is_tracked else None,
        outline=record.outline if len(record.outline) else None,
        estimate=estimate,
    )


def _draw_record(figure: Any, trace: Trace) -> None:
    part = trace[longest_valid(trace)]
    has_errors = trace.is_tracked and len(part) > 0
    ratios = (2.3, 1) if has_errors else (1,)
    grid = figure.subplots(3, len(ratios), sharex="col", width_ratios=ratios, squeeze=False)
    panels = grid[:, 0].tolist()
    draw_all_poses(panels, trace, False)
    style.show_steps(panels[-1], trace)
    _add_legend(figure, panels[0])
    if has_errors:
        _draw_histograms(grid[:, 1].tolist(), part)
    figure.align_ylabels(panels)


def _add_legend(figure: Any, panel: Axes) -> None:
    handles, labels = panel.get_legend_handles_labels()
    short = [label.partition(":")[0] for label in labels]  # "not seen: last pose held"
    look: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0.08, 1), "borderaxespad": 0.1}
    legend = figure.legend(handles, short, ncols=4, columnspacing=1.2, handlelength=1.2, **look)
    style.enlarge_marks(legend)
    legend.set_in_layout(False)
    figure.suptitle(" ", size=10)  # its room


def _draw_histograms(panels: Sequence[Axes], trace: Trace) -> None:
    errors = trace.error
    errors[:, 2] = np.rad2deg(errors[:, 2])
    for panel, values, unit in zip(panels, errors.T, _UNITS, strict=True):
        panel.set_ylim(usual_limits(values))
        draw_histogram(panel, values, unit)
        panel.tick_params(labelleft=True)
        panel.set_title("", loc="left")
        text = f"{values.mean():.3f} ± {values.std():.3f} {unit}"
        panel.set_title(text, loc="left", fontsize=8, pad=3).set_in_layout(False)
    panels[-1].set_xlabel(f"error, longest record: {style.n_steps(len(trace))}")
