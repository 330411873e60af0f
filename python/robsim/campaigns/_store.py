"""The store of a campaign: one SQLite file, or memory without a file."""

from __future__ import annotations

import json
import os
import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.files import as_path
from robsim.base.files.reading import open_file, parse_json
from robsim.base.text import one_line, quoted, said_by
from robsim.base.warn import warn_user
from robsim.campaigns.runs import Job, Row
from robsim.campaigns.spec import (
    ROW_COLUMNS,
    CampaignSpec,
    description_of,
    difference,
    surroundings,
)
from robsim.trace import Trace

_FORMAT = 2
_APPLICATION = 0x726F6273  # "robs", in the header of the file
_PATIENCE = 30.0  # s that another program may have the file for itself
_BATCH = 1000  # rows
_NUMBERS = ("case_id", "run", "seconds")  # of ROW_COLUMNS
_TEXTS = ("error", "line")
_MOST_VALUE = 2**27  # bytes of a trace or text
_SUPER_JOURNAL = bytes.fromhex("d9d505f920a163d7")  # ends a journal that names another file
_MOST_LABELS = 1_000_000  # of all cases
_NOTES = {"format": int, "description": dict, "surroundings": dict}
_SCHEMA = {  # %s: columns of options and metrics
    "campaign": "CREATE TABLE campaign (key TEXT PRIMARY KEY, value TEXT)",
    "cases": "CREATE TABLE cases (case_id INTEGER PRIMARY KEY%s)",
    "columns": "CREATE TABLE columns (position INTEGER PRIMARY KEY, name TEXT, sql_name TEXT)",
    "runs": "CREATE TABLE runs (case_id INTEGER REFERENCES cases, run INTEGER, error TEXT, "
    "line TEXT, seconds REAL%s, PRIMARY KEY (case_id, run)) WITHOUT ROWID",
    "traces": "CREATE TABLE traces (case_id INTEGER, run INTEGER, trace BLOB, "
    "PRIMARY KEY (case_id, run))",
    "results": "CREATE VIEW results AS SELECT * FROM cases JOIN runs USING (case_id)",
}
_OURS = re.compile(
    "|".join(map(re.escape, _SCHEMA.values())).replace("%s", r'(?:, "(?:[^"]|"")*+"(?: REAL)?)*+')
)
_WANTED = "run >= 0 AND run < ? AND case_id >= 0 AND case_id < ?"  # of a larger campaign, too


