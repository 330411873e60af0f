"""The command ``robsim bench``: timings beside OpenCV and numpy."""

from __future__ import annotations

import dataclasses
from typing import Annotated

import typer

from robsim._base.report import Report
from robsim.cli import errors
from robsim.cli.shared import SWITCH, Json
from robsim.cli.text import whole_number

EXAMPLE = "Example: robsim bench"
HELP = (
    "Measure how fast robsim is on this machine.\n\n"
    "The alternatives, OpenCV and numpy, are timed in the same run on the same frames. OpenCV must "
    "be installed.\n\n"
    "With --panel: how many different frames of a panel Chromium paints in a second, how long "
    "after their step, and what that costs, beside matplotlib. It takes half a minute.\n\n"
    "With --camera: the way of a frame from the bytes that a FireWire or GigE camera sends to the "
    "pose of the robot, for each way in which cameras send pixels, beside OpenCV; and what a "
    "process takes that reads a live one, simulated, and finds the robot in each frame."
)


def bench(
    rounds: Annotated[
        int,
        typer.Option(
            "--rounds",
            parser=whole_number,
            metavar="N",
            help="Number of timings of each case; the median is reported.",
        ),
    ] = 25,
    panel: Annotated[
        bool,
        typer.Option(
            "--panel",
            metavar=SWITCH,
            help="Measure the panel instead, in Chromium; pip install playwright.",
        ),
    ] = False,
    camera: Annotated[
        bool,
        typer.Option(
            "--camera",
            metavar=SWITCH,
            help="Measure what a live camera's frames take instead, by how it sends pixels.",
        ),
    ] = False,
    as_json: Json = False,
) -> None:
    """Measure how fast robsim is on this machine."""
    with errors.report_errors():
        if panel and camera:
            raise ValueError("--panel and --camera are two benchmarks: give one of them")
        if panel:
            result = _measured_panel()
        else:
            result = _measured_camera(rounds) if camera else _measured_core(rounds)
    errors.show(result.to_json() if as_json else result)


def _measured_core(rounds: int) -> Report:
    from robsim.bench import run_bench

    return run_bench(rounds=rounds)


def _measured_camera(rounds: int) -> Report:
    from robsim.bench._camera import run_camera_bench
    from robsim.bench._camera_result import Live
    from robsim.live._bench.serving import read_live_cameras

    converted = run_camera_bench(rounds=rounds)
    live = read_live_cameras()
    return dataclasses.replace(
        converted,
        live=tuple(Live(**row) for row in live.rows),
        left_out=tuple(live.left_out),
    )


def _measured_panel() -> Report:
    from robsim.gui._bench.run import run_panel_bench

    return run_panel_bench()
