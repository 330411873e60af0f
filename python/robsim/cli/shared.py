"""Options that several commands share, such as --robot, --colors and --noise."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Robot = Annotated[
    str | None,
    typer.Option("--robot", help="Name or folder of the robot. Default: the default robot."),
]
Colors = Annotated[
    Path | None, typer.Option("--colors", help="Colour file. Default: the shipped one.")
]
Smoothing = Annotated[
    int | None,
    typer.Option(
        "--smoothing",
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
Json = Annotated[bool, typer.Option("--json", help="Print only the numbers, as JSON.")]
