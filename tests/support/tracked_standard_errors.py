"""How far parameters identified from tracked poses are off, in units of their standard errors.

    python tests/support/tracked_standard_errors.py --seeds 12 --steps 800 [--jobs 2]

prints for each world and method the rms of (estimate - truth) / standard error over all parameters
that a robot that drives around determines, per axis: 1 where the standard errors are right.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np

import robsim

METHODS = ("least_squares", "instrumental_variables", "output_error")
WORLDS = {
    "36 headings": (36, None),
    "any heading, clean": (None, None),
    "any heading, 2 %": (None, robsim.GaussianNoise(2)),
    "any heading, 10 %": (None, robsim.GaussianNoise(10)),
}


def deviations(seed, *, world, steps):
    """Deviations in standard errors (methods, 3, 5)."""
    headings, noise = WORLDS[world]
    sim = robsim.Simulation(
        headings=headings,
        noise=noise,
        boundary="unlimited",
        control=robsim.DriveAround(),
        measure=True,
        identify_from="measurement",
        seed=seed,
    )
    trace = sim.run(steps)
    reports = [robsim.batch_estimate(trace, method=method) for method in METHODS]
    return np.array([(one.batch - one.theta_true) / one.standard_errors for one in reports])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--steps", type=int, default=800)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    for world in WORLDS:
        print(f"\n{world}, {options.seeds} runs of {options.steps} steps: rms of X / Y / P")
        with ProcessPoolExecutor(options.jobs) as pool:
            job = partial(deviations, world=world, steps=options.steps)
            z = np.array(list(pool.map(job, range(options.seeds))))
        z[~np.isfinite(z)] = np.nan
        for name, rows in zip(METHODS, z.swapaxes(0, 1), strict=True):
            rms = np.sqrt(np.nanmean(np.square(rows), axis=(0, 2)))
            print(f"{name:24}", " / ".join(f"{value:.2f}" for value in rms))


if __name__ == "__main__":
    main()
