"""How often the reference filters are judged consistent, with the covariance of the measurements.

    python tests/support/filter_consistency.py --sets 100 [--size 1200] [--jobs 2]

runs every filter, with its defaults, in worlds with the disturbances that these defaults stand for,
with any heading and camera noise of 10 %, and with 36 headings without noise: sets of 20 runs of 60
steps, each set with a verdict of its own. Prints for each filter the mean NEES over all, its spread
over the sets, and how often each verdict was given.
"""

import argparse
from collections import Counter
from functools import partial

import numpy as np

import robsim
import robsim.reference as reference
from nees_of_runs import nees_by_step, reports

RUNS, STEPS = 20, 60
WORLDS = {
    "any heading, 10 %": {"headings": None, "noise": robsim.GaussianNoise(10)},
    "36 headings": {"headings": 36},
}
MODEL = robsim.RobotModel()
FILTERS = {
    "extended": partial(reference.ExtendedKalmanFilter, MODEL),
    "unscented": partial(reference.UnscentedKalmanFilter, MODEL),
    "particle": partial(reference.ParticleFilter, MODEL),
    "constant velocity": reference.ConstantVelocityKalmanFilter,
}


def verdicts(world, *, sets, size=1200, jobs=None):
    """Per filter the reports of all sets."""
    result = robsim.campaign(
        robsim.Scenario(
            resolution=(size, size),
            boundary="unlimited",
            process_noise=robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005),
            control=robsim.DriveAround(),
            measure=True,
            **WORLDS[world],
        ),
        vary={"estimate_state": FILTERS},
        metrics={"nees": nees_by_step},
        runs=sets * RUNS,
        steps=STEPS,
        seed=0,
        executor=jobs,
        on_error="raise",
    )
    values = np.stack([result[name] for name in result.metrics], axis=-1)
    return {name: reports(values[result["estimate_state"] == name], RUNS) for name in FILTERS}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--sets", type=int, default=100)
    parser.add_argument("--size", type=int, default=1200, help="width of the frames (px)")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    for world in WORLDS:
        print(f"\n{world}, {options.sets} sets of {RUNS} runs of {STEPS} steps")
        found = verdicts(world, sets=options.sets, size=options.size, jobs=options.jobs)
        for name, of_sets in found.items():
            means = [np.nanmean(report.values) for report in of_sets]
            counts = Counter(report.verdict for report in of_sets).most_common()
            given = ", ".join(f"{verdict} {count}" for verdict, count in counts)
            spread = f"{min(means):.2f} to {max(means):.2f}"
            print(f"{name:18} NEES {np.mean(means):.2f} ({spread}): {given}")


if __name__ == "__main__":
    main()
