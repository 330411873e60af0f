"""The answers of the notebook 14_particle_filter, and mistakes that students make."""

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise


def cloud(rng, n=12):
    """Return particles whose headings lie on both sides of pi, and a pose among them."""
    pose = np.array((*rng.uniform(200, 900, 2), rng.choice((3.05, -3.05))))
    particles = pose + rng.normal(size=(n, 3)) * (3, 3, 0.2)
    particles[:, 2] = robsim.wrap_angle(particles[:, 2])
    return particles, pose


def cloud_and_sigma(rng):
    return *cloud(rng), rng.uniform((2, 2, 0.05), (4, 4, 0.1))


def far_and_sigma(rng):
    """Return a cloud that is far from the measurement in every second case."""
    particles, pose, sigma = cloud_and_sigma(rng)
    return particles, pose + rng.integers(2) * np.array((300.0, 0, 0)), sigma


def normalised(exponents):
    weights = np.exp(exponents - exponents.max())
    return weights / weights.sum()


def errors_of(particles, z, wrapped=True):
    errors = z - particles
    if wrapped:
        errors[:, 2] = robsim.wrap_angle(errors[:, 2])
    return errors


def without_shift(particles, z, sigma):
    weights = np.exp(-0.5 * ((errors_of(particles, z) / sigma) ** 2).sum(axis=1))
    with np.errstate(invalid="ignore"):
        return weights / weights.sum()


def tiny_added(particles, z, sigma):
    weights = np.exp(-0.5 * ((errors_of(particles, z) / sigma) ** 2).sum(axis=1)) + 1e-300
    return weights / weights.sum()


@exercise(
    cases=far_and_sigma,
    hint="Errors (N, 3), exponents (N,), weights (N,): one line for each. What do far ones need?",
    mistakes={
        "All weights of far particles are 0: subtract the largest exponent first.": without_shift,
        "A small number makes all far particles alike: subtract the largest exponent.": (
            tiny_added
        ),
        "Wrap the error of the heading.": lambda particles, z, sigma: normalised(
            -0.5 * ((errors_of(particles, z, wrapped=False) / sigma) ** 2).sum(axis=1)
        ),
        "The exponent has a factor of 1/2.": lambda particles, z, sigma: normalised(
            -((errors_of(particles, z) / sigma) ** 2).sum(axis=1)
        ),
        "The errors are divided by sigma before they are squared.": (
            lambda particles, z, sigma: normalised(
                -0.5 * (errors_of(particles, z) ** 2 / sigma).sum(axis=1)
            )
        ),
        "The sum of all weights must be 1.": lambda particles, z, sigma: (
            normalised(-0.5 * ((errors_of(particles, z) / sigma) ** 2).sum(axis=1))
            / normalised(-0.5 * ((errors_of(particles, z) / sigma) ** 2).sum(axis=1)).max()
        ),
        "The exponent is negative: near particles are the likely ones.": (
            lambda particles, z, sigma: normalised(
                0.5 * ((errors_of(particles, z) / sigma) ** 2).sum(axis=1)
            )
        ),
    },
)
def weights_of(particles, z, sigma):
    """Return the weights (N,), with the sum 1, of particles (N, 3) for a measured pose z (3,)."""
    errors = z - particles
    errors[:, 2] = robsim.wrap_angle(errors[:, 2])
    exponents = -0.5 * ((errors / sigma) ** 2).sum(axis=1)
    weights = np.exp(exponents - exponents.max())
    return weights / weights.sum()


def some_weights(rng):
    weights = rng.random(rng.integers(6, 14)) ** 4
    return (weights / weights.sum(),)


@exercise(
    cases=some_weights,
    hint="Try your function on four weights of 1/4, and on 1, 0, 0, 0.",
    mistakes={
        "Square the weights, then add them.": lambda weights: 1 / weights.sum() ** 2,
        "This is the sum of squares: the effective number is 1 divided by it.": (
            lambda weights: (weights**2).sum()
        ),
        "This counts particles: the weights matter.": lambda weights: len(weights),
        "Add the squares of all weights, not the largest alone.": (
            lambda weights: 1 / weights.max() ** 2
        ),
        "There is no root in it.": lambda weights: 1 / np.sqrt((weights**2).sum()),
    },
)
def effective_number(weights):
    """Return the effective number of particles."""
    return 1 / (weights**2).sum()


