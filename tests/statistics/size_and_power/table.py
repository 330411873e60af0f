"""The table of all families: its rows measured, and written."""

from __future__ import annotations

import json
import pkgutil
from collections.abc import Sequence
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

from size_and_power.trials import Row, Trials

_HEADS = ("verdict", "what is true", "record", "answer", "trials", "rate", "95 % interval")
_ENDS = ("promised", "")


def family_names() -> list[str]:
    """Return the names of the families of verdicts."""
    folder = Path(__file__).parent / "families"
    return sorted(module.name for module in pkgutil.iter_modules([str(folder)]))


def measured(
    trials: int,
    names: Sequence[str],
    *,
    seed: int = 0,
    executor: int | None = None,
    keep: Path | None = None,
) -> list[Row]:
    """Return the rows of some families.

    Of trials that are slow a share is made, in so many processes as `executor` says; they are kept
    in a folder, so that the next call goes on from there. The seed is what all seeds come from:
    that of a table that has been looked at should not be used again.
    """
    if keep:
        keep.mkdir(parents=True, exist_ok=True)
    return [
        row
        for name in names
        for one in trials_of(name)
        for row in one.counted(
            trials, seed=seed, executor=executor, keep=keep and keep / f"{name}-{one.name}.sqlite"
        )
    ]


def trials_of(name: str) -> Sequence[Trials]:
    """Return the campaigns of a family."""
    return import_module(f"size_and_power.families.{name}").TRIALS


def as_markdown(rows: Sequence[Row]) -> str:
    """Return the table as Markdown."""
    lines = [_line((*_HEADS, *_ENDS)), "| --- " * len((*_HEADS, *_ENDS)) + "|"]
    for row in rows:
        numbers = (str(row.trials), _percent(row.rate), _between(row.interval))
        judged = (_between(row.promised), "holds" if row.holds else "**does not hold**")
        lines.append(_line((*row.key, *numbers, *judged)))
    return "\n".join(lines) + "\n"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _percent(rate: float) -> str:
    return f"{100 * rate:.1f} %"


def _between(rates: tuple[float, float]) -> str:
    return f"{100 * rates[0]:.1f} to {100 * rates[1]:.1f} %"


def as_json(rows: Sequence[Row]) -> str:
    """Return the rows as JSON."""
    content = [
        asdict(row) | {"rate": row.rate, "interval": row.interval, "holds": row.holds}
        for row in rows
    ]
    return json.dumps(content, indent=1) + "\n"
