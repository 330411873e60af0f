"""Writes and prints the results of a run, for the commands ``run`` and ``track``."""

from __future__ import annotations

import getpass
import json
import os
import socket
import sys
from pathlib import Path
from typing import TYPE_CHECKING, cast

from robsim.cli import errors

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from robsim._core import Frame
    from robsim.base.report import Report
    from robsim.gui import Panel
    from robsim.gui.hosted import HostedPanel
    from robsim.simulation import Experiment, Simulation
    from robsim.trace import Trace
    from robsim.vision.imaging.images import Pixels


def finish(
    simulation: Simulation | Experiment,
    out: Path,
    *,
    as_json: bool,
    video: Path | None = None,
    record: Path | None = None,
    more: Mapping[str, Report] | None = None,
    unit: str = "px",
    scale: float | None = None,
) -> None:
    """Write the results and videos of a run, and print a summary.

    `more` are other reports of the run, by name; `scale` is the length of a px (mm).
    """
    from robsim.cli.results import write_results
    from robsim.cli.shared import earlier_run
    from robsim.vision.markers.missed_detections import explain_missed

    if not len(simulation.trace):
        errors.print_note("no steps, no results")
        return
    remark = earlier_run(out)
    results = write_results(out, simulation, more=more, unit=unit, scale=scale)
    if video or record:
        trace = simulation.trace.in_unit(unit, mm_per_px=scale)
        _write_videos(cast("Simulation", simulation), trace, video, record)
    if as_json:
        errors.show(json.dumps(results.to_dict(), indent=2, allow_nan=False))
    elif text := str(results):
        errors.show(text)
    if sentence := explain_missed(simulation.missed_detections, len(simulation.trace)):
        errors.print_note(sentence)
    if results.tracking is None:
        errors.print_note(
            "no measurements: add --measure, or write a measure.py with ENABLED = True"
        )
    if not as_json:
        errors.say(f"written to {out}: {', '.join(file.name for file in results.files)}")
        for file in filter(None, (video, record)):
            errors.say(f"written: {file}")
    if remark:
        errors.print_note(remark)


def _write_videos(
    simulation: Simulation, trace: Trace, video: Path | None, record: Path | None
) -> None:
    from robsim.plotting.images.replay import annotated_frames

    if video:
        frames = annotated_frames(_frames(simulation), trace, simulation=simulation)
        write_with_progress(video, frames, trace)
    if record:
        write_with_progress(record, _frames(simulation), trace)


def _frames(simulation: Simulation) -> Iterator[Frame]:
    return (simulation.render_step(int(k)) for k in simulation.trace.k)


def write_with_progress(file: Path, frames: Iterable[Frame | Pixels], trace: Trace) -> None:
    """Write the frames of a run to a video file, with a progress bar."""
    from robsim.simulation.runner import progress_bar
    from robsim.vision.imaging.video import save_video

    shown = progress_bar(frames, total=len(trace), unit="frame", desc=file.name)
    # The mean: lost and irregular frames do not change the duration.
    dt = (trace.t[-1] - trace.t[0]) / max(1, len(trace) - 1) or trace.info.dt
    save_video(file, shown, fps=min(500.0, max(0.1, 1 / dt)))


_PATIENCE = 3.0  # s without any page, such as during a reload


def show_panel(opened: HostedPanel, port: int = 0, *, is_wanted: bool = True) -> None:
    """Print the address of a panel, and show it until its last page is closed, or Ctrl-C.

    A `port` of 0 means any free port. A browser starts if one `is_wanted`.
    """
    page = opened._serve(port)
    is_shown = is_wanted and page.open()
    errors.say(f"the panel is at {page.url}")
    if is_wanted and not is_shown:
        errors.print_note("no browser could be started: open this address in a browser")
    if not is_shown and "SSH_CONNECTION" in os.environ:
        login = f"{getpass.getuser()}@{socket.gethostname()}"
        errors.print_note(
            "to see the panel on your own machine, type there: "
            f"ssh -N -L {page.port}:127.0.0.1:{page.port} {login}; then open the address there"
        )
    errors.say("Ctrl-C ends it")
    sys.stdout.flush()
    try:
        page.wait(_PATIENCE)
    except KeyboardInterrupt:
        errors.print_note("ended")
    else:
        errors.say("ended" if page.fault else "ended: its last page was closed")


def keep_run(opened: Panel) -> None:
    """Save the run of a closing panel among the newest runs; print its file and estimate."""
    from robsim.gui.kept_runs import keep
    from robsim.gui.panels.run.stuck import PATIENCE

    opened._pause_soon(2 * PATIENCE)
    trace = opened.trace
    if opened._is_saved or not len(trace):
        return
    errors.say(f"saving {len(trace)} steps")
    try:
        file = keep(".npz", trace.save)
    except (OSError, MemoryError) as error:
        errors.print_note(f"the run could not be saved: {error}")
    else:
        errors.say(f"its {len(trace)} steps are in {file}; to open them again: robsim gui {file}")
    try:
        errors.show(opened.finish())
    except (ValueError, TimeoutError) as error:  # too few steps, or a callback does not end
        errors.say(f"no estimate: {error}")
