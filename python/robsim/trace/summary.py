"""The content of a trace: groups of columns, their units, and their number of known steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robsim.base.checks import Floats
from robsim.base.report import Column, Quantity, Report, Row, Table, count
from robsim.trace.columns import fields_of
from robsim.trace.run_info import RunInfo
from robsim.trace.units import in_unit

# Characters that a line has room for.
_NAMES, _UNITS = 40, 10


@dataclass(frozen=True, kw_only=True, eq=False)
class TraceSummary(Report):
    """The content of a trace, from `Trace.summary`.

    Attributes
    ----------
    steps : int
        Number of steps.
    first_step : int
        Number of the first step.
    dt : float
        Sample time (s).
    known : dict of str to int
        Number of steps in which each group of columns is known, by its name.
    columns : dict of str to dict
        Single columns of each group, name -> unit.

    Examples
    --------
    >>> sim = robsim.Simulation(seed=1, measure=True, dropout=robsim.Dropout(0.2, 3))
    >>> summary = sim.run(100).summary()
    >>> summary.steps, summary.known["pose_measured"]
    (100, 88)
    """

    steps: int
    first_step: int
    dt: float
    known: Mapping[str, int]
    columns: Mapping[str, Mapping[str, str]]

    @property
    def title(self) -> str:
        """The recorded steps."""
        last = self.first_step + self.steps - 1
        return f"Trace, steps {self.first_step}..{last}" if self.steps else "Trace, no steps"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Number of steps and sample time."""
        return Quantity("steps", "steps", self.steps), Quantity("dt", "sample time", self.dt, "s")

    @property
    def tables(self) -> tuple[Table, ...]:
        """Groups of columns with their units, and the steps in which they are known."""
        columns = (
            Column("columns", "single columns", format=lambda names: _listed(names, _NAMES)),
            Column("units", "units", format=lambda units: _listed(units, _UNITS)),
            Column("known", "steps known", format=lambda n: count(n, self.steps)),
        )
        rows = [
            Row(
                group,
                (list(fields), [*dict.fromkeys(filter(None, fields.values()))], self.known[group]),
            )
            for group, fields in self.columns.items()
        ]
        return (Table(key="groups", columns=columns, rows=rows, row_title="attribute"),)


def summary_of(groups: Mapping[str, Floats], info: RunInfo, *, first_step: int) -> TraceSummary:
    steps = {len(values) for values in groups.values()}
    return TraceSummary(
        steps=max(steps),
        first_step=first_step,
        dt=info.dt,
        known={
            name: int(np.count_nonzero(np.isfinite(values).any(axis=1)))
            for name, values in groups.items()
        },
        columns={
            name: {
                field: in_unit(unit, info.unit)
                for field, unit in fields_of(name, values.shape[1]).items()
            }
            for name, values in groups.items()
        },
    )


def _listed(names: list[str], room: int) -> str:
    """Return as many names as fit."""
    text = ", ".join(names)
    while len(text) > room:
        names = names[:-1]
        text = ", ".join([*names, "..."])
    return text