class Store:
    """The rows of a campaign, in a file or in memory (None). Only one process writes.

    Table ``cases`` has the labels of each case. Table ``runs`` has a row for each run, with a
    column for each number of a metric. Table ``campaign`` identifies the campaign. Table
    ``columns`` has the metrics' columns in their order. The view ``results`` joins cases and runs.
    Kept traces are in table ``traces``, as bytes of the file from `Trace.save`.
    """

    def __init__(self, path: str | PathLike[str] | None, spec: CampaignSpec) -> None:
        self.path = None if path is None else as_path(path)
        self.spec = spec  # an unseeded one takes the seed of the store
        with _naming(self.path):
            self._database = _connection(self.path or ":memory:")
        try:
            with _naming(self.path):
                self._open()
        except BaseException:
            self._database.close()
            raise

    def _open(self) -> None:
        if _is_empty(self._database):
            with suppress(sqlite3.OperationalError):  # not on every file system
                self._database.execute("PRAGMA journal_mode = WAL")
            self._synchronize()
            with self._transaction():
                if _is_empty(self._database):  # still: no other process was first
                    self._create()
                    return
        _check_is_store(self._database)
        _check_is_whole(self._database)
        self._check_fits()
        self._synchronize()

    def _synchronize(self) -> None:
        """Flush to the disk as often as needed against a power failure; with WAL that is seldom."""
        mode = self._database.execute("PRAGMA journal_mode").fetchone()[0]
        level = "NORMAL" if mode == "wal" else "FULL"
        self._database.execute(f"PRAGMA synchronous = {level}")

    def _create(self) -> None:
        options = "".join(f", {_quoted(name)}" for name in self.spec.vary)
        execute = self._database.execute
        execute(f"PRAGMA application_id = {_APPLICATION}")
        for name, sql in _SCHEMA.items():
            execute(sql.replace("%s", options if name == "cases" else ""))
        assert self.spec.scenario is not None
        content = {
            "format": _FORMAT,
            "description": description_of(self.spec) if self.path else {},
            "surroundings": surroundings(),
        }
        for key, value in content.items():
            execute("INSERT INTO campaign VALUES (?, ?)", (key, json.dumps(value)))
        places = ", ?" * len(self.spec.vary)
        self._database.executemany(
            f"INSERT INTO cases VALUES (?{places})",
            [(case.index, *case.labels.values()) for case in self.spec.cases],
        )

    def _check_fits(self) -> None:
        notes = _notes(self._database)
        if self.spec._is_unseeded:
            seed = np.random.SeedSequence(**notes["description"]["seed"])
            self.spec = self.spec._with_seed(seed)
        if (other := difference(notes["description"], description_of(self.spec))) is not None:
            raise ValueError(
                f"this file contains another campaign: {other}; use another file, or remove this "
                "file"
            )
        now, then = surroundings(), notes["surroundings"]
        if changed := [name for name in now if now[name] != then.get(name)]:
            name = changed[0]
            warn_user(
                f"store {one_line(self.path)} was created with {name} {quoted(then.get(name))}, "
                "here "
                f"is {now[name]!r}: the last digits may differ"
            )

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._database.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            with suppress(sqlite3.Error):  # after a full disk, SQLite has rolled back already
                self._database.execute("ROLLBACK")
            raise
        self._database.execute("COMMIT")

    def count(self) -> int:
        with _naming(self.path):
            found = self._database.execute(
                f"SELECT count(*) FROM runs WHERE {_WANTED}", (self.spec.runs, len(self.spec.cases))
            )
            return int(found.fetchone()[0])

    def missing(self) -> Iterator[Job]:
        """Yield the missing runs, cases x runs; each case is looked up in its turn."""
        for case in self.spec.cases:
            with _naming(self.path):
                found = self._database.execute(
                    "SELECT run FROM runs WHERE case_id = ?", (case.index,)
                )
                done = {run for (run,) in found}
            yield from ((case.index, run) for run in range(self.spec.runs) if run not in done)

    def add(self, rows: Sequence[Row]) -> None:
        """Write rows, all or none; existing rows stay unchanged."""
        with _naming(self.path), self._transaction():
            columns = self._columns()  # another program may have added some
            for row in rows:
                for name in row.numbers:
                    if name not in columns:
                        columns[name] = self._add_column(name, columns)
            self._insert(rows, columns)

    def _columns(self) -> dict[str, str]:
        """Return the columns of the metrics: name to SQL name."""
        found = self._database.execute("SELECT name, sql_name FROM columns ORDER BY position")
        columns = dict(found.fetchall())
        there = {name for _, name, *_ in self._database.execute("PRAGMA table_info(runs)")}
        metrics = tuple(f"{name}_" for name in self.spec.metrics)
        if not (
            there.issuperset(columns.values())
            and all(f"{name}_".startswith(metrics) for name in columns)
        ):
            raise ValueError("its runs lack some of the columns in its list of columns")
        return columns

    def _add_column(self, name: str, columns: Mapping[str, str]) -> str:
        taken = {known.casefold() for known in (*columns.values(), *self.spec._taken)}
        sql_name, number = name, 1
        while sql_name.casefold() in taken:  # SQL does not tell capitals
            number += 1
            sql_name = f"{name}_{number}"
        self._database.execute(f"ALTER TABLE runs ADD COLUMN {_quoted(sql_name)} REAL")
        values = (len(columns), name, sql_name)
        self._database.execute("INSERT INTO columns VALUES (?, ?, ?)", values)
        return sql_name

    def _insert(self, rows: Sequence[Row], columns: Mapping[str, str]) -> None:
        names = ", ".join(map(_quoted, (*ROW_COLUMNS, *columns.values())))
        places = ", ?" * (len(ROW_COLUMNS) + len(columns) - 1)
        self._database.executemany(
            f"INSERT OR IGNORE INTO runs ({names}) VALUES (?{places})",
            ((*row[:5], *map(row.numbers.get, columns)) for row in rows),
        )
        kept = [(row.case, row.run, row.trace) for row in rows if row.trace is not None]
        self._database.executemany("INSERT OR IGNORE INTO traces VALUES (?, ?, ?)", kept)

    def read(self) -> dict[str, NDArray[Any]]:
        """Return the columns of all runs, cases x runs; LookupError while runs are missing."""
        count = len(self.spec.cases) * self.spec.runs
        with _naming(self.path):
            if (there := self.count()) != count:
                raise LookupError(f"the store has only {there} of {count} runs")
            metrics = self._columns()
            numbers = self._numbers({name: name for name in _NUMBERS} | metrics, count)
            texts = self._texts(count)
        ids = {name: numbers[name].astype(int) for name in ("case_id", "run")}
        return {name: (numbers | ids | texts)[name] for name in (*ROW_COLUMNS, *metrics)}

    def _numbers(self, columns: Mapping[str, str], count: int) -> dict[str, NDArray[Any]]:
        """Return the columns of so many rows by name, as floats; NaN = not known."""
        cursor = self._select(columns.values())
        table = np.empty((count, len(columns)), order="F")
        begin = 0
        while batch := cursor.fetchmany(_BATCH):
            table[begin : begin + len(batch)] = np.array(batch, float)
            begin += len(batch)
        return {name: table[:, i] for i, name in enumerate(columns)}

    def _texts(self, count: int) -> dict[str, NDArray[Any]]:
        """Return the columns of texts, None in the rows of successful runs."""
        runs = self.spec.runs
        texts = {name: np.full(count, None, object) for name in _TEXTS}
        for case, run, *found in self._select(("case_id", "run", *_TEXTS), "error IS NOT NULL"):
            for column, text in zip(texts.values(), found, strict=True):
                column[case * runs + run] = text
        return texts

    def _select(self, columns: Iterable[str], which: str = "true") -> sqlite3.Cursor:
        names = ", ".join(map(_quoted, columns))
        return self._database.execute(
            f"SELECT {names} FROM runs WHERE {_WANTED} AND {which} ORDER BY case_id, run",
            (self.spec.runs, len(self.spec.cases)),
        )

    def close(self) -> None:
        """Close the file, and merge WAL's side file into it."""
        with _naming(self.path):
            self._database.close()


