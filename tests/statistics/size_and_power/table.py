"""The table of all families: its rows measured on all cores, and written."""

from __future__ import annotations

import json
import os
import pkgutil
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from importlib import import_module
from pathlib import Path

from size_and_power.row import Row

_CHUNK = 20  # seeds that a process takes at a time, fewer of a family with slow trials
_HEADS = ("verdict", "what is true", "record", "answer", "trials", "rate", "95 % interval")
_ENDS = ("promised", "")


def family_names() -> list[str]:
    """Return the names of the families of verdicts."""
    folder = Path(__file__).parent / "families"
    return sorted(module.name for module in pkgutil.iter_modules([str(folder)]))


def measured(
    seeds: int,
    names: Sequence[str],
    *,
    first: int = 0,
    processes: int | None = None,
    kept: Path | None = None,
) -> list[Row]:
    """Return the rows of some families.

    Parameters
    ----------
    seeds : int
        Number of seeds; a family with slow trials takes its share of them.
    names : sequence of str
        The families.
    first : int
        The first seed; those of a table that has been looked at should not be used again.
    processes : int, optional
        Number of processes. Default: one for each core that there is for us; 1 = this one.
    kept : Path, optional
        A folder where what is done is kept, so that the next call with it goes on from there.
    """
    jobs = [(name, chunk) for name in names for chunk in _chunks(name, first, seeds)]
    done: dict[tuple[str, range], list[Row]] = {}
    if processes == 1:
        done = {job: _rows(*job, kept) for job in jobs}
    else:
        with ProcessPoolExecutor(processes or len(os.sched_getaffinity(0))) as pool:
            futures = {pool.submit(_rows, *job, kept): job for job in jobs}
            for future in as_completed(futures):
                done[futures[future]] = future.result()
    return [row for name in names for row in _sum([done[job] for job in jobs if job[0] == name])]


def _chunks(name: str, first: int, seeds: int) -> Iterator[range]:
    share = getattr(_module(name), "SHARE", 1.0)
    end = first + max(1, round(seeds * share))
    chunk = max(1, round(_CHUNK * share))
    for start in range(first, end, chunk):
        yield range(start, min(start + chunk, end))


def _rows(name: str, seeds: range, kept: Path | None) -> list[Row]:
    file = kept and kept / f"{name}-{seeds.start}-{seeds.stop}.json"
    if file and file.is_file():
        rows = json.loads(file.read_text())
        return [Row(**row | {"promised": tuple(row["promised"])}) for row in rows]
    rows = _module(name).rows(seeds)
    if file:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.with_suffix(".part").write_text(json.dumps([asdict(row) for row in rows]))
        file.with_suffix(".part").replace(file)
    return rows


def _module(name: str):
    return import_module(f"size_and_power.families.{name}")


def _sum(chunks: Sequence[list[Row]]) -> list[Row]:
    total = chunks[0]
    for chunk in chunks[1:]:
        total = [row.with_more(more) for row, more in zip(total, chunk, strict=True)]
    return total


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
