"""Options that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Robot = Annotated[
    str | None, typer.Option("--robot", help="Name or folder. Default: the one in use.")
]
Colors = Annotated[
    Path | None, typer.Option("--colors", help="Colour file. Default: the shipped one.")
]
Smoothing = Annotated[
    int | None,
    typer.Option(
        "--smoothing",
        help="Window against noise in px: 3, 5, ... 15; 1 = off. Default: by the marker's size.",
    ),
]
Noise = Annotated[
    str | None,
    typer.Option(
        "--noise",
        metavar="KIND:PERCENT",
        help="Noise of the camera, such as gaussian:10 or uniform:10.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the numbers as JSON, and nothing else.")]
