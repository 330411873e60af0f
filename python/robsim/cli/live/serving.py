"""The command ``robsim serve``: the simulated lab as a camera that other programs open."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Annotated

import typer

from robsim.cli import errors
from robsim.cli.shared import SWITCH, Pixels, Positions, Robot, WorkArea, parse_plane_map
from robsim.cli.text import about, number, parse_size, whole_number

if TYPE_CHECKING:
    from robsim.live import GigeServer, SimulatedLab

#: What stands after COMMAND is for the command, options as well.
SETTINGS = {"allow_interspersed_args": False}
EXAMPLE = (
    "Example: robsim serve --firewire robsim live --camera firewire:// --area 1200x1200 --check"
)
HELP = (
    "--gige: as a GigE Vision camera, which any viewer on the network can open, and robsim live "
    "--camera gige://ADDRESS. It goes on until Ctrl-C.\n\n"
    "--firewire: as a FireWire camera for COMMAND, which is run and sees it: robsim, or another "
    "program that reads FireWire by libdc1394. It goes on until COMMAND ends, and the exit code is "
    "that of COMMAND. Options of robsim serve stand before COMMAND. Linux only; no FireWire card "
    "is needed, and no rights.\n\n"
    "The robot hears commands as a real one does, by UDP: where is said at the start, or chosen "
    "with --motor-port 5005, for robsim live --motors udp:127.0.0.1:5005."
)

_LOOK = 0.2  # s
_FIRE_WIRE_STEPS = 8, 2  # px, of the size of its frames
_FIRE_WIRE_RATE = 30.0  # frames/s


def serve(
    arguments: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="COMMAND",
            help="With --firewire: the command that sees the camera, with its own options.",
        ),
    ] = None,
    gige: Annotated[
        bool, typer.Option("--gige", metavar=SWITCH, help="As a GigE Vision camera, by Aravis.")
    ] = False,
    firewire: Annotated[
        bool,
        typer.Option("--firewire", metavar=SWITCH, help="As a FireWire camera for COMMAND."),
    ] = False,
    address: Annotated[
        str | None,
        typer.Option(
            "--address",
            metavar="ADDRESS",
            help="With --gige: IPv4 address of this computer, where the camera is reached. "
            "Default: from this computer alone.",
        ),
    ] = None,
    serial: Annotated[
        str | None,
        typer.Option(
            "--serial", metavar="TEXT", help="With --gige: its serial number. Default: ROBSIM-1."
        ),
    ] = None,
    motor_port: Annotated[
        int | None,
        typer.Option(
            "--motor-port",
            parser=whole_number,
            metavar="PORT",
            help="Port of UDP where the robot hears commands. Default: one that is free.",
        ),
    ] = None,
    robot: Robot = None,
    area: WorkArea = None,
    pixels: Pixels = None,
    positions: Positions = None,
    fps: Annotated[
        float | None,
        typer.Option(
            "--fps",
            parser=number,
            metavar="RATE",
            help="Frames per second. Default: 20; with --firewire 30.",
        ),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            "--seconds",
            parser=number,
            metavar="S",
            help="With --gige: duration in s. Default: until Ctrl-C.",
        ),
    ] = None,
) -> None:
    """Serve the simulated lab as a camera."""
    from robsim.cli.live import serving_bus
    from robsim.cli.live.sources import new_lab, rate_of
    from robsim.motors import MotorReceiver

    with errors.report_errors():
        _check_kind(gige, firewire, arguments)
        if firewire:
            _refuse_of_gige({"--address": address, "--serial": serial, "--seconds": seconds})
            program = serving_bus.program_of(arguments or [])
        if seconds is not None and not 0 < seconds < float("inf"):
            raise ValueError(f"--seconds must be > 0, got {seconds:g}")
        with about("--motor-port"):
            receiver = None if motor_port is None else MotorReceiver(_port(motor_port))
        lab = new_lab(
            robot,
            parse_size("--area", area),
            parse_plane_map(pixels, positions),
            rate_of(_FIRE_WIRE_RATE if firewire and fps is None else fps, None),
            steps=_FIRE_WIRE_STEPS if firewire else (1, 1),
            receiver=receiver,
        )
        with lab:
            if not firewire:
                _serve_gige(lab, address or "127.0.0.1", serial or "ROBSIM-1", seconds)
                return
            code = serving_bus.run_on_bus(program, lab)
    raise typer.Exit(code)


def _check_kind(gige: bool, firewire: bool, arguments: list[str] | None) -> None:
    """Raise ValueError unless it is clear as what the lab is served, and to whom."""
    if gige == firewire:
        raise ValueError(
            "--gige and --firewire exclude each other: give one of them"
            if gige
            else "--gige or --firewire COMMAND is missing: it says as what the lab is served"
        )
    if gige and arguments:
        raise ValueError(f"COMMAND is for --firewire: with --gige, start {arguments[0]} by itself")
    if firewire and not arguments:
        raise ValueError(
            "COMMAND is missing: a FireWire camera that is simulated is seen only by the command "
            "that is run with it, such as robsim serve --firewire robsim cameras"
        )


def _refuse_of_gige(options: dict[str, str | float | None]) -> None:
    for option, value in options.items():
        if value is not None:
            raise ValueError(f"{option} is for --gige: with --firewire, leave it out")


def _port(port: int) -> int:
    if not 1 <= port <= 65535:
        raise ValueError(f"motor_port must be from 1 to 65535, got {port}")
    return port


def _serve_gige(lab: SimulatedLab, address: str, serial: str, seconds: float | None) -> None:
    from robsim.live import GigeServer

    with about("--address"), GigeServer(lab, address=address, serial=serial) as server:
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
