"""The command ``robsim track``: tracks the robot in a video or a folder of images."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from robsim._core import Frame
from robsim.cli import errors, shared
from robsim.cli.outcome import finish, write_with_progress
from robsim.cli.text import parse_size

if TYPE_CHECKING:
    from robsim.simulation import Experiment
    from robsim.trace import Trace
    from robsim.vision.imaging.recordings import Recording

VIDEO = "tracked.mp4"


def track(
    source: Path,
    robot: shared.Robot = None,
    colors: shared.Colors = None,
    smoothing: shared.Smoothing = None,
    area: shared.Area = None,
    pixels: shared.Pixels = None,
    positions: shared.Positions = None,
    calibration: shared.CalibrationFile = None,
    dt: float | None = None,
    out: shared.Out = Path("robsim-track"),
    video: bool = True,
    unit: shared.Unit = "px",
    scale: shared.Scale = None,
    as_json: shared.Json = False,
) -> None:
    """Track the robot in a video file or a folder of images.

    The command writes the trace, the figures and an annotated video. For a camera that views the
    floor obliquely, give four or more points of known position. The exit status is 1 if the robot
    was never seen.

    SOURCE: Video file, or folder of images.
    --dt SECONDS: Time between two frames in s. Default: the times in the video, or 0.2 for images.
    --video/--no-video: Also write the annotated video, tracked.mp4.

    Example: robsim track run.mkv --area 1200x1200 --out tracked
    """
    from robsim.cli.results import check_folder
    from robsim.simulation import Experiment
    from robsim.vision.imaging.recordings import Recording

    check_folder(out)
    shared.check_unit(unit, scale, calibration)
    if out.resolve() == source.resolve() or (out / VIDEO).resolve() == source.resolve():
        raise ValueError(f"--out {out} would overwrite {source}: use another folder")
    plane_map = shared.parse_plane_map(pixels, positions)
    recording = Recording(
        source, plane_map=plane_map, area=parse_size("--area", area), dt=dt, calibration=calibration
    )
    experiment = Experiment(recording, robot=robot, colors=colors, smoothing=smoothing)
    failure = None
    try:
        experiment.run(progress=True)
    except KeyboardInterrupt:
        errors.print_note(f"stopped after {len(experiment.trace)} frames")
    except Exception as error:
        failure = error
    if count := len(experiment.trace):
        finish(experiment, out, as_json=as_json, unit=unit, scale=scale)
        known = experiment.robot
        roles = (f"{role} marker {one}" for role, one in known.marker_layout().colors.items())
        errors.print_note(
            f"tracked as robot {known.name} ({', '.join(roles)}): heading, centre and reported "
            "errors are true only for this robot; another one needs its own definition (robsim "
            "robots add) and --robot"
        )
        if video:
            trace = experiment.trace.in_unit(unit, mm_per_px=scale)
            _write_video(experiment, trace, recording, out / VIDEO)
        if failure is not None:
            errors.print_note(f"the {count} frames before the error are tracked")
    if failure is not None:
        raise failure
    if count and not experiment.trace.seen.any():
        raise typer.Exit(1)


def _write_video(experiment: Experiment, trace: Trace, recording: Recording, file: Path) -> None:
    from robsim.plotting.images.replay import annotated_frames
    from robsim.vision.imaging.video import load_av

    try:
        load_av("writing a video")
    except ImportError as error:
        errors.print_note(f"no {file.name}: {error}")
        return
    frames = (one if isinstance(one, Frame) else None for one in recording._each())
    shown = annotated_frames(frames, trace, simulation=experiment)
    write_with_progress(file, shown, trace)
