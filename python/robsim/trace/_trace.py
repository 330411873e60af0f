"""The recorded run: named columns, slices, files."""

from __future__ import annotations

import csv
import io
import json
import math
import reprlib
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._base.checks import Floats
from robsim._base.files import write_whole
from robsim._core import wrap_angle

if TYPE_CHECKING:
    import pandas
Bools = NDArray[np.bool_]

FORMAT = "robsim trace 1"

#: The 15 parameters of the robot model, row by row of theta (3, 5).
PARAMETER_NAMES = tuple(f"{p}{axis}" for axis in "XYP" for p in ("a1", "a2", "b1", "b2", "d1"))

#: Farther from the truth than this, a measured pose is a false one (px, rad).
FALSE_POSE_LIMITS = (10.0, np.deg2rad(20.0))

_POSE_UNITS = ("px", "px", "rad")


def _poses(suffix: str) -> dict[str, str]:
    return {
        f"{q}_{suffix}": unit for q, unit in zip(("x", "y", "heading"), _POSE_UNITS, strict=True)
    }


# What each group of columns consists of: name -> unit, in the order of the numbers of a row.
_FIXED_GROUPS: dict[str, dict[str, str]] = {
    "t": {"t": "s"},
    "pose_true": _poses("true"),
    "u": {"u1": "V", "u2": "V"},
    "bounced": {"bounced": ""},
    "pose_measured": _poses("measured"),
    "pose_held": _poses("held"),
    "pose_estimated": _poses("estimated"),
    "covariance": {
        f"cov_{a}_{b}": f"{ua} {ub}"
        for a, ua in zip(("x", "y", "heading"), _POSE_UNITS, strict=True)
        for b, ub in zip(("x", "y", "heading"), _POSE_UNITS, strict=True)
    },
    "parameters": dict.fromkeys(PARAMETER_NAMES, ""),
    "standard_errors_unscaled": {f"standard_error_unscaled_{name}": "" for name in PARAMETER_NAMES},
    "view": {"x_view": "px", "y_view": "px"},
}
_SIMULATED = ("pose_true", "u", "bounced")
_RECORDED = ("pose_measured",)
_SHAPES = {
    "covariance": (3, 3),
    "parameters": (3, 5),
    "standard_errors_unscaled": (3, 5),
    "state": (),
}


def _fields(group: str, width: int) -> dict[str, str]:
    """Return name -> unit of the single columns of a group."""
    if group.startswith("blobs_") and group != "blobs_":
        color = group.removeprefix("blobs_")
        return {f"{color}{i}_{q}": "px" for i in (1, 2) for q in "xy"}
    if group == "state":
        return {f"state{i}": "" for i in range(width)}
    if group not in _FIXED_GROUPS:
        raise ValueError(f"there is no group of columns {group!r}")
    return _FIXED_GROUPS[group]


