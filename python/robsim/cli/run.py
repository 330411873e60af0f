"""The commands ``robsim new`` (callback templates) and ``robsim run`` (a simulation)."""

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
    "Write the eight default callbacks to a folder, as templates to edit.\n\n"
    "Each file is a stage of the loop: control.py, measure.py, ... Optional stages are switched "
    "off: set ENABLED = True in their files. Then: robsim run FOLDER"
)
RUN_EXAMPLE = "Example: robsim run mine --steps 300 --measure"
RUN_HELP = (
    "Run a simulation, optionally with the callbacks of a folder.\n\n"
    "Figures and the trace are written to a folder. Without a controller, yours or --control, the "
    "robot spins."
)


def new(
    folder: Annotated[Path, typer.Argument(help="The folder; created if needed.")],
) -> None:
    """Write the default callbacks to a folder."""
    from robsim.simulation._folders.callback_folder import new_folder

    with errors.report_errors():
        files = new_folder(folder)
    print(f"written to {folder}: {', '.join(file.name for file in files)}")
    print(f"edit them, then: robsim run {folder}")


def run(
    folder: Annotated[Path | None, typer.Argument(help="Folder with your callbacks.")] = None,
    scenario: Annotated[
        Path | None,
        typer.Option(
            "--scenario",
            help="TOML file of a scenario, as Scenario.save writes it; other options change it.",
        ),
    ] = None,
    steps: Annotated[int, typer.Option("--steps", help="Number of steps.")] = 500,
    seed: Annotated[int | None, typer.Option("--seed", help="Seed of the run.")] = None,
    measure: Annotated[
        bool, typer.Option("--measure", help="Measure the pose by vision, if the folder does not.")
    ] = False,
    estimate_parameters: Annotated[
        bool,
        typer.Option(
            "--estimate-parameters", help="Estimate the parameters, if the folder does not."
        ),
    ] = False,
    control: Annotated[
        str | None,
        typer.Option(
            "--control",
            help="A built-in controller in place of the folder's: spin, drive-around, "
            "pseudo-random-binary, multi-sine, chirp.",
        ),
    ] = None,
    noise: Noise = None,
    dropout: Annotated[
        str | None,
        typer.Option(
            "--dropout",
            metavar="PROBABILITY[:STEPS]",
            help="Probability that the robot is hidden, such as 0.2; 0.2:5 = 5 steps at a time.",
        ),
    ] = None,
    boundary: Annotated[
        str | None,
        typer.Option(
            "--boundary",
            help="bounce: walls, the default. unlimited: the view follows the robot.",
        ),
    ] = None,
    headings: Annotated[
        str | None,
        typer.Option(
            "--headings",
            help="Number of headings that the robot is drawn in, or: continuous. Default: 36.",
        ),
    ] = None,
    robot: Robot = None,
    markers: Annotated[
        str | None, typer.Option("--markers", help="Robot whose markers vision looks for.")
    ] = None,
    colors: Colors = None,
    smoothing: Smoothing = None,
    area: Annotated[
        str | None,
        typer.Option("--area", metavar="WxH", help="Work area in px. Default: 1200x1200."),
    ] = None,
    resolution: Annotated[
        str | None,
        typer.Option("--resolution", metavar="WxH", help="Frame size in px. Default: the area."),
    ] = None,
    time_limit: Annotated[
        float | None, typer.Option("--time-limit", help="Maximum duration of a callback call in s.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path(
        "robsim-run"
    ),
    video: Annotated[
        Path | None,
        typer.Option("--video", help="Video of the run: .mp4, .webm, .mkv (lossless)."),
    ] = None,
    record: Annotated[
        Path | None, typer.Option("--record", help="Video of the camera's frames without overlays.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Run a simulation."""
    from robsim.cli.results import check_folder
    from robsim.control._excitation import controller_named
    from robsim.imaging._video import VideoWriter
    from robsim.simulation import Scenario, Simulation

    with errors.report_errors(folder):
        options: dict[str, Any] = {
            "robot": robot,
            "markers": markers,
            "colors": colors,
            "smoothing": smoothing,
            "area": parse_size("--area", area),
            "resolution": parse_size("--resolution", resolution),
            "boundary": boundary,
            "noise": parse_noise("--noise", noise),
            "dropout": parse_dropout("--dropout", dropout),
            "seed": seed,
            "time_limit": time_limit,
            "measure": measure or None,
            "estimate_parameters": estimate_parameters or None,
            "control": None if control is None else controller_named(control),
            "scenario": None if scenario is None else Scenario.load(scenario),
        }
        options = {name: value for name, value in options.items() if value is not None}
        if headings is not None:
            options["headings"] = parse_headings("--headings", headings)
        if folder is None:
            simulation = Simulation(**options)
        else:
            simulation = Simulation.from_folder(folder, **options)
        # Errors of the outputs are raised before the run.
        check_folder(out)
        for file in filter(None, (video, record)):
            VideoWriter(file, fps=1)
        if video and record and video.resolve() == record.resolve():
            raise ValueError(f"--video and --record must be two files, got {video} for both")
        run_kept(simulation, steps, out)
    finish(simulation, out, as_json=as_json, video=video, record=record)


def run_kept(simulation: Simulation, steps: int | None, out: Path) -> None:
    """Run a simulation; if an error ends it early, save the trace up to then."""
    try:
        simulation.run(steps, progress=True)
    except KeyboardInterrupt:
        errors.print_note(f"stopped after {len(simulation.trace)} steps")
    except BaseException:
        if trace := simulation.trace:
            out.mkdir(parents=True, exist_ok=True)
            trace.save(out / "cut-short.npz")
            errors.print_note(
                f"the {len(trace)} steps until then are saved in {out / 'cut-short.npz'}"
            )
        raise
