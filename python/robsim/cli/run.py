"""The commands ``robsim new`` and ``robsim run``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from robsim.cli import errors
from robsim.cli.outcome import finish
from robsim.cli.shared import Colors, Json, Noise, Robot, Smoothing
from robsim.cli.text import parse_dropout, parse_headings, parse_noise, parse_size

if TYPE_CHECKING:
    from robsim import Simulation

NEW_EXAMPLE = "Example: robsim new mine"
NEW_HELP = (
    "Write the eight default callbacks into a folder, to be edited.\n\n"
    "Each file is a stage of the loop: control.py, measure.py, ... Those that a run can do without "
    "are switched off: set ENABLED = True in them. Then: robsim run FOLDER"
)
RUN_EXAMPLE = "Example: robsim run mine --steps 300 --measure"
RUN_HELP = (
    "Run a simulation, with the callbacks of a folder if you name one.\n\n"
    "Figures and the trace go to a folder. Without a controller, yours or --control, the robot "
    "spins."
)


def new(
    folder: Annotated[Path, typer.Argument(help="The folder; made if there is none.")],
) -> None:
    """Write the default callbacks into a folder."""
    from robsim.simulation._folders.callback_folder import new_folder

    with errors.report_errors():
        files = new_folder(folder)
    print(f"written to {folder}: {', '.join(file.name for file in files)}")
    print(f"edit them, then: robsim run {folder}")


def run(
    folder: Annotated[Path | None, typer.Argument(help="Folder with your callbacks.")] = None,
    steps: Annotated[int, typer.Option("--steps", help="Steps of the run.")] = 500,
    seed: Annotated[int | None, typer.Option("--seed", help="Seed of the run.")] = None,
    measure: Annotated[
        bool, typer.Option("--measure", help="Track the robot, if the folder does not.")
    ] = False,
    estimate_parameters: Annotated[
        bool,
        typer.Option("--estimate-parameters", help="The same for its parameters."),
    ] = False,
    control: Annotated[
        str | None,
        typer.Option(
            "--control",
            help="A ready controller in place of the folder's: spin, drive-around, "
            "pseudo-random-binary, multi-sine, chirp.",
        ),
    ] = None,
    noise: Noise = None,
    dropout: Annotated[
        str | None,
        typer.Option(
            "--dropout",
            metavar="PROBABILITY[:STEPS]",
            help="How likely it is that the robot is hidden, such as 0.2, or 0.2:5 for 5 steps at "
            "a time.",
        ),
    ] = None,
    boundary: Annotated[
        str, typer.Option("--boundary", help="bounce: walls. unlimited: the view follows.")
    ] = "bounce",
    headings: Annotated[
        str,
        typer.Option(
            "--headings", help="How many headings of the robot are shown, or: continuous."
        ),
    ] = "36",
    robot: Robot = None,
    markers: Annotated[
        str | None, typer.Option("--markers", help="Robot whose markers to look for.")
    ] = None,
    colors: Colors = None,
    smoothing: Smoothing = None,
    area: Annotated[
        str | None,
        typer.Option("--area", metavar="WxH", help="Work area in px: 1200x1200."),
    ] = None,
    resolution: Annotated[
        str | None,
        typer.Option("--resolution", metavar="WxH", help="Frame in px: as the area."),
    ] = None,
    time_limit: Annotated[
        float | None, typer.Option("--time-limit", help="Most seconds that a callback may take.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path(
        "robsim-run"
    ),
    video: Annotated[
        Path | None,
        typer.Option("--video", help="Video of the run: .mp4, .webm, .mkv (lossless)."),
    ] = None,
    record: Annotated[
        Path | None, typer.Option("--record", help="The same as the camera saw it, to practise on.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Run a simulation."""
    from robsim.cli.results import check_folder
    from robsim.control._excitation import controller_named
    from robsim.imaging._video import VideoWriter
    from robsim.simulation._simulation import Simulation

    with errors.report_errors(folder):
        options: dict[str, Any] = {
            "robot": robot,
            "markers": markers,
            "colors": colors,
            "smoothing": smoothing,
            "area": parse_size("--area", area),
            "resolution": parse_size("--resolution", resolution),
            "boundary": boundary,
            "headings": parse_headings("--headings", headings),
            "noise": parse_noise("--noise", noise),
            "dropout": parse_dropout("--dropout", dropout),
            "seed": seed,
            "time_limit": time_limit,
            "measure": measure or None,
            "estimate_parameters": estimate_parameters or None,
            "control": None if control is None else controller_named(control),
        }
        if folder is None:
            simulation = Simulation(**options)
        else:
            simulation = Simulation.from_folder(folder, **options)
        # What would be wrong after the run is said now.
        check_folder(out)
        for file in filter(None, (video, record)):
            VideoWriter(file, fps=1)
        if video and record and video.resolve() == record.resolve():
            raise ValueError(f"--video and --record must be two files, got {video} for both")
        run_kept(simulation, steps, out)
    finish(simulation, out, as_json=as_json, video=video, record=record)


def run_kept(simulation: Simulation, steps: int | None, out: Path) -> None:
    """Run a simulation; if something ends it early, keep what was recorded by then."""
    try:
        simulation.run(steps, progress=True)
    except KeyboardInterrupt:
        errors.print_note(f"stopped after {len(simulation.trace)} steps")
    except BaseException:
        if trace := simulation.trace:
            out.mkdir(parents=True, exist_ok=True)
            trace.save(out / "cut-short.npz")
            errors.print_note(
                f"the {len(trace)} steps until then are kept in {out / 'cut-short.npz'}"
            )
        raise