def _numbers(name: str, values: Any) -> Floats:
    """Return real numbers as float64."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} must be an array of numbers, got {values!r}") from None
    if array.dtype.kind not in "biuf":
        raise ValueError(f"{name} must be numbers, got {array.dtype} of shape {array.shape}")
    return array.astype(np.float64, copy=False)


def _rows_of(name: str, values: Any) -> Floats:
    """Return a read-only array (N, width) of a group's numbers, which may come as (N, 3, 5)."""
    array = _numbers(name, values)
    if array.ndim < 1 or (array.ndim > 2 and array.shape[1:] != _SHAPES.get(name, (2, 2))):
        raise ValueError(f"{name} must have a row for each step, got shape {array.shape}")
    rows = array.reshape(len(array), math.prod(array.shape[1:])).view()
    rows.setflags(write=False)
    if rows.shape[1] != len(_fields(name, rows.shape[1])):
        raise ValueError(f"{name} must not have {rows.shape[1]} columns, got shape {array.shape}")
    return rows


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """What a trace knows of the run as a whole.

    Parameters
    ----------
    dt : float
        Sample time (s).
    theta_true : array_like (3, 5)
        True parameters of the robot model, rows X, Y, P (heading), columns a1, a2, b1, b2, d1.
        NaN = not known, for recorded frames.
    seed : dict
        ``entropy`` and ``spawn_key`` of the run's `numpy.random.SeedSequence`.
    identify_from : str
        The data that the online estimate is made from: truth, measurement or estimate.
    area : tuple of int
        Width and height of the work area (px).
    boundary : str
        ``"bounce"`` or ``"unlimited"``, or ``"recorded"``: the frames were not simulated.
    robot : str
        Name of the robot definition.
    """

    dt: float
    theta_true: ArrayLike
    seed: Mapping[str, Any] = field(default_factory=dict)
    identify_from: str = "truth"
    area: tuple[int, int] = (1200, 1200)
    boundary: str = "bounce"
    robot: str = ""

    def __post_init__(self) -> None:
        is_number = isinstance(self.dt, (int, float)) and not isinstance(self.dt, bool)
        if not is_number or not 0 < self.dt < 1e9:
            raise ValueError(f"dt must be a positive number (s), got {self.dt!r}")
        theta = _numbers("theta_true", self.theta_true)
        is_unknown = self.boundary == "recorded" and bool(np.isnan(theta).all())
        if theta.shape != (3, 5) or not (np.isfinite(theta).all() or is_unknown):
            raise ValueError(f"theta_true must be 3 x 5 finite numbers, got {self.theta_true!r}")
        object.__setattr__(self, "theta_true", tuple(map(tuple, theta.tolist())))
        if not isinstance(self.seed, Mapping):
            raise ValueError(f"seed must have entropy and spawn_key, got {self.seed!r}")
        area = self.area if isinstance(self.area, tuple) else ()
        if len(area) != 2 or not all(type(size) is int and size > 0 for size in area):
            raise ValueError(f"area must be (width, height), two ints, got {self.area!r}")
        for name in ("identify_from", "boundary", "robot"):
            if not isinstance(getattr(self, name), str):
                raise ValueError(f"{name} must be text, got {getattr(self, name)!r}")


@dataclass(frozen=True, kw_only=True)
class TrackingStatistics:
    """How well the measurement followed the truth.

    Attributes
    ----------
    steps : int
        Steps of the record.
    seen : int
        Steps in which the robot was found.
    false_poses : int
        Valid steps more than 10 px or 20 degrees off.
    rmse_xy : float
        sqrt(mean(dx^2 + dy^2)) over the steps seen (work-area px); NaN if the truth is not known.
    rmse_heading_deg : float
        Root mean square of the heading error over the steps seen (degrees).
    """

    steps: int
    seen: int
    false_poses: int
    rmse_xy: float
    rmse_heading_deg: float

    def __str__(self) -> str:
        if not self.seen:
            return f"tracking: {self.steps} steps, never seen"
        share = f"{100 * self.seen / self.steps:.1f} %"
        if math.isnan(self.rmse_xy):
            return f"tracking: {self.steps} steps, {self.seen} seen ({share})"
        return (
            f"tracking: {self.steps} steps, {self.seen} seen ({share}), {self.false_poses} false, "
            f"rmse {self.rmse_xy:.3f} px and {self.rmse_heading_deg:.3f} deg"
        )


def check_trace(trace: Any) -> None:
    """Raise a TypeError unless it is a trace."""
    if not isinstance(trace, Trace):
        raise TypeError(f"trace must be a Trace, got {reprlib.repr(trace)}")


