"""A long stream at constant memory: ``python -m live_faults.stream --frames 100000``."""

import argparse
import sys
from pathlib import Path

import numpy as np

import robsim
from python_devices import EndlessCamera

ROOM = 8e6  # bytes, for what allocators keep
BYTES_PER_STEP = 250  # of the trace; it doubles its memory when that is full


def resident():
    """Memory of this process (bytes)."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def main():
    parser = argparse.ArgumentParser(prog="live_faults.stream")
    parser.add_argument("--frames", type=int, default=100_000)
    frames = parser.parse_args().frames
    image = np.random.default_rng(0).integers(0, 256, (120, 160, 3), np.uint8)
    motors = robsim.lab.RecordedMotors()
    motors._keep = lambda u1, u2: 0.0  # it would grow
    with (
        robsim.Camera(EndlessCamera(image), area=(160, 120)) as camera,
        robsim.Experiment(
            camera, send=motors, frame_timeout=60, control=lambda step: (0.5, 0.2), measure=False
        ) as experiment,
    ):
        experiment.run(frames // 5)
        before = resident()
        trace = experiment.run(frames - frames // 5)
        grown = resident() - before
    print(f"{len(trace)} steps, {grown / 1e6:.1f} MB more since the first {frames // 5}")
    assert len(trace) == frames == camera.counts.delivered
    assert np.isfinite(trace.u).all()
    sys.exit(grown > ROOM + 2 * BYTES_PER_STEP * frames)


if __name__ == "__main__":
    main()
