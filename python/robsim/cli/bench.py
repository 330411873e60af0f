"""The command ``robsim bench``: timings and errors beside those of OpenCV and numpy."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

import typer

from robsim._base.report import Report
from robsim.cli import errors
from robsim.cli.shared import SWITCH, Json
from robsim.cli.text import whole_number

EXAMPLE = "Example: robsim bench"
HELP = (
    "The alternatives, OpenCV and numpy, are timed in the same run on the same frames. OpenCV must "
    "be installed.\n\n"
    "With --panel: how many different frames of a panel Chromium paints in a second, how long "
    "after their step, and what that costs, beside matplotlib. It takes half a minute.\n\n"
    "With --camera: the way of a frame from the bytes that a FireWire or GigE camera sends to the "
    "pose of the robot, for each way in which cameras send pixels, beside OpenCV; and what a "
    "process takes that reads a live one, simulated, and finds the robot in each frame.\n\n"
    "With --accuracy: how far measured poses are from the true ones, beside the least error that "
    "the pixels of the markers allow, centroids, OpenCV and an AprilTag. A row is the frames of "
    "a camera of 1200 or 480 px with a noise: 1200_gaussian_10 is that of 1200 x 1200 px with "
    "Gaussian noise of 10 %, and shows the root mean square of the errors in place (px of an area "
    "of 1200 x 1200) of those poses that are found and not false. Two more tables have the "
    "headings, and how many frames were missed or gave a false pose. It takes some minutes.\n\n"
    "With --campaign: what campaigns cost beside the same loops by hand, in one process and in "
    "two, by the number of runs, and, simulated, with up to 1000 workers of Dask, whose costs for "
    "a task are measured where it is installed. It takes some minutes.\n\n"
    "With --grading: what a step takes with the robot half of a submission in a process of its "
    "own, which is shut in, beside all in one process; and what starting that process takes."
)
_ROUNDS = 25
_ROUNDS_OF_CAMPAIGNS = 3
_FRAMES = 200  # of each case of --accuracy


def bench(
    rounds: Annotated[
        int | None,
        typer.Option(
            "--rounds",
            parser=whole_number,
            metavar="N",
            help="Number of timings of each case; the median is reported, with --campaign and "
            f"--grading the shortest. Default: {_ROUNDS}, with --campaign {_ROUNDS_OF_CAMPAIGNS}.",
        ),
    ] = None,
    panel: Annotated[
        bool,
        typer.Option(
            "--panel",
            metavar=SWITCH,
            help="Measure the panel instead, in Chromium; pip install playwright.",
        ),
    ] = False,
    camera: Annotated[
        bool,
        typer.Option(
            "--camera",
            metavar=SWITCH,
            help="Measure what a live camera's frames take instead, by how it sends pixels.",
        ),
    ] = False,
    accuracy: Annotated[
        bool,
        typer.Option(
            "--accuracy",
            metavar=SWITCH,
            help="Measure the errors of poses instead, in frames of known ones.",
        ),
    ] = False,
    campaign: Annotated[
        bool,
        typer.Option(
            "--campaign",
            metavar=SWITCH,
            help="Measure what campaigns cost instead, beside loops by hand.",
        ),
    ] = False,
    grading: Annotated[
        bool,
        typer.Option(
            "--grading",
            metavar=SWITCH,
            help="Measure what graded runs cost instead, beside runs in one process.",
        ),
    ] = False,
    frames: Annotated[
        int | None,
        typer.Option(
            "--frames",
            parser=whole_number,
            metavar="N",
            help=f"With --accuracy: frames of each case. Default: {_FRAMES}.",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            "--figure",
            metavar="FILE",
            help="With --accuracy: file for the figure, such as accuracy.png.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure how fast, or how exact, robsim is on this machine."""
    with errors.report_errors():
        chosen = {"--panel": panel, "--camera": camera, "--accuracy": accuracy}
        _check_choice({**chosen, "--campaign": campaign, "--grading": grading})
        if not accuracy:
            _refuse_without_accuracy(frames=frames, figure=figure)
        if rounds is not None and (panel or accuracy):
            raise ValueError("--rounds belongs to what is timed: leave it out, or the other option")
        timings = _ROUNDS if rounds is None else rounds
        if panel:
            result = _measured_panel()
        elif campaign:
            result = _measured_campaigns(_ROUNDS_OF_CAMPAIGNS if rounds is None else rounds)
        elif grading:
            result = _measured_grading(timings)
        elif accuracy:
            result = _measured_accuracy(_FRAMES if frames is None else frames, figure)
        else:
            result = _measured_camera(timings) if camera else _measured_core(timings)
    errors.show(result.to_json() if as_json else result)
    if figure is not None and not as_json:
        errors.say(f"figure written to {figure}")


def _check_choice(chosen: dict[str, bool]) -> None:
    names = [name for name, is_chosen in chosen.items() if is_chosen]
    if len(names) > 1:
        raise ValueError(f"{names[0]} and {names[1]} are two benchmarks: give one of them")


def _refuse_without_accuracy(**options: object) -> None:
    for name, value in options.items():
        if value is not None:
            raise ValueError(f"--{name} belongs to --accuracy: add that, or leave --{name} out")


def _measured_core(rounds: int) -> Report:
    from robsim.bench import run_bench

    return run_bench(rounds=rounds)


def _measured_accuracy(frames: int, figure: Path | None) -> Report:
    from robsim.bench._accuracy.run import run_accuracy_bench
    from robsim.cli.results import check_figure_name, check_file, save_figure

    if figure is not None:  # before the minutes that it takes
        check_figure_name(figure)
        check_file(figure)
    result = run_accuracy_bench(frames=frames)
    if figure is not None:
        from robsim.plotting._charts.accuracy import plot_accuracy

        save_figure(figure, plot_accuracy(result))
    return result


def _measured_campaigns(rounds: int) -> Report:
    from robsim.bench._campaign.run import run_campaign_bench

    return run_campaign_bench(rounds=rounds)


def _measured_grading(rounds: int) -> Report:
    from robsim.bench._grading.run import run_grading_bench

    return run_grading_bench(rounds=rounds)


def _measured_camera(rounds: int) -> Report:
    from robsim.bench._camera import run_camera_bench
    from robsim.bench._camera_result import Live
    from robsim.live._bench.serving import read_live_cameras

    converted = run_camera_bench(rounds=rounds)
    live = read_live_cameras()
    return dataclasses.replace(
        converted,
        live=tuple(Live(**row) for row in live.rows),
        left_out=tuple(live.left_out),
    )


def _measured_panel() -> Report:
    from robsim.gui._bench.run import run_panel_bench

    return run_panel_bench()