def longest_run(mask: Bools) -> slice:
    """Return the longest unbroken run of True as a slice; the first one of several.

    Parameters
    ----------
    mask : array (N,) of bool
        What holds at each step.
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False])).astype(np.int8)))
    starts, stops = edges[::2], edges[1::2]
    if not len(starts):
        return slice(0, 0)
    best = int(np.argmax(stops - starts))
    return slice(int(starts[best]), int(stops[best]))


class Trace:
    """A recorded run of N steps, read-only.

    Attributes
    ----------
    k : array (N,) of int
        Number of the step.
    t : array (N,)
        Time (s): that of the frames, if they came from elsewhere.
    pose_true : array (N, 3)
        True pose: x, y (work-area px), heading (rad).
    u : array (N, 2)
        Input that the controller gave at the step: left and right voltage (V).
    bounced : array (N,) of bool
        The robot met a wall in this step.
    pose_measured : array (N, 3)
        Measured pose, NaN where the robot was not seen.
    seen : array (N,) of bool
        The robot was seen.
    pose_held : array (N, 3)
        Last measurement, NaN before the first.
    blobs : dict of str to array (N, 2, 2)
        Per colour the centroids (x, y) of the two biggest blobs (work-area px), NaN if missing.
    pose_estimated : array (N, 3)
        Estimated pose, NaN without a state estimator.
    covariance : array (N, 3, 3)
        Its covariance.
    state : array (N, n)
        Any further state of the state estimator; n = 0 without.
    parameters : array (N, 3, 5)
        Online estimate of the model's parameters, NaN without a parameter estimator.
    standard_errors_unscaled : array (N, 3, 5)
        Their standard errors for noise of standard deviation 1 px, 1 px and 1 rad in the equations,
        NaN if the estimator gives none. See `robsim.identifiability`.
    view : array (N, 2)
        Place of the camera's view: 0 unless the area is unlimited (work-area px).
    info : RunInfo
        What concerns the run as a whole.
    """

    def __init__(
        self, groups: Mapping[str, ArrayLike], info: RunInfo, *, first_step: int = 0
    ) -> None:
        if type(first_step) is not int or not 0 <= first_step < 2**62:
            raise ValueError(f"first_step must be an int of at least 0, got {first_step!r}")
        self.info = info
        self._first_step = first_step
        self._groups = {name: _rows_of(name, values) for name, values in groups.items()}
        required = _RECORDED if info.boundary == "recorded" else _SIMULATED
        missing = [name for name in required if name not in groups]
        if missing:
            raise ValueError(f"a trace must have the group {missing[0]}, got {', '.join(groups)}")
        self._rows = len(self._groups[required[0]])
        for name, values in self._groups.items():
            if len(values) != self._rows:
                raise ValueError(f"{name} must have {self._rows} rows, got {len(values)}")

    def __len__(self) -> int:
        return self._rows

    def __repr__(self) -> str:
        last = self._first_step + self._rows - 1
        steps = f"steps {self._first_step}..{last}" if self._rows else "no steps"
        return f"<Trace: {steps}, dt = {self.info.dt} s, columns {', '.join(self._groups)}>"

    def _group(self, name: str, *shape: int) -> Floats:
        """Return the rows of a group, NaN if it was not recorded."""
        if name in self._groups:
            return self._groups[name].reshape(self._rows, *shape)
        return np.broadcast_to(np.float64(np.nan), (self._rows, *shape))

    @property
    def k(self) -> NDArray[np.int64]:
        """Number of each step."""
        return np.arange(self._first_step, self._first_step + self._rows)

    @property
    def t(self) -> Floats:
        """Time of each step (s)."""
        if "t" in self._groups:
            return self._groups["t"][:, 0]
        return np.asarray(self.k * self.info.dt, dtype=np.float64)

    @property
    def pose_true(self) -> Floats:
        """True poses (N, 3)."""
        return self._group("pose_true", 3)

    @property
    def u(self) -> Floats:
        """Inputs (N, 2) in V."""
        return self._group("u", 2)

    @property
    def bounced(self) -> Bools:
        """Steps at which the robot met a wall."""
        return np.asarray(self._group("bounced", 1)[:, 0] > 0)

    @property
    def pose_measured(self) -> Floats:
        """Measured poses (N, 3), NaN where not seen."""
        return self._group("pose_measured", 3)

    @property
    def seen(self) -> Bools:
        """Steps at which the robot was seen."""
        return np.isfinite(self.pose_measured[:, 0])

    @property
    def pose_held(self) -> Floats:
        """Last measurements (N, 3)."""
        return self._group("pose_held", 3)

    @property
    def blobs(self) -> dict[str, Floats]:
        """Centroids of the two biggest blobs per colour, (N, 2, 2) each."""
        names = [name for name in self._groups if name.startswith("blobs_")]
        return {name.removeprefix("blobs_"): self._group(name, 2, 2) for name in names}

    @property
    def pose_estimated(self) -> Floats:
        """Estimated poses (N, 3)."""
        return self._group("pose_estimated", 3)

    @property
    def covariance(self) -> Floats:
        """Covariances of the estimated poses (N, 3, 3)."""
        return self._group("covariance", 3, 3)

    @property
    def state(self) -> Floats:
        """Further state of the state estimator (N, n)."""
        size = self._groups["state"].shape[1] if "state" in self._groups else 0
        return self._group("state", size)

    @property
    def parameters(self) -> Floats:
        """Online parameter estimates (N, 3, 5)."""
        return self._group("parameters", 3, 5)

    @property
    def standard_errors_unscaled(self) -> Floats:
        """Standard errors of the online estimates in units of the noise (N, 3, 5)."""
        return self._group("standard_errors_unscaled", 3, 5)

    @property
    def view(self) -> Floats:
        """Place of the camera's view (N, 2)."""
        if "view" in self._groups:
            return self._group("view", 2)
        return np.broadcast_to(np.float64(0), (self._rows, 2))

    @property
    def error(self) -> Floats:
        """Measured minus true pose (N, 3), the heading's within half a turn; NaN if not seen."""
        error = self.pose_measured - self.pose_true
        error[:, 2] = wrap_angle(error[:, 2])
        return error

    @property
    def is_false(self) -> Bools:
        """Steps with a measured pose that is more than 10 px or 20 degrees off."""
        error = self.error
        distance = np.hypot(error[:, 0], error[:, 1])
        place, heading = FALSE_POSE_LIMITS
        return np.asarray((distance > place) | (np.abs(error[:, 2]) > heading))

    def tracking(self) -> TrackingStatistics:
        """Return how well the measurement followed the truth."""
        error = self.error[self.seen]
        square = np.square(error)

        def rms(squares: Floats) -> float:
            return float(np.sqrt(squares.mean())) if len(squares) else float("nan")

        return TrackingStatistics(
            steps=len(self),
            seen=len(error),
            false_poses=int(self.is_false.sum()),
            rmse_xy=rms(square[:, 0] + square[:, 1]),
            rmse_heading_deg=float(np.rad2deg(rms(square[:, 2]))),
        )

    @property
    def units(self) -> dict[str, str]:
        """Unit of every single column; "" = a plain number."""
        units = {"k": "", "t": "s"}
        for name, values in self._groups.items():
            units |= _fields(name, values.shape[1])
            if name == "pose_measured":
                units["seen"] = ""
        return units

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the single columns, as in the data frame and the CSV file."""
        return tuple(self.units)

    def _columns(self) -> dict[str, NDArray[Any]]:
        columns: dict[str, NDArray[Any]] = {"k": self.k, "t": self.t}
        for name, values in self._groups.items():
            fields = _fields(name, values.shape[1])
            columns |= {field: values[:, i] for i, field in enumerate(fields)}
            if name == "pose_measured":
                columns["seen"] = self.seen
        if "bounced" in columns:
            columns["bounced"] = self.bounced
        return columns

    def __getitem__(self, key: str | slice) -> Any:
        """Return a single column by its name, or a part of the run: ``trace[100:200]``."""
        if isinstance(key, str):
            columns = self._columns()
            if key not in columns:
                raise KeyError(f"no column {key!r}: there are {', '.join(columns)}")
            return columns[key]
        if not isinstance(key, slice):
            raise TypeError(
                f"a trace takes a column name or a slice of steps, got {key!r}; "
                "for one step write trace[k:k + 1]"
            )
        start, stop, stride = key.indices(self._rows)
        if stride != 1:
            raise ValueError(f"a slice of a trace must take every step, got a stride of {stride}")
        groups = {name: values[start:stop] for name, values in self._groups.items()}
        return Trace(groups, self.info, first_step=self._first_step + start)

    def to_pandas(self) -> pandas.DataFrame:
        """Return the single columns as a data frame; its ``attrs["units"]`` has the units.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise ImportError("to_pandas needs pandas: pip install pandas") from error
        frame = pd.DataFrame(self._columns()).set_index("k")
        frame.attrs["units"] = self.units
        return frame

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write the single columns as CSV, one step a line; what was not recorded stays empty.

        Parameters
        ----------
        path : path
            The file to write.
        """
        columns = self._columns()
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            for row in zip(*(values.tolist() for values in columns.values()), strict=True):
                writer.writerow(["" if value != value else value for value in row])

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything into one file, which `load` reads back; no pickle in it.

        Parameters
        ----------
        path : path
            The file to write; by custom its name ends with ``.npz``.
        """
        info = {
            "format": FORMAT,
            "groups": list(self._groups),
            "first_step": self._first_step,
            **asdict(self.info),
        }
        text = np.array(json.dumps(info))
        content = io.BytesIO()
        np.savez_compressed(content, allow_pickle=False, info=text, **self._groups)
        write_whole(Path(path), content.getvalue())

    @staticmethod
    def load(path: str | PathLike[str]) -> Trace:
        """Read a trace that `save` wrote.

        Parameters
        ----------
        path : path
            The file to read.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If it is damaged, or not a trace of robsim.
        """
        with Path(path).open("rb") as file:
            try:
                if not zipfile.is_zipfile(file):
                    raise ValueError("it is not an archive of arrays")
                file.seek(0)
                with np.load(file, allow_pickle=False) as archive:
                    members = {name: archive[name] for name in archive.files}
                return _from_members(members)
            except _BROKEN as error:
                raise ValueError(f"{path} is not a trace of robsim, or damaged: {error}") from error

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{name}</td><td>{' x '.join(map(str, values.shape))}</td>"
            f"<td>{', '.join(_fields(name, values.shape[1]))}</td></tr>"
            for name, values in self._groups.items()
        )
        return (
            f"<p>Trace: {len(self)} steps of {self.info.dt} s</p>"
            f"<table><tr><th>group</th><th>shape</th><th>columns</th></tr>{rows}</table>"
        )


# What reading a broken archive raises, beside the errors of our own checks.
_BROKEN = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    OSError,
    MemoryError,
    RuntimeError,
    OverflowError,
    zipfile.BadZipFile,
    zlib.error,
    SyntaxError,
    tokenize.TokenError,
)


def _from_members(members: Mapping[str, NDArray[Any]]) -> Trace:
    if "info" not in members:
        raise ValueError("it has no info")
    info = json.loads(str(members["info"]))
    if info.pop("format") != FORMAT:
        raise ValueError(f"its format is not {FORMAT!r}")
    first_step = info.pop("first_step")
    groups = {name: values for name, values in members.items() if name != "info"}
    if sorted(info.pop("groups")) != sorted(groups):
        raise ValueError(f"it has not the groups that it had, but {', '.join(groups)}")
    for name, values in groups.items():
        if values.dtype != np.float64 or values.ndim != 2:
            raise ValueError(f"{name} is {values.dtype} of shape {values.shape}")
    info["area"] = tuple(info["area"])
    return Trace(groups, RunInfo(**info), first_step=first_step)
