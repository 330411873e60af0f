"""Numbers with titles, units and formats: single ones, and tables."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim.base.checks import check_float, check_int, check_kinds, check_text
from robsim.base.text import quoted

#: A format specification such as ``".4g"``, or a function of the value that returns its text.
Format = str | Callable[[Any], str]
# The displayed unit, and its factor.
_READ = {"rad": ("deg", math.degrees(1.0))}


def percent(fraction: float, decimals: int = 1) -> str:
    """Return a fraction as a text such as ``"75.0 %"``.

    Only 0 is shown as 0 %, and only 1 as 100 %: values close to these limits get more decimals.

    Parameters
    ----------
    fraction : float
        The fraction, at least 0: 1 is 100 %.
    decimals : int
        Number of decimals, if they are enough, within 0..3.

    Examples
    --------
    >>> robsim.estimation.percent(0.123), robsim.estimation.percent(0.99999)
    ('12.3 %', '99.999 %')
    """
    if not (isinstance(fraction, float) and fraction == math.inf):
        check_float("fraction", fraction, minimum=0)
    check_int("decimals", decimals, minimum=0, maximum=3)
    if fraction in (0.0, 1.0):
        return f"{100 * fraction:.0f} %"
    if fraction > 10.0:
        return "> 1000 %"
    for more in range(decimals, 4):
        text = f"{100 * fraction:.{more}f}"
        if float(text) not in (0.0, 100.0):
            return f"{text} %"
    if fraction > 1.0:
        return "> 100 %"
    return "< 0.001 %" if fraction < 0.5 else "> 99.999 %"


def count(part: int, whole: int) -> str:
    return f"{part} ({percent(part / whole)})" if whole else f"{part}"


def interval(limits: Any) -> str:
    """Return two limits as a text such as ``"2.79 to 3.22"``."""
    low, high = limits
    return f"{low:.3g} to {high:.3g}"


def shown_unit(unit: str) -> str:
    """Return the displayed unit: degrees instead of rad."""
    return _READ[unit][0] if unit in _READ else unit


def shown(value: Any, unit: str, format_: Format, missing: str) -> str:
    """Return a value in `shown_unit` as displayed; `missing` for None and NaN."""
    if value is None or (isinstance(value, (float, np.floating)) and math.isnan(value)):
        return missing
    if unit in _READ:
        value = value * _READ[unit][1]
    if callable(format_):
        return format_(value)
    is_float = isinstance(value, (float, np.floating))
    return format(value, format_) if is_float else str(value)


def plain(value: Any) -> Any:
    """Return a value without types of numpy, as JSON has it: None for NaN and infinity."""
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _check_labels(label: Quantity | Column) -> None:
    for name in ("key", "title", "missing"):
        check_text(name, getattr(label, name))
    if label.unit is not None or isinstance(label, Quantity):
        check_text("unit", label.unit)
    if not (isinstance(label.format, str) or callable(label.format)):
        raise TypeError(f"format must be a function, or text such as '.4g', got {label.format}")


def _headed(title: str, unit: str) -> str:
    return f"{title} ({shown_unit(unit)})" if unit else title


@dataclass(frozen=True)
class Quantity:
    """A single number, or text, of a report.

    Parameters
    ----------
    key : str
        Its name in programs: in `Report.to_dict`, in the data frame.
    title : str
        Its name for people.
    value : float, int, str, ...
        The value; None or NaN = not known.
    unit : str
        Its unit; an angle in ``"rad"`` is shown in degrees.
    format : str or callable
        Format of a float, or a function of the value that returns its text, such as `percent`.
    missing : str
        The displayed text if the value is not known.

    Examples
    --------
    >>> error = robsim.estimation.Quantity("rmse", "rms error", 0.03125, unit="px", format=".3f")
    >>> f"{error.title}: {error.value:{error.format}} {error.unit}"
    'rms error: 0.031 px'
    """

    key: str
    title: str
    value: Any
    unit: str = ""
    format: Format = ".4g"
    missing: str = "-"

    def __post_init__(self) -> None:
        _check_labels(self)

    @property
    def title_with_unit(self) -> str:
        """The title with the displayed unit."""
        return _headed(self.title, self.unit)

    @property
    def line(self) -> str:
        """Title, value and unit, such as ``"rms voltage 0.76 V"``."""
        return f"{self.title} {self.text} {shown_unit(self.unit)}".rstrip()

    @property
    def text(self) -> str:
        """The displayed value."""
        return shown(self.value, self.unit, self.format, self.missing)


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    key, title, format, missing
        As for a `Quantity`.
    unit : str or None
        Unit of its values; "" = plain numbers, None = each row has its own.

    Examples
    --------
    >>> column = robsim.estimation.Column("rmse", "rms error", unit="px", format=".2f")
    >>> f"{column.title} ({column.unit}): {0.0312:{column.format}}"
    'rms error (px): 0.03'
    """

    key: str
    title: str
    unit: str | None = None
    format: Format = ".4g"
    missing: str = "-"

    def __post_init__(self) -> None:
        _check_labels(self)


