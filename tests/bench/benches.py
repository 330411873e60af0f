"""What robsim takes, and how exact it is, beside what one would take instead."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path

from robsim.base.report import Report


def accuracy(given: argparse.Namespace) -> Report:
    """How far measured poses are from the true ones, in some minutes.

    Beside the least error that the pixels of the markers allow, centroids, OpenCV and an AprilTag.
    A row is the frames of a camera of 1200 or 480 px with a noise: 1200_gaussian_10 is that of
    1200 x 1200 px with Gaussian noise of 10 %, and shows the root mean square of the errors in
    place (px of an area of 1200 x 1200) of those poses that are found and not false. Two more
    tables have the headings, and how many frames were missed or gave a false pose.
    """
    from bench_accuracy.figure import plot_accuracy
    from bench_accuracy.run import run_accuracy_bench
    from robsim.cli.results import check_figure_name, check_file, save_figure

    if given.figure is not None:  # before the minutes that it takes
        check_figure_name(given.figure)
        check_file(given.figure)
    result = run_accuracy_bench(frames=given.frames)
    if given.figure is not None:
        save_figure(given.figure, plot_accuracy(result))
        print(f"figure written to {given.figure}", file=sys.stderr)
    return result


def camera(given: argparse.Namespace) -> Report:
    """What a frame of a FireWire or GigE camera takes, from its bytes to the robot's pose.

    For each way in which cameras send pixels, beside OpenCV; and what a process takes that reads a
    live one, simulated, and finds the robot in each frame. Then the age of the pictures of RTSP.
    """
    from bench_camera import streams
    from bench_camera.result import Live, Stream
    from bench_camera.run import run_camera_bench
    from bench_camera.serving import read_live_cameras

    converted = run_camera_bench(rounds=given.rounds)
    live = read_live_cameras()
    rows, left_out, read = tuple(Live(**row) for row in live.rows), live.left_out, []
    for coding in streams.CODINGS:
        try:
            read.append(Stream(**streams.read_stream(coding)))
        except OSError as error:
            left_out.append(f"rtsp {coding} is left out: {error}")
    return dataclasses.replace(converted, live=rows, streams=tuple(read), left_out=tuple(left_out))


def campaign(given: argparse.Namespace) -> Report:
    """What campaigns cost beside the same loops by hand, in some minutes.

    In one process and in two, by the number of runs, and, simulated, with up to 1000 workers of
    Dask, whose costs for a task are measured where it is installed.
    """
    from bench_campaign.run import run_campaign_bench

    return run_campaign_bench(rounds=given.rounds)


def grading(given: argparse.Namespace) -> Report:
    """What graded runs cost beside the same in one process.

    A step with the robot half of a submission in a process of its own, which is shut in, and the
    start of that process.
    """
    from bench_grading.run import run_grading_bench

    return run_grading_bench(rounds=given.rounds)


def limits(given: argparse.Namespace) -> Report:
    """Cost of reading the worst file of each row of SECURITY.md, in two minutes.

    Peak memory and CPU time of a separate process for each file, and whether
    SECURITY.md promises as much.
    """
    from bench_limits.run import run_limits_bench

    return run_limits_bench(seed=given.seed)


def panel(given: argparse.Namespace) -> Report:
    """What Chromium paints of a panel, in half a minute.

    How many different frames in a second, how long after their step, and what that costs, beside
    matplotlib. It needs Playwright.
    """
    from bench_panel.run import run_panel_bench

    return run_panel_bench()


_ROUNDS = {camera: 25, campaign: 3, grading: 25}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="./run bench", description=__doc__)
    names = parser.add_subparsers(metavar="NAME", required=True)
    for bench in (accuracy, camera, campaign, grading, limits, panel):
        about = str(bench.__doc__)
        one = names.add_parser(bench.__name__, help=about.split(".\n")[0], description=about)
        one.set_defaults(bench=bench)
        one.add_argument("--json", action="store_true", help="print JSON in place of tables")
        if bench in _ROUNDS:
            many = f"timings of each case; default {_ROUNDS[bench]}"
            one.add_argument("--rounds", type=int, default=_ROUNDS[bench], metavar="N", help=many)
        if bench is limits:
            one.add_argument("--seed", type=int, default=1, help="of the contents; default 1")
        if bench is accuracy:
            many = "frames of each case; default 200"
            one.add_argument("--frames", type=int, default=200, metavar="N", help=many)
            one.add_argument(
                "--figure", type=Path, metavar="FILE", help="file for the figure: accuracy.png"
            )
    return parser


def main(arguments: Sequence[str] | None = None) -> None:
    """Print what a benchmark has measured."""
    parser = _parser()
    given = parser.parse_args(arguments)
    try:
        result = given.bench(given)
    except (ValueError, OSError, ImportError, RuntimeError) as error:
        parser.error(str(error))
    print(result.to_json() if given.json else result)


if __name__ == "__main__":
    main()
