"""The base of every result: numbers that describe themselves, so that all formats follow."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from robsim.base.checks import check_int
from robsim.base.report.forms import as_dict, as_frame, as_html, as_line, as_text
from robsim.base.report.problem import Problem
from robsim.base.report.table import Quantity, Table

if TYPE_CHECKING:
    import pandas

_PARTS = ("title", "verdict", "at_limit", "quantities", "tables", "problems", "remarks")


class Report(ABC):
    """A result: a dataclass of numbers with their titles and units.

    A subclass has the property `title` and, if they apply, `verdict`, `at_limit`, `quantities`,
    `tables` and `remarks`. They define the short line at a prompt, the text of ``print``, the table
    in a notebook, `to_dict`, `to_json` and `to_pandas`.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> from robsim.estimation import Quantity, Report
    >>> @dataclass(frozen=True, kw_only=True)
    ... class Effort(Report):
    ...     largest: float
    ...
    ...     @property
    ...     def title(self):
    ...         return "Voltages of both motors"
    ...
    ...     @property
    ...     def verdict(self):
    ...         return "gentle" if self.largest < 1 else "rough"
    ...
    ...     @property
    ...     def quantities(self):
    ...         return (Quantity("largest", "largest", self.largest, "V", ".2f"),)
    >>> trace = robsim.Simulation(control=lambda step: (0.4, 0.6)).run(20)
    >>> print(Effort(largest=np.abs(trace.u).max()))
    Voltages of both motors: gentle
      largest (V)   0.60
    """

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name in set(_PARTS) & set(cls.__annotations__) - set(vars(cls)):
            raise TypeError(
                f"{cls.__name__}.{name} must be a property or a field with a default, because "
                "Report has a property with this name"
            )
        # A dataclass makes a repr of all its arrays, unless the class defines another one.
        if "__repr__" not in vars(cls):
            cls.__repr__ = Report.__repr__  # type: ignore[method-assign]

    @property
    @abstractmethod
    def title(self) -> str:
        """The subject of the report, in one line."""

    @property
    def verdict(self) -> str | None:
        """The verdict in a word or two; None = no verdict."""
        return None

    @property
    def at_limit(self) -> bool | None:
        """Whether the verdict is at the limit; None = the verdict does not depend on chance.

        A verdict is at the limit if it would change when the decisive number moves by one standard
        deviation. Other seeds may then give another verdict.
        """
        return None

    @property
    def quantities(self) -> Sequence[Quantity]:
        """The single numbers."""
        return ()

    @property
    def tables(self) -> Sequence[Table]:
        """The tables of numbers."""
        return ()

    @property
    def problems(self) -> Sequence[Problem] | None:
        """The problems found; None = the report is not from a check."""
        return None

    @property
    def remarks(self) -> Sequence[str]:
        """Further remarks for the reader, each a sentence."""
        return ()

    @property
    def headline(self) -> str:
        """The title and the verdict, in one line."""
        if self.verdict is None:
            return self.title
        return f"{self.title}: {self.verdict}{', at the limit' if self.at_limit else ''}"

    @property
    def line(self) -> str:
        """The headline and the single numbers, in one line."""
        return as_line(self)

    def __str__(self) -> str:
        return as_text(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {as_line(self, 80)}>"

    def _repr_html_(self) -> str:
        return as_html(self)

    def to_dict(self) -> dict[str, Any]:
        """Return a dict of plain values: title, verdict, at_limit, quantities, tables and remarks.

        A table maps each row to a dict of its columns' values. ``"units"`` has the units of
        quantities and columns; a row has its own. None = not known, or not finite. Angles are in
        rad, unless ``"units"`` gives deg.
        """
        return as_dict(self)

    def to_json(self, *, indent: int | None = 2) -> str:
        """Return `to_dict` as JSON.

        Parameters
        ----------
        indent : int, optional
            Number of spaces per level of indentation; None = all in one line.
        """
        import json

        if indent is not None:
            check_int("indent", indent, minimum=0, maximum=16)
        return json.dumps(self.to_dict(), indent=indent, allow_nan=False)

    def to_pandas(self) -> pandas.DataFrame:
        """Return the table as a data frame, or the quantities if there is no table.

        The ``attrs`` of the data frame have the title and the verdict; angles are in rad.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        return as_frame(self)