def trace_in_store(path: Path, description: Mapping[str, Any], case: int, run: int) -> Trace | None:
    """Return a run's trace; None without trace or store, ValueError for a damaged one."""
    if not path.exists():
        return None
    with _naming(path), closing(_connection(path)) as database:
        if not _is_store(database) or _notes(database)["description"] != description:
            return None
        found = database.execute(
            "SELECT trace FROM traces WHERE case_id = ? AND run = ?", (case, run)
        ).fetchone()
    if found is None:
        return None
    return Trace._unpacked(found[0], f"store {one_line(path)}: run {run} of case {case}")


@contextmanager
def _naming(path: Path | None) -> Iterator[None]:
    """Add the file's name to an error of SQLite, or of content not written by robsim."""
    where = "store in memory" if path is None else f"store {one_line(path)}"
    try:
        yield
    except sqlite3.Error as error:
        raise OSError(f"{where}: {error}") from error
    except (ValueError, TypeError, KeyError, IndexError, OverflowError) as error:
        said = one_line(error) if type(error) is ValueError else f"damaged: {said_by(error)}"
        raise ValueError(f"{where}: {said}") from error


def _connection(file: Path | str) -> sqlite3.Connection:
    """Return a connection to a file from an untrusted source."""
    names = set() if file == ":memory:" else {os.path.abspath(file), os.path.realpath(file)}
    for name in names:
        with suppress(FileNotFoundError), open_file(Path(f"{name}-journal")) as journal:
            journal.seek(max(0, journal.seek(0, os.SEEK_END) - len(_SUPER_JOURNAL)))
            if journal.read() == _SUPER_JOURNAL:  # SQLite would delete the other file
                raise ValueError(
                    f"another program wrote {one_line(journal.name)}: move it to another folder"
                )
    database = sqlite3.connect(file, timeout=_PATIENCE, isolation_level=None)
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MOST_VALUE)
    database.execute("PRAGMA trusted_schema = OFF")
    return database


def _is_empty(database: sqlite3.Connection) -> bool:
    return not database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]


def _is_store(database: sqlite3.Connection) -> bool:
    """Whether a file is a store of a campaign, with only the content that robsim writes."""
    if database.execute("PRAGMA application_id").fetchone()[0] != _APPLICATION:
        return False
    return all(
        kind == "index" if sql is None else _OURS.fullmatch(sql)
        for kind, sql in database.execute("SELECT type, sql FROM sqlite_master")
    )


def _check_is_store(database: sqlite3.Connection) -> None:
    """Raise ValueError for a file of another program, or of another version."""
    if not _is_store(database):
        raise ValueError(
            "this is not the store of a campaign, or it contains tables, indexes, views or "
            "triggers of another program: use another file"
        )
    number = _notes(database)["format"]
    if number != _FORMAT:
        raise ValueError(
            f"it has format {quoted(number)}, but this version of robsim reads format {_FORMAT}"
        )


def _check_is_whole(database: sqlite3.Connection) -> None:
    """Raise ValueError if pages of the tables are damaged; a trace is checked on reading."""
    for table in ("campaign", "cases", "columns", "runs"):  # whose content is read at opening
        problem = database.execute(f"PRAGMA quick_check({table})").fetchone()[0]
        if problem != "ok":
            raise ValueError(f"it is damaged: {one_line(problem)}")


def _notes(database: sqlite3.Connection) -> dict[str, Any]:
    """Return the notes of a store on its campaign; ValueError: not written by robsim."""
    notes = {}
    for key, kind in _NOTES.items():
        found = database.execute("SELECT value FROM campaign WHERE key = ?", (key,)).fetchone()
        value = found[0] if found else None
        notes[key] = parse_json(value, _MOST_LABELS) if isinstance(value, str) else None
        if not isinstance(notes[key], kind):
            raise ValueError(f"its {key} must be {kind.__name__}, got {quoted(notes[key])}")
    return notes


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'
