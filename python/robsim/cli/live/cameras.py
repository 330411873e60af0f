"""The command ``robsim cameras``: which cameras there are."""

from __future__ import annotations

from typing import Annotated

from robsim.cli import errors
from robsim.cli.option import switch
from robsim.cli.shared import Json

EXAMPLE = "Example: robsim cameras"
HELP = "Each with what to give robsim.Camera. None of them is opened."


def cameras(
    network: Annotated[
        bool,
        switch("--network", "Look for GigE Vision cameras on the network, too: that takes 1 s."),
    ] = False,
    as_json: Json = False,
) -> None:
    """List the cameras of this computer, what is missing, and why."""
    from robsim.lab.cameras.finding import find_cameras

    with errors.report_errors():
        report = find_cameras(network=network)
    if as_json:
        errors.show(report.to_json())
        return
    for sentence in report.found:
        errors.say(f"found: {sentence}")
    for sentence in report.missing:
        errors.say(f"missing: {sentence}")
