"""`CampaignResult`: the rows of a campaign, and their evaluation."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats, check_float, check_int, is_int
from robsim.base.files import as_path, open_whole, packed_arrays, write_csv, write_whole
from robsim.base.report import Quantity, Report, Table, count
from robsim.base.report.optional import import_optional
from robsim.base.spelling import check_names
from robsim.base.text import one_line, quoted
from robsim.campaigns._store import trace_in_store
from robsim.campaigns.runs import CaseRuns
from robsim.campaigns.spec import ROW_COLUMNS, CampaignSpec, Case, description_of
from robsim.campaigns.summary import CampaignSummary, summary_of
from robsim.trace import Trace

if TYPE_CHECKING:
    import pandas
Columns = Mapping[str, NDArray[Any]]
_TEXTS = ("error", "line")  # empty without an error


def write_parquet(path: str | PathLike[str], columns: Columns) -> None:
    """Write columns as one Parquet file; unknown values are null."""
    file = as_path(path)
    arrow, parquet = import_arrow()
    table = arrow.table(
        {
            name: arrow.array(values, arrow.string() if name in _TEXTS else None, from_pandas=True)
            for name, values in columns.items()
        }
    )
    with open_whole(file) as stream:
        parquet.write_table(table, stream)


def check_exports(*, parquet: bool, npz: Path | None) -> None:
    """Raise the errors of unwritable files before the long work."""
    if parquet:
        import_arrow()
    if npz is not None:
        check_is_empty(npz)


def import_arrow() -> tuple[Any, Any]:
    """Return pyarrow and its part for Parquet; else raise ImportError."""
    what = "Parquet files need"
    return import_optional("pyarrow", what), import_optional("pyarrow.parquet", what)


def check_is_empty(folder: str | PathLike[str]) -> Path:
    """Return a new or empty folder; else raise an OSError."""
    path = as_path(folder, "folder")
    if path.exists() and not path.is_dir():
        raise NotADirectoryError(f"{one_line(path)} is a file, not a folder: use another name")
    if path.is_dir() and any(path.iterdir()):
        raise FileExistsError(f"{one_line(path)} is not empty: use the name of a new folder")
    return path


def write_npz(folder: str | PathLike[str], columns: Columns, options: tuple[str, ...]) -> None:
    """Write a file for each case into a new folder: all files, or none."""
    path = check_is_empty(folder)
    is_new = not path.exists()
    path.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    try:
        for name, arrays in _cases(columns, options):
            written.append(path / name)
            write_whole(path / name, packed_arrays(arrays))
    except BaseException:
        for file in written:
            with suppress(OSError):
                file.unlink()
        if is_new:
            with suppress(OSError):
                path.rmdir()
        raise


def _cases(
    columns: Columns, options: tuple[str, ...]
) -> Iterator[tuple[str, dict[str, NDArray[Any]]]]:
    """Yield, for each case, the name of its file and its arrays; labels have no rows."""
    n_cases = int(columns["case_id"][-1]) + 1
    digits = max(len(str(n_cases - 1)), 3)
    for case, rows in enumerate(np.split(np.arange(len(columns["run"])), n_cases)):
        arrays = {name: values[rows] for name, values in columns.items()}
        for name in ("case_id", *options):
            arrays[name] = arrays[name][0, ...]
        for name in _TEXTS:
            arrays[name] = np.array([text or "" for text in arrays[name]], str)
        yield f"case_{case:0{digits}}.npz", arrays


_MOST_CASES, _MOST_METRICS = 12, 8  # whose means are shown with the result itself


@dataclass(frozen=True, kw_only=True, eq=False)
class CampaignResult(Report):
    """The runs of a campaign, with a row for each run in the order cases x runs.

    ``result["tracking_rmse_xy"]`` is a column: an array with a number for each row.

    Attributes
    ----------
    spec : CampaignSpec
        The specification of the campaign.
    columns : dict of str to array
        All columns by name: ``case_id``, ``run``, the options (their labels), the numbers of the
        metrics, ``error`` and ``line`` (None for a successful run), ``seconds``.
    store : Path or None
        The file with the rows; None = in memory.

    Examples
    --------
    >>> scenario = robsim.Scenario(area=(300, 300), start="random", measure=True)
    >>> result = robsim.campaign(
    ...     scenario, metrics="tracking", runs=3, steps=10, seed=1, executor=1, progress=False
    ... )
    >>> result["tracking_seen"]
    array([10., 10., 10.])
    """

    spec: CampaignSpec
    columns: Mapping[str, NDArray[Any]]
    store: Path | None = None

    @cached_property
    def metrics(self) -> tuple[str, ...]:
        """Names of the columns with the metrics' numbers."""
        return tuple(name for name in self.columns if name not in self.spec._taken)

    @cached_property
    def failed(self) -> NDArray[np.bool_]:
        """The rows of failed runs."""
        return np.array([error is not None for error in self.columns["error"]], bool)

    def __getitem__(self, name: str) -> NDArray[Any]:
        check_names("a campaign has no column", [str(name)], self.columns, KeyError)
        return self.columns[name]

    def __len__(self) -> int:
        return len(self.columns["run"])

    @property
    def checksum(self) -> str:
        """SHA-256 of all numbers and their column names, equal for equal numbers.

        The checksum includes failed runs, but not the times and the texts of errors.
        """
        content = hashlib.sha256(self.failed.tobytes())
        for name in sorted(self.metrics):
            numbers = self.columns[name]
            content.update(name.encode())
            content.update(np.where(np.isnan(numbers), np.nan, numbers).astype("<f8").tobytes())
        return content.hexdigest()

    @property
    def title(self) -> str:
        """The numbers of cases, runs and steps."""
        cases, spec = len(self.spec.cases), self.spec
        return f"Campaign of {cases} x {spec.runs} runs of {spec.steps} steps"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The numbers of runs and failed runs, and the time of the runs."""
        failed = int(self.failed.sum())
        return (
            Quantity("cases", "cases", len(self.spec.cases)),
            Quantity("runs", "runs", len(self)),
            Quantity("failed", "failed", failed, format=lambda n: count(n, len(self))),
            Quantity("seconds", "time of all runs", float(self.columns["seconds"].sum()), "s"),
        )

    @property
    def tables(self) -> tuple[Table, ...]:
        """The means of the first metrics, for a small number of cases."""
        if len(self.spec.cases) > _MOST_CASES:
            return ()
        return self.summary().tables[:_MOST_METRICS]

    @property
    def remarks(self) -> tuple[str, ...]:
        """The omissions, and the first error."""
        is_all = len(self.spec.cases) <= _MOST_CASES and len(self.metrics) <= _MOST_METRICS
        more = () if is_all else ("summary() has the means of all metrics and cases",)
        if not self.failed.any():
            return more
        return *more, f"the first failed run: {self._first_error}"

    @property
    def _first_error(self) -> str:
        """The error of the first failed run, with its place; empty without failures."""
        if not self.failed.any():
            return ""
        row = int(np.argmax(self.failed))
        case = self.spec.cases[self.columns["case_id"][row]]
        line = self.columns["line"][row]
        place = f" ({line})" if line else ""
        run = f"run {self.columns['run'][row]} of {case}"
        return f"{run}: {self.columns['error'][row]}{place}"

    def summary(
        self,
        by: str | Iterable[str] | None = None,
        *,
        metrics: str | Iterable[str] | None = None,
        level: float = 0.95,
    ) -> CampaignSummary:
        """Return means with their intervals, and differences of paired runs.

        Parameters
        ----------
        by : str or iterable of str, optional
            The options to compare; all others are averaged. Default: all options with more than one
            value.
        metrics : str or iterable of str, optional
            Columns, as in `metrics`. Default: all.
        level : float
            Level of confidence of the intervals, within 0..1.

        Returns
        -------
        CampaignSummary
            For each metric, the mean of each group with its interval. Also the mean of the
            run-by-run differences from the first group, its interval, and the number of further
            runs for a decision.

        Raises
        ------
        TypeError, ValueError
            If an option or metric is unknown, or `level` is out of range.
        """
        options = self.spec.vary
        several = tuple(name for name, choices in options.items() if len(choices) > 1)
        names = several if by is None else _names("by", by, options)
        columns = self.metrics if metrics is None else _names("metrics", metrics, self.metrics)
        check_float("level", level, exclusive_minimum=0, maximum=1 - 1e-9)
        groups: dict[tuple[Any, ...], list[Floats]] = {}
        table = self._numbers(columns)
        for case in self.spec.cases:
            group = tuple(case.labels[name] for name in names)
            groups.setdefault(group, []).append(table[case.index])
        return summary_of(
            np.array([np.mean(cases, axis=0) for cases in groups.values()]),
            by=names,
            groups=[", ".join(map(str, group)) or "all" for group in groups],
            metrics=columns,
            level=level,
            failed=int(self.failed.sum()),
            first_error=self._first_error,
        )

    def _numbers(self, metrics: tuple[str, ...]) -> Floats:
        """Return the numbers of M metrics, (cases, runs, M)."""
        shape = len(self.spec.cases), self.spec.runs
        if not metrics:
            return np.empty((*shape, 0))
        return np.stack([self.columns[name].reshape(shape) for name in metrics], axis=-1)

    def trace(self, case: int | Mapping[str, Any], run: int) -> Trace:
        """Return the trace of a run from the store, or else repeat the run.

        Parameters
        ----------
        case : int or mapping of str to label
            The case: its number from 0, or the labels of its options, such as
            ``{"estimate_state": "EKF"}``; an option with one value can be left out.
        run : int
            Number of the run, from 0.

        Returns
        -------
        Trace
            The trace of the campaign's run; it may differ if a callback depends on more than the
            run.

        Raises
        ------
        TypeError, ValueError
            If the case or run does not exist.
        OSError
            If the store cannot be read.
        Exception
            The run's exception, if it failed.
        """
        chosen = self._case(case)
        check_int("run", run, minimum=0, maximum=self.spec.runs - 1)
        if self.store is not None:
            kept = trace_in_store(self.store, self._description, chosen.index, int(run))
            if kept is not None:
                return kept
        return CaseRuns(self.spec, chosen).trace(int(run))

    @cached_property
    def _description(self) -> dict[str, Any]:
        return description_of(self.spec)

    def _case(self, case: Any) -> Case:
        cases = self.spec.cases
        if is_int(case):
            return cases[check_int("case", case, minimum=0, maximum=len(cases) - 1)]
        if not isinstance(case, Mapping):
            raise TypeError(
                f"case must be a case number, or a dict of option to label, got {quoted(case)}"
            )
        fitting = [one for one in cases if all(one.labels.get(name) == case[name] for name in case)]
        if len(fitting) != 1:
            raise ValueError(
                f"case must match exactly one of the {len(cases)} cases, got {quoted(dict(case))}, "
                f"which matches {len(fitting)}"
            )
        return fitting[0]

    def to_pandas(self) -> pandas.DataFrame:
        """Return the rows as a data frame, with a column for each of `columns`.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        pd = import_optional("pandas", "to_pandas needs")
        frame: pandas.DataFrame = pd.DataFrame(dict(self.columns))
        return frame

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write the rows as CSV; unknown values stay empty.

        A text that a spreadsheet would interpret as a formula is prefixed with an apostrophe.

        Parameters
        ----------
        path : path
            The file to write.

        Raises
        ------
        OSError
            If the file cannot be written; an old file of that name then stays unchanged.
        """
        columns = {name: values.tolist() for name, values in self.columns.items()}
        write_csv(as_path(path), columns)

    def to_parquet(self, path: str | PathLike[str]) -> None:
        """Write the rows as a Parquet file; unknown values are null.

        Parameters
        ----------
        path : path
            The file to write.

        Raises
        ------
        ImportError
            If pyarrow is not installed.
        OSError
            If the file cannot be written; an old file of that name then stays unchanged.
        """
        write_parquet(path, self.columns)

    def to_npz(self, folder: str | PathLike[str]) -> None:
        """Write a file for each case into a folder: ``case_000.npz`` and so on.

        ``numpy.load`` reads them, without pickle. A file has an array for each of `columns`: a
        number for each run, or one label for an option. Texts of successful runs are "".

        Parameters
        ----------
        folder : path
            The folder, new or empty.

        Raises
        ------
        FileExistsError, NotADirectoryError
            If the folder is not empty, or is a file.
        OSError
            If the files cannot be written; then no file is left.
        """
        write_npz(folder, self.columns, tuple(self.spec.vary))


def _names(argument: str, given: Any, known: Collection[str]) -> tuple[str, ...]:
    """Return names, after a check that they are known."""
    names = (given,) if isinstance(given, str) else given
    if not isinstance(names, Iterable):
        raise TypeError(f"{argument} must be names, got {quoted(given)}")
    names = tuple(names)
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"{argument} must be names, got {quoted(name)}")
    check_names(f"{argument} has no", names, known, ValueError)
    return names


def result_of(
    spec: CampaignSpec, stored: Mapping[str, NDArray[Any]], file: Path | None
) -> CampaignResult:
    """Return the result from the columns of a store or of its file."""
    labels = [_labels(list(choices)) for choices in spec.vary.values()]
    places = np.unravel_index(stored["case_id"], [len(one) for one in labels]) if labels else ()
    options = {
        name: known[place] for name, known, place in zip(spec.vary, labels, places, strict=True)
    }
    # In the order of the metrics, not of the first rows.
    order = list(spec.metrics)
    numbers = sorted(
        (name for name in stored if name not in ROW_COLUMNS), key=lambda name: _place(name, order)
    )
    names = ("case_id", "run", *options, *numbers, "error", "line", "seconds")
    columns = {name: options[name] if name in options else stored[name] for name in names}
    for column in columns.values():
        column.setflags(write=False)
    return CampaignResult(spec=spec, columns=columns, store=file and file.absolute())


def _labels(labels: list[Any]) -> NDArray[Any]:
    """Return labels as numbers, if all are numbers, else as texts."""
    are_numbers = not any(isinstance(label, str) for label in labels)
    return np.array(labels if are_numbers else list(map(str, labels)))


def _place(column: str, metrics: list[str]) -> int:
    """Return the metric of a column: the longest name that starts the column's."""
    fitting = [name for name in metrics if column == name or column.startswith(f"{name}_")]
    return metrics.index(max(fitting, key=len))
