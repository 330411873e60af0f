"""The commands ``robsim new`` (callback templates) and ``robsim run`` (a simulation)."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from robsim.cli import errors
from robsim.cli.outcome import finish
from robsim.cli.shared import SWITCH, Colors, Json, Noise, Robot, Seed, Smoothing, earlier_run
from robsim.cli.text import (
    about,
    number,
    parse_control,
    parse_dropout,
    parse_headings,
    parse_noise,
    parse_size,
    parse_start,
    whole_number,
)
from robsim.control._by_name import NAMES, POINTS
from robsim.imaging._video import CODECS, LOSSLESS
from robsim.simulation._slots import SLOTS

if TYPE_CHECKING:
    from robsim import Simulation

NEW_EXAMPLE = "Example: robsim new mine"
NEW_HELP = (
    f"Write the {len(SLOTS)} default callbacks to a folder, as templates to edit.\n\n"
    "Each file is a stage of the loop: control.py, measure.py, ... Optional stages are switched "
    "off: set ENABLED = True in their files. Then: robsim run FOLDER"
)
RUN_EXAMPLE = "Example: robsim run mine --steps 300 --measure"
RUN_HELP = (
    "Run a simulation, optionally with the callbacks of a folder.\n\n"
    "Figures and the trace are written to a folder. Without a controller, yours or --control, the "
    "robot spins. Ctrl-C ends the run and keeps its results."
)

# The names are written out where --help must show points, too.
_CONTROLS = ", ".join(
    f"{name}:X,Y" if POINTS.get(name) else f"{name}:'X,Y X,Y ...'" if name in POINTS else name
    for name in NAMES
)
_LOSSLESS = " and ".join(suffix for suffix, codec in CODECS.items() if codec == LOSSLESS)
_SUFFIXES = f"{', '.join(CODECS)}; {_LOSSLESS} are lossless."


def new(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="The folder; created if needed.")
    ],
) -> None:
    """Write the default callbacks to a folder."""
    from robsim.simulation._folders.callback_folder import new_folder

    with errors.report_errors():
        files = new_folder(folder)
    errors.say(f"written to {folder}: {', '.join(file.name for file in files)}")
    errors.say(f"edit them, then: robsim run {shlex.quote(str(folder))}")


def run(
    folder: Annotated[
        Path | None, typer.Argument(metavar="FOLDER", help="Folder with your callbacks.")
    ] = None,
    scenario: Annotated[
        Path | None,
        typer.Option(
            "--scenario",
            metavar="FILE",
            help="TOML file of a scenario, as Scenario.save writes it; other options change it.",
        ),
    ] = None,
    steps: Annotated[
        int, typer.Option("--steps", parser=whole_number, metavar="N", help="Number of steps.")
    ] = 500,
    seed: Seed = None,
    start: Annotated[
        str | None,
        typer.Option(
            "--start",
            metavar="X,Y,DEGREES",
            help="First position in px and heading in degrees, clockwise from facing right, such "
            "as 300,300,90; or: random. Default: the centre, facing right.",
        ),
    ] = None,
    measure: Annotated[
        bool,
        typer.Option(
            "--measure",
            metavar=SWITCH,
            help="Measure the pose by vision, if the folder does not.",
        ),
    ] = False,
    estimate_parameters: Annotated[
        bool,
        typer.Option(
            "--estimate-parameters",
            metavar=SWITCH,
            help="Estimate the parameters, if the folder does not.",
        ),
    ] = False,
    control: Annotated[
        str | None,
        typer.Option(
            "--control",
            metavar="NAME[:POINTS]",
            help="A built-in controller in place of the folder's: "
            f"{_CONTROLS}. Points are in px; with them the pose is measured.",
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
            metavar="KIND",
            help="bounce: walls, the default. unlimited: the view follows the robot.",
        ),
    ] = None,
    headings: Annotated[
        str | None,
        typer.Option(
            "--headings",
            metavar="N",
            help="Number of headings that the robot is drawn in, or: continuous. Default: 36.",
        ),
    ] = None,
    robot: Robot = None,
    markers: Annotated[
        str | None,
        typer.Option(
            "--markers",
            metavar="NAME|FOLDER",
            help="Robot whose markers vision looks for. Default: those of the robot.",
        ),
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
        float | None,
        typer.Option(
            "--time-limit",
            parser=number,
            metavar="SECONDS",
            help="Maximum duration of a call of one of your callbacks. Default: none.",
        ),
    ] = None,
    out: Annotated[
        Path, typer.Option("--out", metavar="FOLDER", help="Folder for the results.")
    ] = Path("robsim-run"),
    video: Annotated[
        Path | None,
        typer.Option("--video", metavar="FILE", help=f"Video of the run: {_SUFFIXES}"),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(
            "--record",
            metavar="FILE",
            help="Video of the camera's frames, as the robot's software gets them: "
            f"{_LOSSLESS} for measurements.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Run a simulation."""
    from robsim.simulation import Scenario, Simulation
    from robsim.simulation._options import step_count
    from robsim.simulation._time_limit import TimeLimit

    with errors.report_errors(folder):
        _check_quotes(folder, control)
        with about("--steps"):
            step_count(steps)
        world = _given(
            robot=robot,
            markers=markers,
            colors=colors,
            smoothing=smoothing,
            area=parse_size("--area", area),
            resolution=parse_size("--resolution", resolution),
            boundary=boundary,
            noise=parse_noise("--noise", noise),
            dropout=parse_dropout("--dropout", dropout),
            seed=seed,
        )
        if headings is not None:
            world["headings"] = parse_headings("--headings", headings)
        _check_each(world)
        with about("--time-limit"):
            limit = None if time_limit is None else TimeLimit(time_limit).seconds
        options = world | _given(
            start=parse_start("--start", start),
            time_limit=limit,
            measure=measure or _needs_pose(control) or None,
            estimate_parameters=estimate_parameters or None,
            control=parse_control("--control", control),
            scenario=None if scenario is None else Scenario.load(scenario),
        )
        if folder is None:
            simulation = Simulation(**options)
        else:
            simulation = Simulation.from_folder(folder, **options)
        _check_outputs(out, video, record)
        remark = earlier_run(out)
        run_kept(simulation, steps, out)
    finish(simulation, out, as_json=as_json, video=video, record=record)
    if remark and len(simulation.trace):
        errors.print_note(remark)