def weights_and_start(rng):
    return *some_weights(rng), rng.uniform(0.1, 0.9)


@exercise(
    cases=weights_and_start,
    hint="Where on the line does each weight end? Which end is the first beyond a point?",
    mistakes={
        "The points lie 1 / N apart on a line of length 1: divide them by N.": (
            lambda weights, start: np.searchsorted(
                np.cumsum(weights), start + np.arange(len(weights))
            )
        ),
        "The weights stand one after the other on the line: np.cumsum.": (
            lambda weights, start: np.searchsorted(
                weights, (start + np.arange(len(weights))) / len(weights)
            )
        ),
        "Divide the start by N, too.": lambda weights, start: np.searchsorted(
            np.cumsum(weights), start + np.arange(len(weights)) / len(weights)
        ),
        "The start is missing: it shifts all points.": lambda weights, start: np.searchsorted(
            np.cumsum(weights), np.arange(len(weights)) / len(weights)
        ),
        "`start` must shift all points equally, so that neighbours keep the distance 1 / N.": (
            lambda weights, start: np.searchsorted(
                np.cumsum(weights), start * np.arange(len(weights)) / len(weights)
            )
        ),
        "These are the heaviest ones: each particle gets copies as its weight says.": (
            lambda weights, start: np.argsort(weights)[::-1]
        ),
        "These are the points: return the indices of the particles there.": (
            lambda weights, start: (start + np.arange(len(weights))) / len(weights)
        ),
    },
)
def chosen(weights, start):
    """Return the indices (N,) that systematic resampling chooses, for a start from 0 to 1."""
    points = (start + np.arange(len(weights))) / len(weights)
    return np.searchsorted(np.cumsum(weights), points)


def weighted_cloud(rng):
    """Return particles of similar headings, so that any mean of angles is right, and weights."""
    x, y = rng.uniform(200, 900, 2)
    if rng.random() < 0.3:  # two, on both sides of pi
        return np.array(((x, y, 3.1), (x, y, -3.12))), np.array((0.5, 0.5))
    pose = np.array((x, y, rng.choice((2.98, -2.98, 0.05))))
    particles = pose + rng.uniform(-1, 1, (12, 3)) * (3, 3, 0.2)
    particles[:, 2] = robsim.wrap_angle(particles[:, 2])
    return particles, rng.dirichlet(np.full(12, 3))


def unwrapped_mean(particles, weights):
    return particles[0] - weights @ errors_of(particles, particles[0])


@exercise(
    cases=weighted_cloud,
    tolerance=5e-3,  # between the circular mean of headings and that of wrapped errors
    hint="Errors from the first particle, wrapped, are small numbers with an ordinary mean.",
    mistakes={
        "The mean of angles near pi and -pi is not near 0: average wrapped errors.": (
            lambda particles, weights: weights @ particles
        ),
        "The weights are missing: this is the plain mean.": (
            lambda particles, weights: mean_pose(particles, 0 * weights + 1 / len(weights))
        ),
        "The most likely particle alone is no mean.": (
            lambda particles, weights: particles[weights.argmax()]
        ),
        "The heading leaves the interval from -pi to pi: wrap it at the end.": (
            lambda particles, weights: (
                weights @ np.column_stack((particles[:, :2], particles[:, 2] % (2 * np.pi)))
            )
        ),
        "The heading of the mean may be beyond pi: wrap it, too.": unwrapped_mean,
        "This is the plain sum: multiply each particle by its weight first.": (
            lambda particles, weights: particles.sum(axis=0)
        ),
    },
)
def mean_pose(particles, weights):
    """Return the weighted mean pose (3,) of particles (N, 3), its heading from -pi to pi."""
    errors = particles - particles[0]
    errors[:, 2] = robsim.wrap_angle(errors[:, 2])
    x, y, heading = particles[0] + weights @ errors
    return x, y, robsim.wrap_angle(heading)
