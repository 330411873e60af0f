"""The command ``robsim run``: a simulation."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from robsim.cli import errors, shared
from robsim.cli.command import integer_option, option, switch
from robsim.cli.outcome import finish
from robsim.cli.text import (
    about,
    parse_control,
    parse_dropout,
    parse_headings,
    parse_noise,
    parse_size,
    parse_start,
)
from robsim.control.by_name import POINTS
from robsim.vision.imaging.video import SUFFIXES

if TYPE_CHECKING:
    from robsim.simulation import Scenario, Simulation


def shared_options(
    folder: Path | None,
    *,
    scenario: Path | Scenario | None,
    control: str | None,
    noise: str | None,
    dropout: str | None,
    area: str | None,
    time_limit: float | None,
    **others: Any,
) -> dict[str, Any]:
    """Return the options of a simulation that are given, of those that the commands share."""
    from robsim.simulation import Scenario

    _check_quotes(folder, control)
    world = given(
        area=parse_size("--area", area),
        noise=parse_noise("--noise", noise),
        dropout=parse_dropout("--dropout", dropout),
        **others,
    )
    check_each(world)
    return world | given(
        time_limit=time_limit,
        measure=_needs_pose(control) or None,
        control=parse_control("--control", control),
        scenario=Scenario.load(scenario) if isinstance(scenario, Path) else scenario,
    )


def simulation_of(folder: Path | None, options: dict[str, Any]) -> Simulation:
    """Return the simulation, with the callbacks of a folder if there is one."""
    from robsim.simulation import Simulation

    return Simulation(**options) if folder is None else Simulation.from_folder(folder, **options)


def given(**options: Any) -> dict[str, Any]:
    """Return the options that are given: the others stay as the scenario or the folder has them."""
    return {name: value for name, value in options.items() if value is not None}


def check_each(options: dict[str, Any]) -> None:
    """Raise an error that names an option as the shell does, if one alone is wrong."""
    from robsim.simulation import Scenario

    for name, value in options.items():
        with about(f"--{name}"):
            Scenario(**{name: value})


def _check_quotes(folder: Path | None, control: str | None) -> None:
    """Raise ValueError if a second point was taken for the folder."""
    if control and re.fullmatch(r"-?[\d.]+,-?[\d.]+", str(folder)):
        raise ValueError(
            f"--control: put quotes around the points, as '{control} {folder}': without them "
            f"{folder} is taken for a folder"
        )


def _needs_pose(control: str | None) -> bool:
    return control is not None and control.partition(":")[0] in POINTS


EXAMPLE = "Example: robsim run mine --steps 300 --measure"
HELP = (
    "Figures and the trace are written to a folder. Without a controller, yours or --control, the "
    "robot spins. Ctrl-C ends the run and keeps its results."
)


def run(
    folder: shared.Callbacks = None,
    scenario: shared.ScenarioFile = None,
    steps: Annotated[int, integer_option("--steps", "N", "Number of steps.")] = 500,
    seed: shared.Seed = None,
    start: Annotated[
        str | None,
        option(
            "--start",
            "X,Y,DEGREES",
            "First position in px and heading in degrees, clockwise from facing right, such "
            "as 300,300,90; or: random. Default: the centre, facing right.",
        ),
    ] = None,
    measure: Annotated[
        bool, switch("--measure", "Measure the pose by vision, if the folder does not.")
    ] = False,
    estimate_parameters: Annotated[
        bool, switch("--estimate-parameters", "Estimate the parameters, if the folder does not.")
    ] = False,
    control: shared.Control = None,
    noise: shared.Noise = None,
    dropout: shared.HowHidden = None,
    boundary: Annotated[
        str | None,
        option(
            "--boundary",
            "KIND",
            "bounce: walls, the default. unlimited: the view follows the robot.",
        ),
    ] = None,
    headings: Annotated[
        str | None,
        option(
            "--headings",
            "N",
            "Number of headings that the robot is drawn in, or: continuous. Default: 36.",
        ),
    ] = None,
    robot: shared.Robot = None,
    markers: Annotated[
        str | None,
        option(
            "--markers",
            "NAME|FOLDER",
            "Robot whose markers vision looks for. Default: those of the robot.",
        ),
    ] = None,
    colors: shared.Colors = None,
    smoothing: shared.Smoothing = None,
    area: shared.WorkArea = None,
    resolution: Annotated[
        str | None, option("--resolution", "WxH", "Frame size in px. Default: the area.")
    ] = None,
    time_limit: shared.CallLimit = None,
    out: shared.Out = Path("robsim-run"),
    video: Annotated[
        Path | None, option("--video", "FILE", f"Video of the run: {SUFFIXES}")
    ] = None,
    record: Annotated[
        Path | None,
        option(
            "--record",
            "FILE",
            "Video of the camera's frames, as the robot's software gets them: "
            ".mkv and .avi for measurements.",
        ),
    ] = None,
    unit: shared.Unit = "px",
    scale: shared.Scale = None,
    as_json: shared.Json = False,
) -> None:
    """Run a simulation."""
    from robsim.simulation.options import step_count

    with errors.report_errors(folder):
        with about("--steps"):
            step_count(steps)
        shared.check_unit(unit, scale, is_simulated=True)
        common = shared_options(
            folder,
            scenario=scenario,
            control=control,
            noise=noise,
            dropout=dropout,
            area=area,
            time_limit=time_limit,
            robot=robot,
            colors=colors,
            seed=seed,
        )
        world = given(
            markers=markers,
            smoothing=smoothing,
            resolution=parse_size("--resolution", resolution),
            boundary=boundary,
        )
        if headings is not None:
            world["headings"] = parse_headings("--headings", headings)
        check_each(world)
        stages = given(
            start=parse_start("--start", start),
            measure=measure or None,
            estimate_parameters=estimate_parameters or None,
        )
        simulation = simulation_of(folder, common | world | stages)
        _check_outputs(out, video, record)
        remark = shared.earlier_run(out)
        run_kept(simulation, steps, out)
    finish(simulation, out, as_json=as_json, video=video, record=record, unit=unit, scale=scale)
    if remark and len(simulation.trace):
        errors.print_note(remark)


def _check_outputs(out: Path, video: Path | None, record: Path | None) -> None:
    """Raise the errors of the outputs, before the run."""
    from robsim.cli.results import check_folder
    from robsim.vision.imaging.video import VideoWriter

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
