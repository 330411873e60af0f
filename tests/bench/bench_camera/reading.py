"""The program that reads: ``python reading.py URL CODING WIDTH HEIGHT S``."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from robsim._core import MarkerLayout
from robsim.lab import Camera
from robsim.simulation.scenario import Scenario
from robsim.vision import find_blobs, load_colors, locate

FIRST = 10  # frames until all is in the memory
_BUS = "virtual bus"  # name of its thread


def processor_time() -> float:
    """Return what this process has computed (s), without the virtual bus, which a kernel replaces.

    Returns
    -------
    float
        Processor time of all threads but that one.
    """
    seconds = time.process_time()
    for task in Path("/proc/self/task").glob("*"):
        if (task / "comm").read_text().strip() == _BUS:
            seconds -= 1e-9 * int((task / "schedstat").read_text().split()[0])
    return seconds


def measure(camera: Camera, markers: MarkerLayout, colors: Any) -> tuple[int, float]:
    """Find the robot in the next frame.

    Returns
    -------
    int
        Number of the frame.
    float
        Time from the arrival of its bytes to the measurement (s).

    Raises
    ------
    RuntimeError
        If the robot is not found.
    """
    frame = camera.read()
    blobs = find_blobs(frame, colors, markers=markers)
    if locate(blobs, markers, plane_map=frame.plane_map) is None:
        raise RuntimeError("the robot must be found in each frame")
    arrived = (frame.epoch or 0.0) + (frame.t_arrival or 0.0)
    return frame.index, time.monotonic() - arrived


def read(url: str, coding: str, area: tuple[int, int], seconds: float) -> dict[str, float]:
    """Read a camera for a while, and find the robot in each frame.

    Returns
    -------
    dict of float
        `rate` of frames (1/s); `lost`, how many did not come or were not taken; `latency` and
        `latency_p95` from the arrival of a frame's bytes to its measurement (ms), median and 95th
        percentile; `core`, this process' share of a processor core.
    """
    markers, colors = Scenario(robot="lab")._marker_layout, load_colors()
    latencies = []
    with Camera(url, area=area, coding=coding) as camera:
        for _ in range(FIRST):
            first, _ = measure(camera, markers, colors)
        start, computed = time.monotonic(), processor_time()
        while time.monotonic() - start < seconds:
            last, latency = measure(camera, markers, colors)
            latencies.append(1e3 * latency)
        lasted, computed = time.monotonic() - start, processor_time() - computed
    return {
        "rate": len(latencies) / lasted,
        "lost": last - first - len(latencies),
        "latency": float(np.median(latencies)),
        "latency_p95": float(np.percentile(latencies, 95)),
        "core": computed / lasted,
    }


if __name__ == "__main__":
    url, coding, width, height, seconds = sys.argv[1:]
    print(json.dumps(read(url, coding, (int(width), int(height)), float(seconds))))
