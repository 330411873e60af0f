"""The colours, labels and matplotlib settings that all figures share."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import is_color_like
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import offset_copy
from numpy.typing import NDArray

from robsim._core import Blob, ColorClass, Estimate, Frame, Measurement, wrap_angle
from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted
from robsim.campaigns import CampaignResult
from robsim.estimation.evaluation.consistency import ConsistencyReport
from robsim.estimation.evaluation.errors import ErrorReport
from robsim.estimation.identification.batch import BatchEstimate
from robsim.simulation import Simulation
from robsim.simulation.runner import Runner
from robsim.trace import Trace
from robsim.trace.units import parameter_units
from robsim.vision.robots.definition import RobotDefinition

# Where one gets a value of that kind from.
_SOURCES: dict[type, str] = {
    Trace: "sim.trace",
    Simulation: "robsim.Simulation(...), after sim.run(100)",
    Runner: "the Simulation or Experiment that has run",
    Measurement: "step.measurement, or robsim.locate(blobs, robot.marker_layout())",
    Estimate: "step.estimate, or robsim.Estimate(pose, covariance)",
    Frame: "sim.frame, or robsim.Frame(image)",
    RobotDefinition: "sim.robot, or robsim.load_robot(name)",
    ColorClass: "one of robsim.load_colors()",
    BatchEstimate: "robsim.batch_estimate(trace)",
    ErrorReport: "robsim.pose_errors(trace), or robsim.estimation.estimation_errors(...)",
    ConsistencyReport: "robsim.pose_consistency(traces), or nees_consistency or nis_consistency "
    "in robsim.estimation",
    CampaignResult: "the result of robsim.campaign(...)",
    Iterable: "frames, for example of a recording",
    Axes: "axes of matplotlib, such as figure.add_subplot()",
}
#: The panels of a figure of several.
Panels = Sequence[Axes] | NDArray[np.object_]


def check_optional(name: str, value: Any, kind: type) -> None:
    if value is not None:
        check_source(name, value, kind)


def check_blobs(blobs: Any) -> None:
    """Raise a TypeError unless it is None, or a dict of the blobs of each colour."""
    if blobs is None:
        return
    for found in blobs.values() if isinstance(blobs, Mapping) else [None]:
        if not isinstance(found, Sequence) or not all(isinstance(one, Blob) for one in found):
            raise TypeError(
                "blobs must be a dict of colour to list of Blob, as from "
                f"robsim.find_blobs(frame, colors), got {quoted(blobs)}"
            )


def check_source(name: str, value: Any, kind: type) -> None:
    """Raise a TypeError, which gives a source of such values, unless a value is of a kind above."""
    if not isinstance(value, kind):
        raise TypeError(
            f"{name} must be of type {kind.__name__}, got {type(value).__name__}: "
            f"give {_SOURCES[kind]}"
        )


def check_steps(trace: Any) -> None:
    """Raise a TypeError unless it is a trace, a ValueError if nothing has run yet."""
    check_source("trace", trace, Trace)
    if not len(trace):
        raise ValueError("the trace has no steps yet: run the simulation, sim.run(100)")


def check_axes(axes: Any, shape: tuple[int, ...]) -> NDArray[np.object_]:
    """Return `axes` as an array of Axes; raise a ValueError unless it has the shape."""
    found = np.asarray(axes, dtype=object)
    size = " x ".join(map(str, shape))
    if found.shape != shape:
        raise ValueError(f"axes must be an array of {size} axes, got the shape {found.shape}")
    for one in found.flat:
        check_source("axes", one, Axes)
    return found


def check_panels(axes: Any, rows: list[list[str]]) -> None:
    """Raise a TypeError or ValueError unless it is a dict of Axes that has the panels."""
    if not isinstance(axes, Mapping):
        raise TypeError(
            f"axes must be a dict of panels to Axes, as from figure.subplot_mosaic({rows!r}), got "
            f"{quoted(axes)}"
        )
    if missing := sorted({name for row in rows for name in row} - axes.keys()):
        raise ValueError(f"axes must have the panels {', '.join(missing)}, got {', '.join(axes)}")
    for one in axes.values():
        check_source("axes", one, Axes)


def check_positions(name: str, values: Any) -> Floats:
    """Return `values` as an array (N, 2); raise a ValueError if they have another shape."""
    positions = as_float_array(name, values)
    if positions.ndim != 2 or positions.shape[1] != 2:
        raise ValueError(f"{name} must have the shape (N, 2), got {positions.shape}")
    return positions


TRUE = "#d100c9"  # the true pose and the true parameters
MEASURED = "#17a02b"  # the camera's measurements
HELD = "#000000"  # not seen: the last valid pose, repeated
ESTIMATED = "#1f5fe0"  # the state estimate, the online parameter estimate
BATCH = "#e07b00"  # the batch parameter estimate
FITTED = "#333333"  # the bell curve
REPORTED = "#d5e1f8"  # 95 % should lie in it: reported standard deviations, the band of a test
BOUND = "#b3541e"  # the Cramér-Rao bound
WRONG = "#c62828"  # not seen; above the band
SEGMENT = "#eef1f5"  # background of the steps that the histograms are made from
GOAL = "#ff9800"  # where the robot is to go
GUIDE = "#9aa0a6"  # guide lines and notes, no data
#: Above that many steps lines would be solid ink.
SOME_STEPS, MANY_STEPS = 300, 3000
# Room for an entry of a legend (inches).
_LEGEND_COLUMN = 1.05
#: The background of a note in a figure.
BOX: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 2}
_STYLE: dict[Any, Any] = {
    "figure.dpi": 110,
    "text.usetex": False,  # it would execute TeX in a name
    "figure.constrained_layout.use": True,
    "figure.facecolor": "white",
    "figure.titlesize": 10.5,
    "font.size": 8.0,
    "text.color": "#202020",
    "axes.facecolor": "white",
    "axes.edgecolor": "#606060",
    "axes.labelcolor": "#202020",
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.5,
    "axes.linewidth": 0.7,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "grid.linewidth": 0.6,
    "xtick.color": "#404040",
    "ytick.color": "#404040",
    "lines.markeredgewidth": 0.0,
    "legend.fontsize": 9.0,
    "legend.frameon": False,
}
#: Decorates a function that draws: the user's own matplotlib settings do not change.
applied = matplotlib.rc_context(_STYLE)


class NotebookFigure(Figure):
    """A figure that a notebook displays without pyplot."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", bbox_inches="tight")
        return buffer.getvalue()


