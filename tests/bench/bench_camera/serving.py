"""Serves a simulated lab to a program that reads it, and says what that took."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from doubles import GigeServer, VirtualBus, VirtualCamera
from robsim.lab import CaptureError
from robsim.lab.rehearsal.lab import SimulatedLab
from robsim.simulation.scenario import Scenario
from robsim.vision.imaging.noise import GaussianNoise

SIZE = (1280, 960)
FPS = 30.0  # of which a FireWire camera of this size sends each other one
WAYS = (("gige", "raw8"), ("gige", "rgb8"), ("firewire", "yuv422"))
NOISE_PERCENT = 1.0
PATIENCE = 60  # s, for all but the reading

_READING = Path(__file__).with_name("reading.py")


@dataclass(frozen=True)
class LiveReadings:
    """What reading live cameras took.

    Attributes
    ----------
    rows : list of dict
        Of each way that could be measured: its name, the size and what `reading` says.
    left_out : list of str
        The others, and why.
    """

    rows: list[dict[str, Any]]
    left_out: list[str]


def read_live_cameras(*, seconds: float = 5.0, size: tuple[int, int] = SIZE) -> LiveReadings:
    """Let a process of its own read frames, and find the robot in each.

    Parameters
    ----------
    seconds : float
        How long each way is read (s).
    size : (int, int)
        Width and height of the frames (px).

    Raises
    ------
    RuntimeError
        If the process that reads fails.
    """
    found = LiveReadings([], [])
    for transport, coding in WAYS:
        try:
            said = _read(transport, coding, seconds, size)
        except CaptureError as error:
            found.left_out.append(f"{transport} {coding} is left out: {error}")
            continue
        found.rows.append({"transport": transport, "coding": coding, "size": size, **said})
    return found


def _read(transport: str, coding: str, seconds: float, size: tuple[int, int]) -> dict[str, Any]:
    width, height = size
    scenario = Scenario(
        robot="lab",
        area=(1200, 1200 * height // width),
        resolution=size,
        headings=None,
        noise=GaussianNoise(NOISE_PERCENT),
        start=(450, 600, 0.5),
        seed=1,
    )
    with SimulatedLab(scenario, fps=FPS) as lab, _served(transport, coding, lab) as server:
        is_bus = isinstance(server, VirtualBus)
        done = subprocess.run(
            [
                *(sys.executable, str(_READING)),
                *("firewire://" if is_bus else server.url, coding, *map(str, lab.area)),
                str(seconds),
            ],
            env=server.environment if is_bus else dict(os.environ),
            capture_output=True,
            text=True,
            timeout=seconds + PATIENCE,
            check=False,
        )
    if done.returncode:
        raise RuntimeError(f"{transport} {coding} could not be read: {done.stderr.strip()}")
    said: dict[str, Any] = json.loads(done.stdout)
    return said


def _served(transport: str, coding: str, lab: SimulatedLab) -> AbstractContextManager[Any]:
    """Return what serves the lab: GigE Vision, or a bus of IEEE 1394b, as fast as it must be."""
    if transport == "gige":
        return GigeServer(lab)
    return VirtualBus(VirtualCamera(lab=lab, codings=(coding,), is_fast=True))