@dataclass(frozen=True)
class Row:
    """A row of a table.

    Parameters
    ----------
    title : str
        Its name, also in programs.
    values : sequence
        A value for each column; None or NaN = not known.
    unit : str
        Unit of the values in columns without one; an angle in ``"rad"`` is shown in degrees.

    Examples
    --------
    >>> row = robsim.estimation.Row("x", [0.031, 0.042], unit="px")
    >>> row.title, max(row.values)
    ('x', 0.042)
    """

    title: str
    values: Sequence[Any]
    unit: str = ""

    def __post_init__(self) -> None:
        check_text("title", self.title)
        check_text("unit", self.unit)
        is_text = isinstance(self.values, (str, bytes))
        if is_text or not isinstance(self.values, (Sequence, np.ndarray)):
            raise TypeError(f"values must be a sequence, got {quoted(self.values)}")


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of a report.

    Parameters
    ----------
    key : str
        Its name in programs.
    columns : sequence of Column
        The columns.
    rows : sequence of Row
        The numbers.
    row_title : str
        The subject of a row, such as ``"parameter"``.
    group : int
        Number of rows in a group, between two rules; 0 = no rules.
    """

    key: str
    columns: Sequence[Column]
    rows: Sequence[Row]
    row_title: str = ""
    group: int = 0

    def __post_init__(self) -> None:
        check_text("key", self.key)
        check_text("row_title", self.row_title)
        check_int("group", self.group, minimum=0, maximum=sys.maxsize)
        object.__setattr__(self, "columns", check_kinds("columns", self.columns, Column))
        object.__setattr__(self, "rows", check_kinds("rows", self.rows, Row))

    @property
    def column_titles(self) -> list[str]:
        """The titles of the columns with their units, the row title first."""
        titles = (_headed(column.title, column.unit or "") for column in self.columns)
        return [self.row_title, *titles]

    def texts(self) -> Iterator[list[str]]:
        """Yield the displayed rows, each with the title and its unit first."""
        for row in self.rows:
            cells = []
            for column, value in zip(self.columns, row.values, strict=True):
                unit = row.unit if column.unit is None else column.unit
                cells.append(shown(value, unit, column.format, column.missing))
            yield [_headed(row.title, row.unit), *cells]

    @property
    def alignments(self) -> list[str]:
        """The alignment of the columns, the row titles first: left for texts, right for numbers."""
        values = zip(*(row.values for row in self.rows), strict=True)
        are_texts = [all(isinstance(value, (str, list)) for value in column) for column in values]
        return ["left", *("left" if is_text else "right" for is_text in are_texts)]

    @property
    def has_units(self) -> bool:
        """Whether each row has a separate unit."""
        return any(row.unit for row in self.rows)

    def records(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield each row as a dict of title and values, with "unit" if the rows have units."""
        keys = [column.key for column in self.columns]
        for row in self.rows:
            unit = {"unit": row.unit} if self.has_units else {}
            yield row.title, unit | dict(zip(keys, row.values, strict=True))
