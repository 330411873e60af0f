"""The command ``robsim bench``."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from robsim.cli import errors
from robsim.cli.shared import Json

EXAMPLE = "Example: robsim bench"
HELP = (
    "Measure how fast robsim is on this machine.\n\n"
    "Beside it, in the same run and on the same frames, what one would take instead: OpenCV and "
    "numpy. OpenCV must be installed."
)


def bench(
    rounds: Annotated[
        int, typer.Option("--rounds", min=1, help="How often each is timed; the median counts.")
    ] = 25,
    as_json: Json = False,
) -> None:
    """Measure how fast robsim is on this machine."""
    from robsim.bench import run_bench

    with errors.report_errors():
        result = run_bench(rounds=rounds)
    print(json.dumps(result.to_dict(), indent=2) if as_json else result)