def _check_quotes(folder: Path | None, control: str | None) -> None:
    """Raise ValueError if a second point was taken for the folder."""
    if control and re.fullmatch(r"-?[\d.]+,-?[\d.]+", str(folder)):
        raise ValueError(
            f"--control: put quotes around the points, as '{control} {folder}': without them "
            f"{folder} is taken for a folder"
        )


def _given(**options: Any) -> dict[str, Any]:
    """Return the options that are given: the others stay as the scenario or the folder has them."""
    return {name: value for name, value in options.items() if value is not None}


def _check_each(options: dict[str, Any]) -> None:
    """Raise an error that names an option as the shell does, if one alone is wrong."""
    from robsim.simulation import Scenario

    for name, value in options.items():
        with about(f"--{name}"):
            Scenario(**{name: value})


def _needs_pose(control: str | None) -> bool:
    return control is not None and control.partition(":")[0] in POINTS


def _check_outputs(out: Path, video: Path | None, record: Path | None) -> None:
    """Raise the errors of the outputs, before the run."""
    from robsim.cli.results import check_folder
    from robsim.imaging._video import VideoWriter

    check_folder(out)
    for file in filter(None, (video, record)):
        VideoWriter(file, fps=1)
    if video and record and video.resolve() == record.resolve():
        raise ValueError(f"--video and --record must be two files, got {video} for both")


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
