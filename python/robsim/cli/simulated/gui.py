"""The command ``robsim gui``: the panel in a window of the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from robsim.cli import errors, shared
from robsim.cli.outcome import keep_run, show_panel
from robsim.cli.simulated.world import options_of, simulation_of, takes_world
from robsim.cli.text import about, parse_speed

if TYPE_CHECKING:
    from robsim.gui.hosted import HostedPanel
    from robsim.simulation import Simulation
    from robsim.teach.tasks import Task
    from robsim.trace import Trace
    from robsim.trace.sessions.session import Session
    from robsim.vision.imaging.recordings import Recording


# The default stages and controller, unless a folder or an option differs.
_STAGES = {"measure": True, "estimate_parameters": True}
_CONTROL = "drive-around"


@takes_world
def gui(
    path: Path | None = None,
    robots: bool = False,
    train: bool = False,
    calibrate: bool = False,
    calibration: Path | None = None,
    scenario: shared.ScenarioFile = None,
    task: str | None = None,
    speed: str | None = None,
    time_limit: shared.CallLimit = None,
    port: int = 0,
    no_browser: bool = False,
    **world: Any,
) -> None:
    """Open the panel in the browser.

    With a folder, the panel runs the callbacks of the folder, and reloads them after each change.
    It plays back a trace, a session or a video. Without arguments, the command opens a start page
    with example runs.

    With --robots, --train or --calibrate, the command opens a tool instead. PATH is then a picture,
    a folder of pictures, a video, or a folder with callbacks to simulate. Without PATH, the tool
    shows the robot, or an example.

    The command ends when you close the last page, or with Ctrl-C. Then it saves the run, and prints
    the batch estimate. The newest ten runs are kept. Only browsers on this machine can open the
    page.

    PATH: Folder with your callbacks (from robsim new), a trace.npz, the folder of a session, or a
        video. For a tool, such as --train, also a picture or a folder of pictures.
    --robots: Define a robot with the mouse: picture, outline, markers, heading, size. The tool
        starts with the robot of --robot, or with the default robot.
    --train: Train the colours in --colors FILE (by default colors.toml), and write this file.
    --calibrate: Calibrate floor and lens of a camera, and write --calibration FILE (by default
        camera.toml).
    --calibration FILE: With --calibrate: file to read the previous calibration from, and to write.
    --task NAME: Run the folder of a solution in the world of this task, show the goal, and print
        the scores at the end. For a trace, show only the goal. See robsim tasks list.
    --speed FACTOR: Multiple of real time, such as 1, or max for the highest speed. Default: 5.
    --port N: Port of the page on this machine. [default: any free port]
    --no-browser: Only print the address, and open no browser.

    Example: robsim gui mine
    """
    from robsim.gui import panel

    with errors.report_errors(path):
        chosen = {"robots": robots, "train": train, "calibrate": calibrate}
        if calibration is not None and not calibrate:
            raise ValueError("--calibration is for --calibrate: add --calibrate")
        if tools := [name for name, is_on in chosen.items() if is_on]:
            colors, robot = world.pop("colors"), world.pop("robot")
            of_a_run = {"scenario": scenario, "task": task, "speed": speed, **world}
            of_a_run["time_limit"] = time_limit
            if len(tools) > 1:
                raise ValueError(
                    f"--{tools[0]} and --{tools[1]} are two tools: give only one of them"
                )
            if given := [name for name, value in of_a_run.items() if value is not None]:
                name = given[0].replace("_", "-")
                raise ValueError(f"--{name} is for a run, but --{tools[0]} starts no run")
            with _tool(tools[0], path, colors, robot, calibration) as tool:
                show_panel(tool, port, is_wanted=not no_browser)
            return
        factor = parse_speed("--speed", speed)
        saved = None if path is None else _saved(path)
        chosen_task = _task_of(task, scenario)
        base = scenario if chosen_task is None or saved is not None else chosen_task.scenario
        goals = None if chosen_task is None else chosen_task.goals
        if path is None and base is None:
            world["control"] = world["control"] or _CONTROL
        options = options_of(path, world, scenario=base, time_limit=time_limit)
        scored = None if saved is not None else chosen_task
        shown = _shown(path, saved, options)
        with panel(shown, speed=factor, goals=goals, task=scored) as opened:
            show_panel(opened, port, is_wanted=not no_browser)
            keep_run(opened)
            if chosen_task is not None:
                errors.say(_scored(chosen_task, opened.trace))


def _task_of(name: str | None, scenario: Path | None) -> Task | None:
    """Return the task of a name, unless a scenario is also given."""
    if name is None:
        return None
    if scenario is not None:
        raise ValueError("--task includes a scenario: leave out --scenario")
    from robsim.teach.tasks import task

    with about("--task"):
        return task(name)


def _scored(task: Task, trace: Trace) -> str:
    """Return the scores of the run that was shown, in a sentence."""
    if len(trace) < task.steps:
        return f"no scores: {len(trace)} of the {task.steps} steps of the task {task.name} were run"
    from robsim.simulation import Scenario
    from robsim.simulation.options import OPTIONS

    run = trace[: task.steps]
    scenario = run.info.scenario
    if isinstance(scenario, str):
        scenario = Scenario.from_toml(scenario)
    for name, row in OPTIONS.items():
        is_other = scenario and getattr(scenario, name) != getattr(task.scenario, name)
        if row.group != "software" and name != "seed" and (is_other or name in run.info.changed):
            return f"no scores: the task {task.name} has another {name}"
    if (rule := task.broken_rule(run)) is not None:
        return f"no scores: {rule}"
    numbers = task.score(run)
    scores = (
        f"{score.title} {numbers[score.name]:.3g} {score.unit}".rstrip() for score in task.scores
    )
    return f"the first {task.steps} steps: {'; '.join(scores)}"


def _tool(
    name: str, path: Path | None, colors: str | None, robot: str | None, calibration: Path | None
) -> HostedPanel:
    """Return the panel of a tool for the content of a path."""
    from robsim.gui import color_panel, floor_panel, robot_panel

    what: Any = path
    if path is not None and path.is_dir() and any(path.glob("*.py")):
        what = simulation_of(path, {})
    if name == "robots":
        return robot_panel(what, robot=robot, colors=colors)
    if name == "calibrate":
        for option, given in (("--colors", colors), ("--robot", robot)):
            if given is not None:
                raise ValueError(f"{option} cannot be used with --calibrate: leave it out")
        return floor_panel(what, file=calibration)
    return color_panel(what, robot=robot, file=Path(colors or "colors.toml"))


def _shown(
    path: Path | None, saved: Recording | Session | Trace | None, options: dict[str, Any]
) -> Recording | Session | Simulation | Trace:
    """Return a saved run, or the simulation that the options describe."""
    if saved is None:
        stages = {} if "scenario" in options else _STAGES
        return simulation_of(path, stages | options)
    if options:
        name = next(iter(options)).replace("_", "-")
        raise ValueError(f"{path} is a recording: --{name} cannot change it")
    return saved


def _saved(path: Path) -> Recording | Session | Trace | None:
    from robsim.trace import Trace
    from robsim.trace.sessions.session import Session
    from robsim.vision.imaging.recordings import Recording

    if path.suffix == ".npz":
        return Trace.load(path)
    if Session._is_in(path):
        return Session(path)
    if path.suffix and not path.exists():
        raise FileNotFoundError(f"there is no file or folder {path}")
    if path.suffix == ".replay":
        raise ValueError(f"{path} is a shared run: robsim replay {path} runs it again")
    if path.suffix == ".py":
        raise ValueError(f"{path} is a single file: give its folder, {path.parent}")
    return Recording(path) if path.is_file() else None
