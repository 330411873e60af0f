"""False poses of small cameras in frames drawn by other code: without and with the image.

    python tests/support/foreign_false_poses.py --frames 100 [--no-fit]

prints for every camera and noise and both ways to measure: of as many frames without a robot those
in which a pose is reported, of as many with one the misses and the false poses, and the
signal-to-noise figures of false and of right poses (5 %, median, 95 %).
"""

import argparse
import sys

import numpy as np

import robsim
from foreign_accuracy import WAYS
from foreign_frames import Case, View, frames_of, layout_of
from scenes import AREA, false_poses

#: The whole work area, from the left to the right edge.
CAMERAS = {
    f"{width} x {height}": View((width, height), width / AREA[0])
    for width, height in ((240, 240), (320, 240), (480, 480), (640, 480))
}
NOISES = {
    "clean": Case(),
    "Gaussian 20 %": Case(gaussian=20),
    "Gaussian 40 %": Case(gaussian=40),
    "uniform 60 %": Case(uniform=60),
}


def reported(case, view, count, measure, *, empty=False, seed=0):
    """Errors (count, 3) of what is reported, and its signal-to-noise; NaN where nothing is.

    On an empty floor every pose is infinitely far off.
    """
    markers = layout_of(case)
    errors, signals = np.full((count, 3), np.nan), np.full(count, np.nan)
    for k, (frame, pose) in enumerate(frames_of(case, view, count, seed, empty=empty)):
        if (measurement := measure(frame, markers)) is not None:
            errors[k] = np.inf if empty else measurement.pose - pose
            if not empty:
                errors[k, 2] = robsim.wrap_angle(errors[k, 2])
            signals[k] = getattr(measurement, "signal_to_noise", np.nan)
    return errors, signals


def _range(signals):
    if not np.isfinite(signals).any():
        return f"{'-':^14}"
    return " ".join(f"{one:4.1f}" for one in np.nanpercentile(signals, (5, 50, 95)))


def row(case, view, count, measure, seed=0):
    """The columns of a way in the table."""
    on_floor, floor_signals = reported(case, view, count, measure, empty=True, seed=seed)
    errors, signals = reported(case, view, count, measure, seed=seed)
    found = np.isfinite(errors[:, 0])
    false = found & false_poses(errors)
    counts = (np.isinf(on_floor[:, 0]).sum(), np.sum(~found), false.sum())
    lies = np.concatenate((floor_signals, signals[false]))
    return " ".join(f"{one:5d}" for one in counts) + (
        f"  {_range(lies)}  {_range(signals[found & ~false])}"
    )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--frames", type=int, default=100, help="with and without a robot")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--no-fit", action="store_true", help="only what the blobs say")
    given = parser.parse_args(arguments)
    ways = ("counted",) if given.no_fit else ("counted", "fitted")
    columns = f"empty  miss false  {'SNR, false':14}  {'SNR, right':14}"
    print(f"{given.frames} frames each\n{'':29}", " | ".join(f"{way:49}" for way in ways))
    print(f"{'':29}", " | ".join(columns for _ in ways))
    for camera, view in CAMERAS.items():
        for noise, case in NOISES.items():
            cells = [row(case, view, given.frames, WAYS[way], given.seed) for way in ways]
            print(f"{camera:13} {noise:15}", " | ".join(cells), flush=True)


if __name__ == "__main__":
    sys.exit(main())
