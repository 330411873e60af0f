"""The commands ``robsim sessions``: complete recorded runs, make a video of one."""

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

    The torn step at the end is removed, and the index is written. robsim also does that on opening
    a file unchanged for 10 s. The exit status is 1 if a file stays damaged, 2 if a file is
    unreadable.

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
    """Make a video of a session, for players, with a frame for each step.

    A step without a frame shows the last one again.

    --to FILE: Video to write: .mp4 or .webm, or .mkv or .avi without loss. [default: the
        session's name, with .mp4]

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
