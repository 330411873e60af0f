"""The command ``robsim run``: a simulation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from robsim.cli import errors, shared
from robsim.cli.outcome import finish
from robsim.cli.simulated.world import options_of, simulation_of, takes_world
from robsim.cli.text import about, parse_point
from robsim.vision.imaging.video import SUFFIXES

if TYPE_CHECKING:
    from robsim.simulation import Simulation


@takes_world
def run(
    folder: shared.Callbacks = None,
    scenario: shared.ScenarioFile = None,
    steps: int = 500,
    time_limit: shared.CallLimit = None,
    out: shared.Out = Path("robsim-run"),
    video: Annotated[Path | None, f"--video FILE: Video of the run: {SUFFIXES}"] = None,
    record: Path | None = None,
    goal: str | None = None,
    unit: shared.Unit = "px",
    scale: shared.Scale = None,
    as_json: shared.Json = False,
    **world: Any,
) -> None:
    """Run a simulation.

    The command writes figures and the trace to a folder. If neither the folder nor --control gives
    a controller, the robot spins. Ctrl-C ends the run and keeps the results.

    --steps N: Number of steps.
    --record FILE: Video of the camera's frames, as received by the robot's software. For
        measurements, use .mkv or .avi.
    --goal X,Y: Point (px) for a report on the path to it, with the distance at the end.

    Example: robsim run mine --steps 300 --measure
    """
    from robsim.control import score_path
    from robsim.control.path_following import as_waypoints
    from robsim.simulation.options import step_count

    with errors.report_errors(folder):
        with about("--steps"):
            step_count(steps)
        with about("--goal", "waypoints"):
            point = parse_point("--goal", goal)
            goals = None if point is None else as_waypoints([point])
        shared.check_unit(unit, scale, is_simulated=True)
        options = options_of(folder, world, scenario=scenario, time_limit=time_limit)
        simulation = simulation_of(folder, options)
        _check_outputs(out, video, record)
        run_kept(simulation, steps, out)
    trace = simulation.trace.in_unit(unit, mm_per_px=scale)
    more = {"path": score_path(trace, goals)} if goals is not None and len(trace) else None
    finish(
        simulation,
        out,
        as_json=as_json,
        video=video,
        record=record,
        more=more,
        unit=unit,
        scale=scale,
    )


def _check_outputs(out: Path, video: Path | None, record: Path | None) -> None:
    """Raise the errors of the outputs, before the run."""
    from robsim.cli.results import check_folder
    from robsim.vision.imaging.video import VideoWriter

    check_folder(out)
    for file in filter(None, (video, record)):
        VideoWriter(file, fps=1)
    if video and record and video.resolve() == record.resolve():
        raise ValueError(f"--video and --record must be two files, got {video} for both")


def run_kept(simulation: Simulation, steps: int, out: Path) -> None:
    """Run a simulation; after an error, save the trace of the previous steps."""
    try:
        simulation.run(steps, progress=True)
    except KeyboardInterrupt:
        errors.print_note(f"stopped after {len(simulation.trace)} steps")
    except BaseException:
        if trace := simulation.trace:
            out.mkdir(parents=True, exist_ok=True)
            trace.save(out / "cut-short.npz")
            errors.print_note(
                f"the {len(trace)} steps before the error are saved in {out / 'cut-short.npz'}"
            )
        raise
