"""Options that several commands share, such as --robot, --colors and --noise."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from robsim.cli.text import whole_number

#: A switch has no value: in place of its type, --help shows nothing.
SWITCH = ""

Robot = Annotated[
    str | None,
    typer.Option(
        "--robot",
        metavar="NAME|FOLDER",
        help="Name or folder of the robot. Default: the one chosen with robsim robots use.",
    ),
]
Colors = Annotated[
    Path | None,
    typer.Option("--colors", metavar="FILE", help="Colour file. Default: the shipped one."),
]
Smoothing = Annotated[
    int | None,
    typer.Option(
        "--smoothing",
        parser=whole_number,
        metavar="PX",
        help="Width of the averaging window in px: 3, 5, ... 15; 1 = off. Default: by the markers.",
    ),
]
Noise = Annotated[
    str | None,
    typer.Option(
        "--noise",
        metavar="KIND:PERCENT",
        help="Camera noise, such as gaussian:10 or uniform:10.",
    ),
]
Seed = Annotated[
    int | None,
    typer.Option(
        "--seed",
        parser=whole_number,
        metavar="N",
        help="Seed of the random numbers: the same one gives the same results. Default: another "
        "one each time.",
    ),
]
Json = Annotated[
    bool, typer.Option("--json", metavar=SWITCH, help="Print only the numbers, as JSON.")
]


def earlier_run(out: Path) -> str | None:
    """Return the remark that a folder's results of an earlier run are replaced, or None."""
    if (out / "trace.npz").exists():
        return f"the earlier run in {out} is replaced; --out gives another folder"
    return None
