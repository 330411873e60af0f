"""How far parameters identified from tracked poses are off, in units of their standard errors.

    python tests/support/tracked_standard_errors.py --runs 12 --steps 800 [--jobs 2]

prints for each world and method the rms of (estimate - truth) / standard error over all parameters
that a robot that drives around determines, per axis: 1 where the standard errors are right.
"""

import argparse

import numpy as np

import robsim

METHODS = ("least_squares", "instrumental_variables", "output_error")
AXES = ("X", "Y", "P")
SCENARIO = robsim.Scenario(
    boundary="unlimited", control=robsim.DriveAround(), measure=True, identify_from="measurement"
)
WORLDS = {
    "headings": {"36 headings": 36, "any heading": None},
    "noise": {0: None, 2: robsim.GaussianNoise(2), 10: robsim.GaussianNoise(10)},
}


def deviations(trace):
    """Mean squared deviation in standard errors by method and axis; NaN: not determined."""
    found = {}
    for method in METHODS:
        fit = robsim.batch_estimate(trace, method=method)
        z = (fit.batch - fit.theta_true) / fit.standard_errors
        z[~np.isfinite(z)] = np.nan
        means = np.nanmean(np.square(z), axis=1)
        found |= {f"{method}_{axis}": mean for axis, mean in zip(AXES, means, strict=True)}
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--runs", type=int, default=12)
    parser.add_argument("--steps", type=int, default=800)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    options = {"runs": given.runs, "steps": given.steps, "executor": given.jobs, "seed": 0}
    metrics = {"z2": deviations}
    result = robsim.campaign(SCENARIO, vary=WORLDS, metrics=metrics, on_error="raise", **options)
    summary = result.summary()
    print(f"{given.runs} runs of {given.steps} steps: rms of {' / '.join(AXES)}")
    for world, means in zip(summary.groups, np.sqrt(summary.mean), strict=True):
        print(f"\n{world} % noise")
        for method, rms in zip(METHODS, means.reshape(len(METHODS), -1), strict=True):
            print(f"{method:24}", " / ".join(f"{value:.2f}" for value in rms))


if __name__ == "__main__":
    main()
