"""The rows of a campaign as files for other programs: Parquet, a folder of npz."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robsim.base.files import as_folder, as_path, open_whole, packed_arrays, write_whole
from robsim.base.report.optional import import_optional
from robsim.base.text import one_line

Columns = Mapping[str, NDArray[Any]]

_TEXTS = ("error", "line")  # None where there is none


def write_parquet(path: str | PathLike[str], columns: Columns) -> None:
    """Write columns as one Parquet file; what is not known is null."""
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


def import_arrow() -> tuple[Any, Any]:
    """Return pyarrow and its part for Parquet; else raise ImportError."""
    what = "Parquet files need"
    return import_optional("pyarrow", what), import_optional("pyarrow.parquet", what)


def check_is_empty(folder: str | PathLike[str]) -> Path:
    """Return a folder that is to be made, or is empty; else raise an OSError."""
    path = as_folder(folder)
    if path.exists() and not path.is_dir():
        raise NotADirectoryError(f"{one_line(path)} is a file, not a folder: give another name")
    if path.is_dir() and any(path.iterdir()):
        raise FileExistsError(f"{one_line(path)} is not empty: give the name of a new folder")
    return path


def write_npz(folder: str | PathLike[str], columns: Columns, options: tuple[str, ...]) -> None:
    """Write a file for each case into a new folder: all, or none."""
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
