"""How often the reference filters are judged consistent, with the covariance of the measurements.

    python tests/support/filter_consistency.py --sets 100 [--size 1200] [--jobs 2]

runs every filter, with its defaults, in worlds with the disturbances that these defaults stand for,
with any heading and camera noise of 10 %, and with 36 headings without noise: sets of 20 runs of 60
steps, each set with a verdict of its own. Prints for each filter the mean NEES over all, its spread
over the sets, and how often each verdict was given.
"""

import argparse
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

import robsim
import robsim.reference as reference
from robsim.evaluation import nees_consistency, wrapped_error

RUNS, STEPS = 20, 60
WORLDS = {"any heading, 10 %": (None, robsim.GaussianNoise(10)), "36 headings": (36, None)}
FILTERS = {
    "extended": reference.ExtendedKalmanFilter,
    "unscented": reference.UnscentedKalmanFilter,
    "particle": reference.ParticleFilter,
    "constant velocity": lambda model: reference.ConstantVelocityKalmanFilter(),
}


def run(seed, *, world, size):
    """Errors (filters, STEPS, 3) and covariances (filters, STEPS, 3, 3) of a run."""
    headings, noise = WORLDS[world]
    sim = robsim.Simulation(
        headings=headings,
        noise=noise,
        resolution=(size, size),
        boundary="unlimited",
        process_noise=robsim.PoseNoise.from_sigma(0.1, 0.1, 0.005),
        control=robsim.DriveAround(),
        measure=True,
        seed=seed,
    )
    filters = [make(sim.model) for make in FILTERS.values()]
    estimates = [[] for _ in filters]

    def estimate_state(step):
        for one, found in zip(filters, estimates, strict=True):
            found.append(one(step))
        return estimates[0][-1]

    sim.estimate_state = estimate_state
    truth = sim.run(STEPS).pose_true
    poses = np.array([[one.pose for one in found] for found in estimates])
    return wrapped_error(poses, truth), np.array([[e.covariance for e in f] for f in estimates])


def verdicts(world, *, sets, size, jobs):
    """Per filter the reports of all sets."""
    with ProcessPoolExecutor(jobs) as pool:
        runs = list(pool.map(partial(run, world=world, size=size), range(sets * RUNS)))
    found = {}
    for i, name in enumerate(FILTERS):
        errors, covariances = (
            np.array([part[i] for part in parts]) for parts in zip(*runs, strict=True)
        )
        found[name] = [
            nees_consistency(errors[k : k + RUNS], covariances[k : k + RUNS])
            for k in range(0, sets * RUNS, RUNS)
        ]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--sets", type=int, default=100)
    parser.add_argument("--size", type=int, default=1200, help="width of the frames (px)")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    for world in WORLDS:
        print(f"\n{world}, {options.sets} sets of {RUNS} runs of {STEPS} steps")
        found = verdicts(world, sets=options.sets, size=options.size, jobs=options.jobs)
        for name, reports in found.items():
            means = [np.nanmean(report.values) for report in reports]
            counts = Counter(report.verdict for report in reports).most_common()
            given = ", ".join(f"{verdict} {count}" for verdict, count in counts)
            spread = f"{min(means):.2f} to {max(means):.2f}"
            print(f"{name:18} NEES {np.mean(means):.2f} ({spread}): {given}")


if __name__ == "__main__":
    main()
