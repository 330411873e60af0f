"""The camera and the motors of a live run, and the command ``robsim cameras``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from robsim._core import MotorLink, PlaneMap
from robsim.base.checks import check_float
from robsim.base.spelling import suggestion
from robsim.base.text import quoted
from robsim.cli import errors
from robsim.cli.shared import Json
from robsim.cli.text import about
from robsim.lab.cameras.camera import Camera
from robsim.lab.cameras.sources import meant_address
from robsim.lab.motors.lines import SerialMotors, UdpMotors
from robsim.lab.rehearsal.lab import SimulatedLab
from robsim.simulation import Scenario
from robsim.simulation.frame_source import DT_TOLERANCE

SIMULATED, NONE = "simulated", "none"
LAB_RATE = 20.0  # frames/s, of the simulated lab
_LAB_SIZE = 640  # px, the longer side of its frames
_CAMERAS = (
    "0 (the number of a camera), an address such as firewire://, gige://192.168.1.20 or "
    f"http://camera.local/video.mjpg, a file, a folder, or {SIMULATED}"
)
_MOTORS = f"udp:HOST:PORT, serial:PORT, serial:PORT@BAUD, {SIMULATED} or {NONE}"


@contextmanager
def opened(
    camera: str | None,
    motors: str | None,
    *,
    robot: str | None,
    area: tuple[int, int] | None,
    plane_map: PlaneMap | None,
    calibration: Path | None,
    fps: float | None,
    every: int | None,
    model_dt: float | None,
) -> Iterator[tuple[Camera, MotorLink | None]]:
    """Open a camera and the line to the robot; finally stop the robot, and close both.

    A `model_dt` is the required time step of the frames (s). A missing `every` follows from the
    rate, if the rate is known before the camera is open.
    """
    if camera is None:
        raise ValueError(
            f"--camera is missing: give {_CAMERAS} for a rehearsal; `robsim cameras` lists all "
            "cameras"
        )
    check_motors(camera, motors)
    with ExitStack() as stack:
        lab = None
        if camera == SIMULATED:
            lab = stack.enter_context(_new_lab(robot, area, plane_map, fps))
        source = lab or _source(camera)
        is_asked = lab is None and fps is not None
        with about("--camera" if calibration is None else "--camera or --calibration"):
            device = Camera(
                source,
                plane_map=plane_map,
                calibration=calibration,
                area=area,
                fps=fps if is_asked else None,
                every=every or _every(LAB_RATE if lab and fps is None else fps, model_dt),
            )
        _check_step(device, model_dt, every)
        yield stack.enter_context(device), _line(stack, motors, lab)


def _every(rate: float | None, model_dt: float | None) -> int:
    """Return the number of frames in a step of the model; 1 if unknown."""
    return 1 if rate is None or model_dt is None else max(round(rate * model_dt), 1)


def _check_step(camera: Camera, model_dt: float | None, every: int | None) -> None:
    """Raise ValueError if the frames do not match the steps of the model."""
    if camera.dt is None or model_dt is None:
        return
    if not math.isclose(camera.dt, model_dt, rel_tol=DT_TOLERANCE):
        taken = f"with --every {every}, frames come" if every else "frames come"
        frames = model_dt / (camera.dt / (every or 1))
        remedy = f", or --every {frames:.0f}" if frames > 1 and abs(frames % 1) < 0.01 else ""
        raise ValueError(
            f"--camera {camera.source}: {taken} {camera.dt:.3g} s apart, but the model of "
            f"define_model.py has steps of {model_dt:.3g} s: set dt={camera.dt:.3g} in "
            f"define_model.py{remedy}"
        )


def _new_lab(
    robot: str | None, area: tuple[int, int] | None, plane_map: PlaneMap | None, fps: float | None
) -> SimulatedLab:
    width, height = area or Scenario.area
    scale = _LAB_SIZE / max(width, height, 1)  # the scenario refuses a size of 0
    scenario = Scenario(
        robot=robot,
        area=(width, height),
        resolution=(max(round(scale * width), 16), max(round(scale * height), 16)),
        headings=None,
    )
    return SimulatedLab(scenario, fps=LAB_RATE if fps is None else fps, plane_map=plane_map)


def _source(text: str) -> int | str:
    """Return the argument for a camera: a number, an address, or a path."""
    if re.fullmatch(r"\d{1,2}", text):
        return int(text)
    is_address = re.match(r"[a-z][a-z0-9+.-]+://", text)
    if not is_address and not Path(text).exists():
        meant = meant_address(text)
        hint = f"; did you mean {meant}?" if meant else suggestion(text, [SIMULATED])
        raise ValueError(f"--camera must be {_CAMERAS}; there is no file {quoted(text)}{hint}")
    return text


def check_motors(camera: str, motors: str | None) -> None:
    """Raise ValueError if the text of --motors is invalid."""
    if motors in (None, NONE) or re.fullmatch(r"udp:.+:\d+|serial:[^@]+(@\d+)?", motors):
        return
    if motors != SIMULATED:
        hint = ""
        if re.fullmatch(r"(udp://)?[\w.-]+:\d+", motors):
            hint = f"; did you mean udp:{motors.removeprefix('udp://')}?"
        elif re.match(r"/dev/\w+$", motors):
            hint = f"; did you mean serial:{motors}?"
        raise ValueError(f"--motors must be {_MOTORS}, got {quoted(motors)}{hint}")
    if camera != SIMULATED:
        raise ValueError(
            f"--motors {SIMULATED} needs --camera {SIMULATED}: with another camera, give "
            f"udp:HOST:PORT, serial:PORT or {NONE}"
        )


def _line(stack: ExitStack, text: str | None, lab: SimulatedLab | None) -> MotorLink | None:
    if text == NONE or (text is None and lab is None):
        return None
    motors: Any
    with about("--motors"):
        if text is None or text == SIMULATED:
            assert lab is not None  # of `check_motors`
            motors = UdpMotors(lab.address)
        elif text.startswith("udp:"):
            motors = UdpMotors(text.removeprefix("udp:"))
        else:
            port, _, baud_rate = text.removeprefix("serial:").partition("@")
            motors = SerialMotors(port, int(baud_rate)) if baud_rate else SerialMotors(port)
    link: MotorLink = stack.enter_context(motors)
    return link


def rate_of(fps: float | None, dt: float | None) -> float | None:
    """Return the rate from --fps or --dt (frames/s)."""
    if fps is not None and dt is not None:
        raise ValueError("--fps and --dt both set the rate: give only one of them")
    if dt is not None:
        return 1 / check_float("--dt", dt, "s", minimum=1e-3, maximum=3600)
    return fps if fps is None else check_float("--fps", fps, "1/s", minimum=0.1, maximum=1000)


def cameras(network: bool = False, as_json: Json = False) -> None:
    """List the cameras of this computer, and why others are missing.

    The list shows the argument of robsim.Camera for each camera. No camera is opened.

    --network: Also search the network for GigE Vision cameras, for 1 s.

    Example: robsim cameras
    """
    from robsim.lab.cameras.finding import find_cameras

    report = find_cameras(network=network)
    if as_json:
        errors.show(report.to_json())
        return
    for sentence in report.found:
        errors.say(f"found: {sentence}")
    for sentence in report.missing:
        errors.say(f"missing: {sentence}")