class NotebookAxes(Axes):
    """The only axes of such a figure: a notebook displays the figure for them."""

    def _repr_png_(self) -> Any:
        figure: Any = self.figure
        return figure._repr_png_()


def panel(ax: Axes | None, size: tuple[float, float]) -> Axes:
    """Return the axes given to a figure of one panel, or new axes in a figure (inches)."""
    if ax is None:
        return NotebookFigure(figsize=size).add_subplot(axes_class=NotebookAxes)
    check_source("ax", ax, Axes)
    return ax


def fit_figure(axes: Axes) -> None:
    """Give a figure of one image the height of the image and its labels."""
    width, height = np.ptp((axes.get_xlim(), axes.get_ylim()), axis=1)
    figure: Any = axes.figure
    figure.set_figheight(1.6 + 6.1 * float(np.clip(height / width, 0.3, 1.5)))


def position_labels(unit: str) -> tuple[str, str]:
    return f"x ({unit})", f"y ({unit})"


def parameter_labels(unit: str) -> list[str]:
    """Return the names of the 15 parameters with their units."""
    units = parameter_units(unit)
    return [f"{name} ({of})" if of else name for name, of in units.items()]


def show_steps(axes: Axes, trace: Trace) -> None:
    """Make the steps of the trace the x axis."""
    first = int(trace.k[0]) if len(trace) else 0
    axes.set_xlim(first - 0.5, first + max(len(trace), 1) - 0.5)
    axes.xaxis.set_major_locator(MaxNLocator("auto", integer=True, min_n_ticks=1))
    axes.set_xlabel(f"step k (of {trace.info.dt:g} s)")


