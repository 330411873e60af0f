"""What the arguments of all figures are checked against: one sentence for each kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from robsim._core import Blob, ColorClass, Estimate, Frame, Measurement
from robsim.base.checks import Floats, as_float_array
from robsim.base.spelling import with_article
from robsim.base.text import quoted
from robsim.campaigns import CampaignResult
from robsim.estimation.evaluation.consistency import ConsistencyReport
from robsim.estimation.evaluation.errors import ErrorReport
from robsim.estimation.identification.batch import BatchEstimate
from robsim.simulation import Simulation
from robsim.simulation.runner import Runner
from robsim.trace import Trace
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
    CampaignResult: "what robsim.campaign(...) returns",
    Axes: "axes of matplotlib, such as figure.add_subplot()",
}


#: The panels of a figure of several.
Panels = Sequence[Axes] | NDArray[np.object_]


def check_optional(name: str, value: Any, kind: type) -> None:
    if value is not None:
        check_kind(name, value, kind)


def check_blobs(blobs: Any) -> None:
    """Raise a TypeError unless it is None, or a dict of the blobs of each colour."""
    if blobs is None:
        return
    for found in blobs.values() if isinstance(blobs, Mapping) else [None]:
        if not isinstance(found, Sequence) or not all(isinstance(one, Blob) for one in found):
            raise TypeError(
                "blobs must be a dict of the list of Blob of each colour, as from "
                f"robsim.find_blobs(frame, colors), got {quoted(blobs)}"
            )


def check_kind(name: str, value: Any, kind: type) -> None:
    """Raise a TypeError unless a value is of a kind; it says where to get one from.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
        What was given.
    kind : type
        One of those that stand above.
    """
    if not isinstance(value, kind):
        raise TypeError(
            f"{name} must be {_with_article(kind)}, got {_with_article(type(value))}: "
            f"give {_SOURCES[kind]}"
        )


def _with_article(kind: type) -> str:
    return "None" if kind is type(None) else with_article(kind.__name__)


def check_steps(trace: Any) -> None:
    """Raise a TypeError unless it is a trace, a ValueError if nothing has run yet."""
    check_kind("trace", trace, Trace)
    if not len(trace):
        raise ValueError("the trace has no steps yet: run the simulation, sim.run(100)")


def check_axes(axes: Any, shape: tuple[int, ...]) -> NDArray[np.object_]:
    """Return `axes` as an array of Axes; raise a ValueError unless it has the shape."""
    found = np.asarray(axes, dtype=object)
    size = " x ".join(map(str, shape))
    if found.shape != shape:
        raise ValueError(f"axes: expected an array of {size} axes, got the shape {found.shape}")
    for one in found.flat:
        check_kind("axes", one, Axes)
    return found


def check_panels(axes: Any, rows: list[list[str]]) -> None:
    """Raise a TypeError or ValueError unless it is a dict of Axes that has the panels."""
    if not isinstance(axes, Mapping):
        raise TypeError(
            f"axes must be a dict of panels to Axes, as of figure.subplot_mosaic({rows!r}), got "
            f"{quoted(axes)}"
        )
    if missing := sorted({name for row in rows for name in row} - axes.keys()):
        raise ValueError(f"axes must have the panels {', '.join(missing)}, got {', '.join(axes)}")
    for one in axes.values():
        check_kind("axes", one, Axes)


def check_positions(name: str, values: Any) -> Floats:
    """Return `values` as an array (N, 2); raise a ValueError if they have another shape."""
    positions = as_float_array(name, values)
    if positions.ndim != 2 or positions.shape[1] != 2:
        raise ValueError(f"{name}: expected the shape (N, 2), got {positions.shape}")
    return positions
