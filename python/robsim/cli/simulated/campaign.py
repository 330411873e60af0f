"""The command ``robsim campaign``: many runs over seeds and options."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from robsim.cli import errors
from robsim.cli.results import check_file, check_folder
from robsim.cli.shared import Jobs, Json, engine_of

if TYPE_CHECKING:
    from robsim.campaigns import CampaignResult


def campaign(
    file: Path | None = None,
    example: Path | None = None,
    runs: int | None = None,
    jobs: Jobs = 1,
    store: Path | None = None,
    by: list[str] | None = None,
    csv: Path | None = None,
    parquet: Path | None = None,
    npz: Path | None = None,
    as_json: Json = False,
) -> None:
    """Run a simulation many times, over seeds and options, and compare the means.

    The file describes the runs: --example writes an example to edit. For each number, the table
    shows the mean with a confidence interval, and the difference from the first case. It also shows
    the number of further runs that would decide whether the difference is real.

    With --store, the same command continues an interrupted campaign, and a command with more --runs
    adds rows. Any SQLite program can read the file: the view results has all rows.

    A failed run gives a row with the error. The exit status is 1 if all runs failed.

    FILE: The campaign, a TOML file.
    --example FILE: Write an example to a file, and stop.
    --runs N: Number of runs of each case. Default: the number in the file.
    --store FILE: SQLite file that keeps the rows.
    --by OPTION: Compare the values of this option. Can be repeated.
    --csv FILE: Write all rows to a CSV file.
    --parquet FILE: Write all rows to a Parquet file.
    --npz FOLDER: Write a file for each case, readable with numpy.

    Example: robsim campaign --example noise.toml
    """
    if (file is None) == (example is None):
        raise ValueError("give the FILE of a campaign, or --example FILE to write one")
    if example is not None:
        _write_example(example)
        return
    assert file is not None
    _check_exports(csv=csv, parquet=parquet, npz=npz)
    result = _result(file, runs=runs, jobs=jobs, store=store)
    summary = result.summary(by or None)
    if csv is not None:
        result.to_csv(csv)
    if parquet is not None:
        result.to_parquet(parquet)
    if npz is not None:
        result.to_npz(npz)
    if as_json:
        record = {
            "cases": len(result.spec.cases),
            "runs": result.spec.runs,
            "failed": int(result.failed.sum()),
            "first_error": summary.first_error or None,
            "checksum": result.checksum,
            "summary": summary.to_dict(),
        }
        errors.show(json.dumps(record, indent=2))
    else:
        errors.show(result.line)
        errors.show(summary)
        for written in (csv, parquet, npz):
            if written is not None:
                errors.say(f"rows written to {written}")
        if store is not None:
            errors.say(f"store written to {store}")
    if result.failed.all():
        raise typer.Exit(1)


def _check_exports(*, csv: Path | None, parquet: Path | None, npz: Path | None) -> None:
    """Raise the errors of unwritable outputs before the long work."""
    from robsim.campaigns.result import check_exports

    for file in (csv, parquet):
        if file is not None:
            check_file(file)
    check_exports(parquet=parquet is not None, npz=npz)
    if npz is not None:
        check_folder(npz)


def _write_example(file: Path) -> None:
    from robsim.base.files import write_whole
    from robsim.campaigns.spec_file import EXAMPLE as CONTENT

    if file.exists():
        raise FileExistsError(f"{file} exists: use another name")
    write_whole(file, CONTENT.encode())
    errors.say(f"written to {file}: edit it, then run it: robsim campaign {file}")


def _result(file: Path, *, runs: int | None, jobs: int, store: Path | None) -> CampaignResult:
    from robsim.campaigns.launch import run_spec
    from robsim.campaigns.spec_file import load_spec

    executor = engine_of(jobs)
    spec = load_spec(file, runs=runs)
    try:
        return run_spec(spec, executor=executor, store=store, progress=True)
    except KeyboardInterrupt as stop:
        for note in stop.__notes__:
            errors.print_note(note)
        raise
