"""The answers of the notebook 03_identify, and mistakes that students make."""

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise

LOW, HIGH = -0.5, 1.5  # V
ENOUGH = 0.85  # of the standard error of DriveAround


def path(rng):
    n = int(rng.integers(6, 12))
    return rng.uniform(0, 1200, n), rng.uniform(-3, 3, n), rng.uniform(-1, 1, (n, 2))


def system(rng):
    phi = rng.standard_normal((12, 5))
    return phi, phi @ rng.standard_normal(5) + 0.1 * rng.standard_normal(12)


def with_columns(x, cosine, u):
    columns = (x[1:-1], x[:-2], u[:, 0] * cosine, u[:, 1] * cosine, cosine)
    return np.column_stack(columns), x[2:]


@exercise(
    cases=path,
    hint="Write the equation of k = 2 with numbers: which x, which heading, which voltages?",
    mistakes={
        "The heading and the voltages must be those of step k-1: x(2) needs number 1 of both.": (
            lambda x, heading, u: with_columns(x, np.cos(heading[2:]), u[2:])
        ),
        "The voltages must be those of step k-1: x(2) needs u[1].": lambda x, heading, u: (
            with_columns(x, np.cos(heading[1:-1]), u[:-2])
        ),
        "x(k-1) and x(k-2) are exchanged: the column of a1 has x(k-1).": (
            lambda x, heading, u: (equations(x, heading, u)[0][:, [1, 0, 2, 3, 4]], x[2:])
        ),
        "The column of d1 has the cosine, too: look at the brackets.": lambda x, heading, u: (
            with_column(equations(x, heading, u)[0], 4, 1.0),
            x[2:],
        ),
        "The voltages are multiplied by the cosine of the heading.": lambda x, heading, u: (
            np.column_stack((x[1:-1], x[:-2], u[1:-1], np.cos(heading[1:-1]))),
            x[2:],
        ),
        "The sine belongs to y: x needs the cosine.": lambda x, heading, u: with_columns(
            x, np.sin(heading[1:-1]), u[1:-1]
        ),
        "The heading is in radians already: no conversion before the cosine.": (
            lambda x, heading, u: with_columns(x, np.cos(np.radians(heading[1:-1])), u[1:-1])
        ),
    },
)
def equations_of_x(x, heading, u):
    """Return (phi, y): the equations of the x axis, for the steps 2 to N - 1."""
    cosine = np.cos(heading[1:-1])
    columns = (x[1:-1], x[:-2], u[1:-1, 0] * cosine, u[1:-1, 1] * cosine, cosine)
    return np.column_stack(columns), x[2:]


equations = equations_of_x.right


def with_column(phi, column, value):
    phi[:, column] = value
    return phi


@exercise(
    cases=system,
    hint="The sum of squares is smallest where its derivative by theta is 0: five equations. "
    "Or look for a function in numpy.linalg.",
    mistakes={
        "This solves the first five equations: use all of them.": (
            lambda phi, y: np.linalg.solve(phi[:5], y[:5])
        ),
        "This is phi' y: it must be multiplied by the inverse of phi' phi.": (
            lambda phi, y: phi.T @ y
        ),
        "These are the errors: return the parameters.": (
            lambda phi, y: y - phi @ np.linalg.lstsq(phi, y)[0]
        ),
    },
    tolerance=1e-6,
)
def fit(phi, y):
    """Return the parameters (5,) whose errors y - phi theta have the smallest sum of squares."""
    return np.linalg.lstsq(phi, y)[0]


def covariance(phi):
    return np.linalg.inv(phi.T @ phi)


@exercise(
    cases=lambda rng: (rng.standard_normal((12, 5)), rng.uniform(0.1, 2)),
    hint="Which 5 x 5 matrix is inverted? Which of its numbers belong to one parameter alone?",
    mistakes={
        "These are variances: take the square root.": (
            lambda phi, sigma: sigma**2 * np.diag(covariance(phi))
        ),
        "sigma stands outside the square root.": (
            lambda phi, sigma: np.sqrt(sigma * np.diag(covariance(phi)))
        ),
        "phi' phi must be inverted.": lambda phi, sigma: sigma * np.sqrt(np.diag(phi.T @ phi)),
        "Invert the whole matrix first, then take its diagonal.": (
            lambda phi, sigma: sigma / np.sqrt(np.diag(phi.T @ phi))
        ),
        "This is without sigma.": lambda phi, sigma: np.sqrt(np.diag(covariance(phi))),
    },
)
def standard_errors(phi, sigma):
    """Return the standard errors (5,) for errors with the standard deviation sigma."""
    return sigma * np.sqrt(np.diag(np.linalg.inv(phi.T @ phi)))


def largest_error(control, n):
    """Return the largest standard error of a drive, relative to its parameter."""
    world = robsim.Simulation(robot="lab", boundary="unlimited", control=control, seed=1)
    return np.max(robsim.batch_estimate(world.run(n)).identifiability.relative)


def fault_of_inputs(voltages, n):
    """Return a sentence about inputs that are too large, or tell too little."""
    voltages = np.asarray(voltages, dtype=float)
    if not np.all((voltages >= LOW) & (voltages <= HIGH)):
        return f"all voltages must be from {LOW:g} to {HIGH:g} V."
    reached = largest_error(lambda step: tuple(voltages[step.k]), n)
    if not np.isfinite(reached):
        return "some parameter is not determined: the wheels must change, each in its own way."
    ratio = reached / largest_error(robsim.DriveAround(), n)
    if ratio <= ENOUGH:
        return None
    return f"the largest standard error is {ratio:.2f} times that of DriveAround."


@exercise(
    cases=lambda rng: (int(rng.integers(400, 800)),),
    hint="Which voltages have the most power? How long does the robot need to answer a change?",
    judge=fault_of_inputs,
)
def telling_inputs(n):
    """Return voltages (n, 2), each from -0.5 to 1.5 V, that tell more than `DriveAround`."""
    rng = np.random.default_rng(0)
    held = rng.choice((-0.5, 1.5), (n // 5 + 1, 2))  # each for 5 steps
    return np.repeat(held, 5, axis=0)[:n]
