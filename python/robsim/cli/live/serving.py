"""The command ``robsim serve``: the simulated lab as a camera that other programs open."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from robsim.cli import errors
from robsim.cli.shared import SWITCH, Area, Pixels, Positions, Robot, parse_plane_map
from robsim.cli.text import about, number, parse_size

if TYPE_CHECKING:
    from robsim.live import GigeServer

EXAMPLE = "Example: robsim serve --gige"
HELP = (
    "Serve the simulated lab as a GigE Vision camera.\n\n"
    "Any viewer can open it, and robsim live --camera gige://ADDRESS. The robot hears commands as "
    "a real one does, by UDP. It goes on until Ctrl-C."
)

_LOOK = 0.2  # s


def serve(
    gige: Annotated[
        bool, typer.Option("--gige", metavar=SWITCH, help="As a GigE Vision camera, by Aravis.")
    ] = False,
    address: Annotated[
        str,
        typer.Option(
            "--address",
            metavar="ADDRESS",
            help="IPv4 address of this computer, where the camera is reached. Default: from this "
            "computer alone.",
        ),
    ] = "127.0.0.1",
    serial: Annotated[
        str, typer.Option("--serial", metavar="TEXT", help="Its serial number.")
    ] = "ROBSIM-1",
    robot: Robot = None,
    area: Area = None,
    pixels: Pixels = None,
    positions: Positions = None,
    fps: Annotated[
        float | None,
        typer.Option("--fps", parser=number, metavar="RATE", help="Frames per second."),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds", parser=number, metavar="S", help="Duration in s. Default: until Ctrl-C."
        ),
    ] = None,
) -> None:
    """Serve the simulated lab as a camera."""
    from robsim.cli.live.sources import new_lab, rate_of
    from robsim.live import GigeServer

    with errors.report_errors():
        if not gige:
            raise ValueError("--gige is missing: it says as what the lab is served")
        if seconds is not None and not 0 < seconds < float("inf"):
            raise ValueError(f"--seconds must be > 0, got {seconds:g}")
        lab = new_lab(
            robot,
            parse_size("--area", area),
            parse_plane_map(pixels, positions),
            rate_of(fps, None),
        )
        with lab, about("--address"), GigeServer(lab, address=address, serial=serial) as server:
            _tell(server)
            _wait(server, seconds)
        errors.say(f"{server.sent_frames} frames were sent")


def _tell(server: GigeServer) -> None:
    lab = server.lab
    (width, height), (across, down) = lab.size, lab.area
    errors.say(
        f"camera: {server.url}, serial number {server.serial}, {width} x {height} px, "
        f"{1 / lab.dt:g} frames/s"
    )
    errors.say(f"motors: udp:{lab.address}")
    errors.print_note(
        f"robsim live --camera {server.url} --motors udp:{lab.address} --area {across}x{down} "
        f"--fps {1 / lab.dt:g}"
    )
    errors.print_note("Ctrl-C ends it")


def _wait(server: GigeServer, seconds: float | None) -> None:
    end = None if seconds is None else time.monotonic() + seconds
    try:
        while end is None or time.monotonic() < end:
            time.sleep(_LOOK)
            if server.failure is not None:
                raise OSError(server.failure)
    except KeyboardInterrupt:
        return