def show_time(axes: Axes, trace: Trace) -> None:
    """Add the time above an axis of steps, at the mean interval of the frames."""
    k, t = trace.k[[0, -1]], trace.t[[0, -1]]
    if t[1] > t[0]:
        dt = (t[1] - t[0]) / (k[1] - k[0])
        maps: Any = (lambda x: t[0] + dt * (x - k[0]), lambda s: k[0] + (s - t[0]) / dt)
        axes.secondary_xaxis("top", functions=maps).set_xlabel("time (s)")


def dot_size(steps: int) -> float:
    """Return the marker size of a dot (points) that does not touch its neighbours."""
    return float(np.clip(3.0 * math.sqrt(800 / max(steps, 1)), 2.5, 6.5))


def pose_dot_size(steps: int) -> float:
    """Return the marker size of a measured pose (points): wider than the line of the truth."""
    return 7.0 if steps <= MANY_STEPS else 4.0


def true_width(steps: int) -> float:
    """Return the width of the line of the truth (points), which lies on the measured dots."""
    return 1.8 if steps <= MANY_STEPS else 1.0


def line_marker(steps: int) -> str:
    """Return the marker of a line: a dot if there is a single step, which is no line yet."""
    return "." if steps == 1 else ""


def n_steps(count: int) -> str:
    return "1 step" if count == 1 else f"{count} steps"


def draw_path(axes: Axes, true: Floats, measured: Floats) -> None:
    """Draw the measured positions (N, 2) as dots, and the true path on them as a line."""
    size = pose_dot_size(len(true))
    if np.isfinite(measured).any():
        axes.plot(*measured.T, ".", color=MEASURED, markersize=size, label="measured path")
    if np.isfinite(true).any():
        axes.plot(*true.T, color=TRUE, linewidth=true_width(len(true)), label="true path")


def degrees(heading: Floats) -> Floats:
    """Return headings in degrees, -180..180."""
    turned: Floats = np.rad2deg(wrap_angle(heading))
    return turned


def shown_unit(unit: str) -> tuple[float, str]:
    """Return the factor to and the name of the displayed unit: degrees for rad."""
    return (math.degrees(1.0), "deg") if unit == "rad" else (1.0, unit)


def drawn_color(name: str) -> str:
    return name if is_color_like(name) else GUIDE


def haloed(width: float) -> list[Any]:
    """Return the effect that keeps a line of this width visible on any background."""
    return [withStroke(linewidth=width + 1.6, foreground="white")]


def legend_below(axes: Axes, *, ncols: int, **look: Any) -> None:
    """Put the legend, if any, below the x label, in `ncols` columns or as fit, at least 2."""
    if axes.get_legend_handles_labels()[0]:
        figure: Any = axes.figure.figure
        width = axes.get_position().width * figure.get_figwidth()
        below = offset_copy(axes.transAxes, figure, y=-36, units="points")
        look |= {"bbox_to_anchor": (0.5, 0), "bbox_transform": below, "borderaxespad": 0}
        look["ncols"] = min(ncols, max(2, int(width / _LEGEND_COLUMN)))
        enlarge_marks(axes.legend(loc="upper center", **look))


def enlarge_marks(legend: Legend) -> None:
    """Make the marks of a legend visible, even for small dots and thin lines."""
    for handle in legend.legend_handles:
        if isinstance(handle, Line2D):
            handle.set_alpha(1.0)
            handle.set_markersize(max(handle.get_markersize(), 8.0))
            if handle.get_linewidth():
                handle.set_linewidth(max(handle.get_linewidth(), 1.5))


def rasterize_long_lines(panels: Iterable[Axes]) -> None:
    """Rasterise lines of many points within a PDF or SVG file, which keeps the file small."""
    for axes in panels:
        for line in axes.get_lines():
            line.set_rasterized(np.size(line.get_xdata()) > 5000)
