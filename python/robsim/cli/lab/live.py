"""The command ``robsim live``: a robot under a real camera, or the check that all is ready."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from robsim._core import MotorLink
from robsim.cli import errors, shared
from robsim.cli.outcome import finish
from robsim.cli.text import about, parse_control, parse_size
from robsim.lab.cameras.camera import Camera

# Safe limits for a robot of unknown strength.
_VOLTAGE = 1.5  # V
_SLEW_RATE = 10.0  # V/s


def live(
    folder: shared.Callbacks = None,
    camera: str | None = None,
    motors: str | None = None,
    check: bool = False,
    control: str | None = None,
    steps: int | None = None,
    seconds: float | None = None,
    max_voltage: float = _VOLTAGE,
    slew_rate: float = _SLEW_RATE,
    robot: shared.Robot = None,
    colors: shared.Colors = None,
    smoothing: shared.Smoothing = None,
    area: shared.Area = None,
    pixels: shared.Pixels = None,
    positions: shared.Positions = None,
    calibration: shared.CalibrationFile = None,
    fps: float | None = None,
    every: int | None = None,
    dt: float | None = None,
    frame_timeout: float | None = None,
    time_limit: shared.CallLimit = None,
    out: shared.Out = Path("robsim-live"),
    record: bool | None = None,
    lossless: bool = False,
    unit: shared.Unit = "px",
    scale: shared.Scale = None,
    as_json: shared.Json = False,
) -> None:
    """Drive a robot under a real camera.

    Try it without hardware: --camera simulated is a simulated lab in real time. Before a real robot
    drives, use --check. The robot stops at the end, after Ctrl-C, after an error in a callback, and
    when a frame is late; the results are kept. If neither the folder nor --control gives a
    controller, the command only measures the robot.

    --camera SOURCE: The number of a camera (such as 0), an address (such as firewire://,
        gige://192.168.1.20 or http://camera.local/video.mjpg), a video file or a folder of images
        (played at its own rate), or simulated.
    --motors LINE: Line to the robot: udp:HOST:PORT, serial:PORT or serial:PORT@BAUD. For the
        simulated lab, the default is simulated. All other cameras have the default none, which
        sends no inputs.
    --check: Only measure the standing robot for 3 s, and report whether the camera is good enough.
        The exit status is 1 for a bad camera.
    --control NAME[:POINTS]: A built-in controller, which replaces the controller of the folder, as
        in robsim run.
    --steps N: Number of steps. Default: until Ctrl-C, or the end of a file.
    --seconds S: Duration in s, instead of --steps.
    --max-voltage V: Largest voltage of a motor in V.
    --slew-rate V/S: Largest change of a voltage in V/s.
    --fps RATE: Frames per second. A camera with a number, on FireWire or on GigE is set to this
        rate. For other addresses, give the real rate of the camera. A folder is played at this
        rate.
    --every N: Use only every n-th frame. Default: 1, or the number that fits the dt of
        define_model.py.
    --dt SECONDS: Time between two frames in s, instead of --fps.
    --frame-timeout SECONDS: The robot stops after this time without a new frame. Default: the time
        of three frames, but at least 0.1 s, and up to 0.3 s for frames with much jitter.
    --record/--no-record: Record frames and inputs in a session in the folder --out, for replay.
        Default: yes, except for a file.
    --lossless: Record the frames with a lossless codec.

    Example: robsim live --camera simulated --control go-to-point:900,300 --seconds 15
    """
    from robsim._core import Limits
    from robsim.cli.lab.driving import LiveRun, step_of_model
    from robsim.cli.results import check_folder
    from robsim.cli.sources import opened, rate_of
    from robsim.simulation.options import step_count

    with errors.report_errors(folder), _stops_at_signals():
        if folder is not None and not folder.is_dir():
            raise FileNotFoundError(f"there is no folder {folder}: robsim new {folder} creates it")
        if steps is not None and seconds is not None:
            raise ValueError("--steps and --seconds both end the run: give only one of them")
        if seconds is not None and not 0 < seconds < float("inf"):
            raise ValueError(f"--seconds must be > 0, got {seconds:g}")
        with about("--max-voltage", "voltage"):
            limits = Limits(voltage=max_voltage, slew_rate=slew_rate)
        steps = None if steps is None else step_count(steps)
        controller = parse_control("--control", control)
        check_folder(out)
        shared.check_unit(unit, scale, calibration)
        line = opened(
            camera,
            motors,
            robot=robot,
            area=parse_size("--area", area),
            plane_map=shared.parse_plane_map(pixels, positions),
            calibration=calibration,
            fps=rate_of(fps, dt),
            every=every,
            model_dt=step_of_model(folder),
        )
        if check:
            with line as (device, link):
                check_and_report(
                    device, link, out, as_json, robot=robot, colors=colors, smoothing=smoothing
                )
            return
        session = _session(out, record, camera or "")
        run = LiveRun(steps=steps, seconds=seconds, limits=limits, frame_timeout=frame_timeout)
        options = {
            "robot": robot,
            "colors": colors,
            "smoothing": smoothing,
            "time_limit": time_limit,
            "record": session,
            "lossless": lossless and session is not None,
            "control": controller,
        }
        run.drive(line, folder, {name: one for name, one in options.items() if one is not None})
    if run.experiment is not None:
        finish(run.experiment, out, as_json=as_json, more=run.reports, unit=unit, scale=scale)
        if session is not None and session.exists():
            errors.print_note(f"the session is in {session}; with other callbacks, in Python:")
            errors.print_note(f"  {_replay(session, folder)}")
    if run.failure is not None:
        with errors.report_errors(folder):
            raise run.failure


@contextmanager
def _stops_at_signals() -> Iterator[None]:
    """End a run after the terminal closes, or after SIGTERM, as after Ctrl-C."""
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {name: signal.getsignal(getattr(signal, name)) for name in names}
    for name in names:
        signal.signal(getattr(signal, name), signal.default_int_handler)
    try:
        yield
    finally:
        for name, handler in before.items():
            signal.signal(getattr(signal, name), handler)


def _session(out: Path, record: bool | None, camera: str) -> Path | None:
    """Return a new file for the session; None = not recorded."""
    from robsim.vision.imaging.video import load_opencv

    if record is False or (record is None and Path(camera).exists()):
        return None
    try:
        load_opencv("recording a session")
    except ImportError as error:
        if record:
            raise
        errors.print_note(f"not recorded: {error}")
        return None
    number = 1
    while any((out / f"session-{number}{end}").exists() for end in ("", ".mcap")):
        number += 1
    return out / f"session-{number}.mcap"


def _replay(session: Path, folder: Path | None) -> str:
    """Return the line of Python that reruns a session."""
    frames = f"robsim.trace.Session({str(session)!r})"
    if folder is None:
        return f"robsim.Experiment({frames}, control=...).run()"
    return f"robsim.Experiment.from_folder({str(folder)!r}, frames={frames}).run()"


_SECONDS = 3.0
_PICTURE = "check.png"


def check_and_report(
    camera: Camera, motors: MotorLink | None, out: Path, as_json: bool, **options: Any
) -> None:
    """Check a camera, print and draw the findings; exit with 1 if it is bad."""
    from robsim import plotting
    from robsim.cli.results import save_figure
    from robsim.lab.rehearsal.camera_check import check_camera

    errors.print_note(f"checking for {_SECONDS:g} s; the robot must stand, and gets no inputs")
    check = check_camera(camera, motors=motors, seconds=_SECONDS, **options)
    out.mkdir(parents=True, exist_ok=True)
    picture = out / _PICTURE
    save_figure(picture, plotting.plot_camera_check(check))
    errors.show(check.to_json() if as_json else check)
    if not as_json:
        errors.say(f"written: {picture}")
    if not check.ok:
        raise typer.Exit(1)
