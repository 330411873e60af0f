"""The command ``robsim bench``: timings beside those of OpenCV and numpy."""

from __future__ import annotations

from typing import Annotated

from robsim.cli import errors
from robsim.cli.option import integer_option
from robsim.cli.shared import Json

EXAMPLE = "Example: robsim bench"
HELP = (
    "The alternatives, OpenCV and numpy, are timed in the same run on the same frames. OpenCV must "
    "be installed."
)
_ROUNDS = 25


def bench(
    rounds: Annotated[
        int,
        integer_option("--rounds", "N", "Number of timings of each case; the median is reported."),
    ] = _ROUNDS,
    as_json: Json = False,
) -> None:
    """Measure how fast robsim is on this machine."""
    from robsim.cli.simulated.bench_table import run_bench

    with errors.report_errors():
        result = run_bench(rounds=rounds)
    errors.show(result.to_json() if as_json else result)
