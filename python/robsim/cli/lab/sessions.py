"""The commands ``robsim sessions``: repair recorded runs, make videos of recorded runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from robsim.base.text import one_line
from robsim.cli import errors
from robsim.cli.command import command, command_group
from robsim.cli.outcome import write_with_progress

if TYPE_CHECKING:
    from robsim._core import Frame
    from robsim.trace.sessions.session import Session

HELP = (
    "A session is a recorded run in an MCAP file of ROS 2 messages: robsim live writes it, or "
    "robsim.Experiment(record=...). robsim gui plays it back; Foxglove and rosbag2 open it, too."
)
app = command_group("Start with: robsim sessions video robsim-live/session-1.mcap")

File = Annotated[Path, "SESSION: File of a session."]
_SAID = {
    "whole": "is complete: nothing was done",
    "completed": "was cut off, and is now completed",
    "in use": "is being written, or cannot be locked: nothing was done",
    "damaged": "has damage that a killed writer does not cause: nothing was done",
}


@command(app)
def repair(files: list[Path]) -> None:
    """Complete sessions that were cut off, so that all programs open them.

    The command removes the incomplete step at the end, and writes the index. robsim also repairs a
    file when it opens a file that has not changed for 10 s. The exit status is 1 if a file stays
    damaged, 2 if a file is unreadable.

    SESSION: Files of sessions.

    Example: robsim sessions repair robsim-live/session-1.mcap
    """
    from robsim.trace.sessions._file import complete, existing_file, read_file

    codes = []
    for file in map(existing_file, files):
        try:
            with errors.report_errors():
                count, done = len(read_file(file).rows), complete(file)
                errors.say(f"{one_line(file)}: {count} steps; it {_SAID[done]}")
                codes.append(int(done == "damaged"))
        except typer.Exit as failure:
            codes.append(failure.exit_code)
    raise typer.Exit(max(codes))


@command(app)
def video(session: File, to: Path | None = None) -> None:
    """Make a video of a session for video players, with one frame per step.

    A step without a frame shows the previous frame again.

    --to FILE: Video to write: .mp4, .webm, or lossless .mkv or .avi. [default: the session's name,
        with .mp4]

    Example: robsim sessions video robsim-live/session-1.mcap --to drive.webm
    """
    from robsim.trace.sessions.session import Session

    opened = Session(session)
    if opened.size is None:
        raise ValueError(f"{one_line(opened.path)} has no frames")
    file = to or opened.path.with_suffix(".mp4")
    write_with_progress(file, _frames(opened), opened.trace)
    errors.say(f"written: {file}")


def _frames(session: Session) -> Iterator[Frame]:
    last: Frame | None = None
    for observation in session:
        last = observation.frame or last
        if last is not None:
            yield last
