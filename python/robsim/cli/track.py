"""The commands ``robsim track`` and ``robsim cameras``: frames that are not drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from robsim.cli import errors
from robsim.cli.outcome import finish, write_with_progress
from robsim.cli.shared import SWITCH, Colors, Json, Robot, Smoothing, earlier_run
from robsim.cli.text import Points, number, parse_points, parse_size

if TYPE_CHECKING:
    from robsim._core import PlaneMap
    from robsim.imaging._recordings import Recording
    from robsim.simulation import Experiment

VIDEO = "tracked.mp4"
EXAMPLE = "Example: robsim track run.mkv --area 1200x1200 --out tracked"
HELP = (
    "Track the robot in a video file or a folder of images.\n\n"
    "Writes the trace, the figures and an annotated video. For a camera that views the floor "
    "obliquely, give four or more points whose positions are known."
)

CAMERAS_EXAMPLE = "Example: robsim cameras"
CAMERAS_HELP = (
    "List the cameras of this computer, what is missing, and why.\n\n"
    "Each with what to give robsim.Camera. None of them is opened."
)


def cameras(as_json: Json = False) -> None:
    """List the cameras of this computer, what is missing, and why."""
    from robsim.capture import find_cameras

    with errors.report_errors():
        report = find_cameras()
    if as_json:
        errors.show(report.to_json())
        return
    for sentence in report.found:
        errors.say(f"found: {sentence}")
    for sentence in report.missing:
        errors.say(f"missing: {sentence}")


def track(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="Video file, or folder of images.")
    ],
    robot: Robot = None,
    colors: Colors = None,
    smoothing: Smoothing = None,
    area: Annotated[
        str | None,
        typer.Option(
            "--area", metavar="WxH", help="Work area in px. Default: the size of the frames."
        ),
    ] = None,
    pixels: Annotated[
        str | None,
        typer.Option(
            "--pixels",
            metavar="POINTS",
            help="Four or more points in the frames, in px, such as '0,0 639,0 639,479 0,479'.",
        ),
    ] = None,
    positions: Annotated[
        str | None,
        typer.Option(
            "--positions", metavar="POINTS", help="Their positions on the work area, in px."
        ),
    ] = None,
    dt: Annotated[
        float | None,
        typer.Option(
            "--dt",
            parser=number,
            metavar="SECONDS",
            help="Time between two frames in s. Default: from the video; 0.2 for images.",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="FOLDER", help="Folder for the results.")
    ] = Path("robsim-track"),
    video: Annotated[
        bool, typer.Option(metavar=SWITCH, help="Write the annotated video, tracked.mp4, too.")
    ] = True,
    as_json: Json = False,
) -> None:
    """Track the robot in a video file or a folder of images."""
    from robsim._core import PlaneMap
    from robsim.cli.results import check_folder
    from robsim.imaging._recordings import Recording
    from robsim.simulation import Experiment

    with errors.report_errors():
        check_folder(out)
        if out.resolve() == source.resolve() or (out / VIDEO).resolve() == source.resolve():
            raise ValueError(f"--out {out} would overwrite {source}: give another folder")
        plane_map = None
        if (pixels is None) != (positions is None):
            raise ValueError("--pixels and --positions belong together: give both or neither")
        pixel_points = parse_points("--pixels", pixels, minimum=4)
        world_points = parse_points("--positions", positions, minimum=4)
        if pixel_points and world_points:
            plane_map = PlaneMap.from_points(pixel_points, world_points)
            _print_residuals(plane_map, pixel_points, world_points)
        recording = Recording(source, plane_map=plane_map, area=parse_size("--area", area), dt=dt)
        experiment = Experiment(recording, robot=robot, colors=colors, smoothing=smoothing)
        remark = earlier_run(out)
    failure = None
    try:
        experiment.run(progress=True)
    except KeyboardInterrupt:
        errors.print_note(f"stopped after {len(experiment.trace)} frames")
    except Exception as error:
        failure = error
    if count := len(experiment.trace):
        finish(experiment, out, as_json=as_json)
        if remark:
            errors.print_note(remark)
        if video:
            _write_video(experiment, recording, out / VIDEO)
        if failure is not None:
            errors.print_note(f"the {count} frames before the error are tracked")
    with errors.report_errors():
        if failure is not None:
            raise failure


def _print_residuals(plane_map: PlaneMap, pixels: Points, positions: Points) -> None:
    """Print how far the map is off at the points, if these are more than it is made of."""
    if len(pixels) <= 4:
        return
    distances = np.linalg.norm(plane_map.to_world(pixels) - np.array(positions), axis=1)
    worst = int(np.argmax(distances))
    errors.print_note(
        f"the {len(pixels)} points fit within {distances[worst]:.1f} px of the work area (number "
        f"{worst + 1}), rms {np.sqrt((distances**2).mean()):.1f} px"
    )


def _write_video(experiment: Experiment, recording: Recording, file: Path) -> None:
    from robsim.imaging._opencv import load_opencv
    from robsim.plotting._images.replay import annotated_frames

    try:
        load_opencv("writing a video")
    except ImportError as error:
        errors.print_note(f"no {file.name}: {error}")
        return
    shown = annotated_frames(
        recording,
        experiment.trace,
        simulation=experiment,
    )
    with errors.report_errors():
        write_with_progress(file, shown, experiment.trace)
