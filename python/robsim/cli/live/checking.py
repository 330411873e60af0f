"""``robsim live --check``: whether the camera is good enough, as text, JSON and picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from robsim._core import MotorLink
from robsim.cli import errors
from robsim.cli.live.sources import WatchedCamera

_SECONDS = 3.0
_PICTURE = "check.png"


def check_and_report(
    camera: WatchedCamera, motors: MotorLink | None, out: Path, as_json: bool, **options: Any
) -> None:
    """Check a camera, print what was found, and draw it; exit with 1 if it is bad.

    Parameters
    ----------
    camera : WatchedCamera
        The camera.
    motors : MotorLink or None
        The line to the robot.
    out : Path
        Folder for the picture.
    as_json : bool
        Whether to print JSON.
    **options
        Those of `robsim.lab.check_camera`.
    """
    from robsim import plotting
    from robsim.cli.results import save_figure
    from robsim.lab.rehearsal.camera_check import check_camera

    errors.print_note(f"looking for {_SECONDS:g} s; the robot must stand, and nothing drives it")
    check = check_camera(camera, motors=motors, seconds=_SECONDS, **options)
    out.mkdir(parents=True, exist_ok=True)
    picture = out / _PICTURE
    save_figure(picture, plotting.plot_camera_check(check))
    errors.show(check.to_json() if as_json else check)
    if not as_json:
        errors.say(f"written: {picture}")
    if not check.ok:
        raise typer.Exit(1)
