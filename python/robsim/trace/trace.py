"""The recorded run: its columns as arrays, slices, tables. `Simulation.run` returns a trace."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robsim._core import TraceGroup, detection_reasons, wrap_angle
from robsim.base.checks import Floats, check_choice, check_kind
from robsim.base.files import as_path, write_csv
from robsim.base.report.optional import import_optional
from robsim.base.spelling import check_names, no_attribute
from robsim.base.text import listed, one_line, quoted
from robsim.base.values import runs_of
from robsim.trace.columns import (
    GROUPS,
    POSES,
    RECORDED,
    SIMULATED,
    Column,
    Flag,
    as_rows,
    fields_of,
    group_of,
    how_recorded,
    not_recorded,
)
from robsim.trace.run_info import RunInfo, is_same_run
from robsim.trace.summary import TraceSummary, summary_of
from robsim.trace.timing import TimingReport, timing_report
from robsim.trace.tracking import FALSE_POSE_LIMITS, TrackingStatistics, tracking_statistics
from robsim.trace.units import converted, in_unit

if TYPE_CHECKING:
    import pandas
Bools = NDArray[np.bool_]

# In the short form at a prompt.
_SHOWN_COLUMNS = 4


def check_trace(trace: Any, *names: str) -> None:
    """Raise TypeError for another type, and NotRecordedError for columns without a value."""
    if not isinstance(trace, Trace):
        hint = ": give sim.trace" if isinstance(getattr(trace, "trace", None), Trace) else ""
        raise TypeError(f"trace must be a Trace, got {quoted(trace)}{hint}")
    trace.require(*names)


def longest_run(mask: Bools) -> slice:
    """Return the longest unbroken run of True in (N,) as a slice; the first of equal runs."""
    return slice(*max(runs_of(mask), key=lambda run: run[1] - run[0], default=(0, 0)))


class Trace:
    """A recorded run of N steps, read-only.

    Every group of columns is a property with a row for each step; `names` and `units` list the
    single columns. Two traces are equal if their columns and their `info` are equal: the same seed
    gives an equal trace.

    Attributes
    ----------
    info : RunInfo
        Facts about the run as a whole.
    """

    def __init__(
        self, groups: Mapping[str, ArrayLike], info: RunInfo, *, first_step: int = 0
    ) -> None:
        if type(first_step) is not int or not 0 <= first_step < 2**62:
            raise ValueError(f"first_step must be an int of at least 0, got {quoted(first_step)}")
        if not isinstance(groups, Mapping):
            raise TypeError(f"groups must be a dict of names to arrays, got {quoted(groups)}")
        check_kind("info", info, RunInfo)
        self.info = info
        self._first_step = first_step
        self._groups = {name: as_rows(name, values) for name, values in groups.items()}
        required = RECORDED if info.boundary == "recorded" else SIMULATED
        missing = [name for name in required if name not in groups]
        if missing:
            raise ValueError(f"a trace must have the group {missing[0]}, got {listed(groups)}")
        self._rows = len(self._groups[required[0]])
        for name, values in self._groups.items():
            if len(values) != self._rows:
                raise ValueError(f"{name} must have {self._rows} rows, got {len(values)}")

    def __len__(self) -> int:
        return self._rows

    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Trace):
            return NotImplemented
        return (
            self._first_step == other._first_step
            and is_same_run(self.info, other.info)
            and self._groups.keys() == other._groups.keys()
            and all(
                np.array_equal(values, other._groups[name], equal_nan=True)
                for name, values in self._groups.items()
            )
        )

    def __repr__(self) -> str:
        last = self._first_step + self._rows - 1
        steps = f"steps {self._first_step}..{last}" if self._rows else "no steps"
        names = list(self._groups)
        more = f", ... ({len(names)} in all)" if len(names) > _SHOWN_COLUMNS else ""
        columns = f"columns {', '.join(map(one_line, names[:_SHOWN_COLUMNS]))}{more}"
        return f"<Trace: {steps}, dt = {self.info.dt} s, {columns}>"

    @property
    def k(self) -> NDArray[np.int64]:
        """Number of the step (N,)."""
        return np.arange(self._first_step, self._first_step + self._rows)

    t = Column()
    pose_true = Column()
    u = Column()
    bounced = Flag()
    pose_measured = Column()
    pose_held = Column()
    covariance_measured = Column()
    misfit = Column()
    signal_to_noise = Column()
    missed = Column()
    pose_estimated = Column()
    covariance = Column()
    parameters = Column()
    standard_errors_unscaled = Column()
    view = Column()
    noise = Column()
    last_u = Column()
    hidden = Flag()
    interrupted = Flag()
    unanswered = Flag()
    t_arrival = Column()
    t_sent = Column()

    def _numbers(self, group: TraceGroup) -> Floats:
        """Return the numbers of a group, or their default if it was not recorded."""
        if group.name in self._groups:
            return self._groups[group.name].reshape(self._rows, *group.shape)
        if group.name == "t":
            return np.asarray(self.k * self.info.dt, dtype=np.float64)
        return np.broadcast_to(np.float64(group.missing), (self._rows, *group.shape))

    @property
    def blobs(self) -> dict[str, Floats]:
        """Centroids of the two largest blobs of each colour (N, 2, 2), NaN if missing (px)."""
        return {
            name.removeprefix("blobs_"): rows.reshape(self._rows, 2, 2)
            for name, rows in self._groups.items()
            if name.startswith("blobs_")
        }

    @property
    def missed_reasons(self) -> NDArray[np.str_]:
        """The reason why the default measurement did not see the robot (N,), as in `Detection`.

        The text is empty if the robot was seen, or without a measurement.
        """
        colors = self.info.marker_colors
        names = detection_reasons(colors) if colors else detection_reasons()
        reasons = np.array(["", *names])
        known = np.clip(self.missed, 0, len(reasons) - 1)
        return np.asarray(reasons[known.astype(np.intp)])

    @property
    def state(self) -> Floats:
        """Further state of the state estimator (N, n); n = 0 without further state."""
        return self._groups.get("state", np.empty((self._rows, 0)))

    @property
    def is_tracked(self) -> bool:
        """Whether pose measurement was part of the run; True even if the robot was never seen."""
        return "pose_measured" in self._groups

    def require(self, *names: str) -> None:
        """Raise an error unless each of the given columns is known in at least one step.

        Parameters
        ----------
        *names : str
            Attributes of the trace, such as ``"pose_estimated"``; or ``"theta_true"`` from `info`.

        Raises
        ------
        NotRecordedError
            If a column is not known; the error explains how to record it.
        ValueError
            If a name is not a column.
        """
        missing = {}
        for name in names:
            check_choice("names", name, (*GROUPS, "theta_true"))
            values = self.info.theta_true if name == "theta_true" else self._numbers(GROUPS[name])
            if not np.isfinite(values).any():
                missing[name] = name in self._groups
        if missing:
            raise not_recorded(missing, steps=len(self))

    def __getattr__(self, name: str) -> Any:
        # Only for missing attributes. Python looks up underscored names, before __init__ too.
        if not name.startswith("_") and "_groups" in vars(self):
            if name in self.names:
                raise no_attribute(f"{name} is a column: trace[{name!r}]")
            known = (*self.names, *(name for name in dir(self) if not name.startswith("_")))
            raise no_attribute(f"a trace has no attribute {quoted(name)}", name, known)
        raise AttributeError(f"a trace has no attribute {quoted(name)}")

    @property
    def seen(self) -> Bools:
        """The robot was seen in this step (N,)."""
        return np.isfinite(self.pose_measured[:, 0])

    def in_unit(self, unit: str, *, mm_per_px: float | None = None) -> Trace:
        """Return the run with its lengths in another unit, for reports, figures and tables.

        Poses, covariances, parameters and blobs change. `state` does not change, because only the
        estimator knows its units. Results and figures from the trace then have that unit, too. Only
        lengths change: (x, y) in mm is `mm_per_px` times (x, y) in px, with the same origin.

        Parameters
        ----------
        unit : str
            ``"px"`` of the work area, ``"mm"``, ``"cm"`` or ``"m"``.
        mm_per_px : float, optional
            Length of a px of the work area on the floor (mm). Default: the length from the camera's
            calibration.

        Returns
        -------
        Trace
            The same steps, with `unit` and `mm_per_px` in its `info`.

        Raises
        ------
        TypeError, ValueError
            If the unit is unknown, or the length of a px is not known, or differs from the
            calibration.

        Examples
        --------
        >>> sim = robsim.Simulation(seed=1, measure=True, estimate_parameters=True)
        >>> trace = sim.run(100).in_unit("cm", mm_per_px=2)
        >>> trace.units["x_true"], trace.units["b1X"]
        ('cm', 'cm/V')
        """
        groups, info = converted(self._groups, self.info, unit=unit, mm_per_px=mm_per_px)
        return Trace(groups, info, first_step=self._first_step)

    def poses_from(self, source: str) -> Floats:
        """Return the poses (N, 3) of a source.

        Parameters
        ----------
        source : str
            ``"truth"``, ``"measurement"`` or ``"estimate"``.

        Raises
        ------
        ValueError
            If `source` is unknown.
        """
        return self._numbers(GROUPS[POSES[check_choice("source", source, tuple(POSES))]])

    @property
    def error(self) -> Floats:
        """Measured minus true pose (N, 3), the heading within half a turn; NaN if not seen."""
        error = self.pose_measured - self.pose_true
        error[:, 2] = wrap_angle(error[:, 2])
        return error

    @property
    def is_false(self) -> Bools:
        """Steps whose measured pose has an error above 10 px or 20 degrees."""
        error = self.error
        distance = np.hypot(error[:, 0], error[:, 1]) / self.info.px_length
        position, heading = FALSE_POSE_LIMITS
        return np.asarray((distance > position) | (np.abs(error[:, 2]) > heading))

    def tracking(self) -> TrackingStatistics:
        """Return how often the robot was seen, and the accuracy of the measurement.

        Returns
        -------
        TrackingStatistics
            The numbers of steps with and without a detected robot, and the reasons for missed
            detections. Also false poses, true errors, and the errors that measurements report. The
            root mean square error and the largest error exclude false poses; the median error
            includes all poses.
        """
        return tracking_statistics(
            self.error,
            self.seen,
            self.is_false,
            reported=self.covariance_measured,
            reasons=self.missed_reasons,
            info=self.info,
        )

    def timing(self) -> TimingReport:
        """Return the regularity of the frames, and the delay of the inputs.

        Raises
        ------
        NotRecordedError
            If the trace has neither `t_arrival` nor `t_sent`, like a trace of a simulation.
        """
        if not (np.isfinite(self.t_arrival) | np.isfinite(self.t_sent)).any():
            self.require("t_arrival", "t_sent")
        return timing_report(
            self.t, self.t_arrival, self.t_sent, interrupted=self.interrupted, dt=self.info.dt
        )

    @property
    def units(self) -> dict[str, str]:
        """Unit of every single column; "" for a number without a unit."""
        units = {"k": "", "t": "s"}
        for name, values in self._groups.items():
            units |= fields_of(name, values.shape[1])
            if name == "pose_measured":
                units["seen"] = ""
        return {name: in_unit(unit, self.info.unit) for name, unit in units.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the single columns, as in the data frame and the CSV file."""
        return tuple(self.units)

    def _columns(self) -> dict[str, NDArray[Any]]:
        columns: dict[str, NDArray[Any]] = {"k": self.k, "t": self.t}
        for name, values in self._groups.items():
            fields = fields_of(name, values.shape[1])
            columns |= {field: values[:, i] for i, field in enumerate(fields)}
            if name == "pose_measured":
                columns["seen"] = self.seen
            if name in GROUPS and GROUPS[name].is_flag:
                columns[name] = getattr(self, name)
        return columns

    def __getitem__(self, key: str | slice) -> Any:
        """Return a single column by its name, or a part of the run: ``trace[100:200]``."""
        if isinstance(key, str):
            columns = self._columns()
            if key in self._groups and key not in columns:
                raise KeyError(f"{key} is an attribute: trace.{key}")
            group = group_of(key)
            if key not in columns and group is not None:
                raise KeyError(f"no column {key!r} in this run: {how_recorded(group)}")
            check_names("no column", [key], columns, KeyError)
            return columns[key]
        if not isinstance(key, slice):
            raise TypeError(
                f"a trace takes a column name or a slice of steps, got {quoted(key)}; "
                "for one step write trace[k:k + 1]"
            )
        start, stop, stride = key.indices(self._rows)
        if stride != 1:
            raise ValueError(
                f"a slice of a trace must include every step, got a stride of {stride}"
            )
        groups = {name: values[start:stop] for name, values in self._groups.items()}
        return Trace(groups, self.info, first_step=self._first_step + start)

    def summary(self) -> TraceSummary:
        """Return the groups of columns, their units, and the numbers of steps with known values."""
        return summary_of(self._groups, self.info, first_step=self._first_step)

    def __str__(self) -> str:
        return str(self.summary())

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()

    def to_pandas(self) -> pandas.DataFrame:
        """Return the single columns as a data frame; its ``attrs["units"]`` has the units.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        pd = import_optional("pandas", "to_pandas needs")
        frame: pandas.DataFrame = pd.DataFrame(self._columns()).set_index("k")
        frame.attrs["units"] = self.units
        return frame

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write the single columns as CSV, one step a line; missing columns stay empty.

        A colour name that a spreadsheet would interpret as a formula is prefixed with an
        apostrophe.

        Parameters
        ----------
        path : path
            The file to write.

        Raises
        ------
        OSError
            If the file cannot be written; an old file of that name then stays unchanged.
        """
        columns = self._columns()
        write_csv(as_path(path), {name: values.tolist() for name, values in columns.items()})

    def save(self, path: str | PathLike[str]) -> None:
        """Write everything into one file without pickle, for `load`.

        Parameters
        ----------
        path : path
            The file to write; the usual suffix is ``.npz``.
        """
        from robsim.trace._trace_file import write_trace

        write_trace(as_path(path), self._content)

    @property
    def _content(self) -> tuple[Mapping[str, Floats], RunInfo, int]:
        return self._groups, self.info, self._first_step

    def _packed(self) -> bytes:
        """Return the bytes of the file that `save` would write."""
        from robsim.trace._trace_file import pack_trace

        return pack_trace(self._content)

    @staticmethod
    def _unpacked(packed: bytes, name: str) -> Trace:
        """Return the trace from the bytes of a file; an error calls them by the name."""
        from robsim.trace._trace_file import unpack_trace

        return unpack_trace(packed, name, Trace._of_content)

    @staticmethod
    def _of_content(content: tuple[Mapping[str, Floats], RunInfo, int]) -> Trace:
        return Trace(*content[:2], first_step=content[2])

    @staticmethod
    def load(path: str | PathLike[str]) -> Trace:
        """Read a trace written by `save`.

        Parameters
        ----------
        path : path
            The file to read.

        Raises
        ------
        FileNotFoundError
            If the file does not exist.
        ValueError
            If the file is damaged, or not a trace of robsim.
        """
        from robsim.trace._trace_file import read_trace

        return read_trace(as_path(path), Trace._of_content)
