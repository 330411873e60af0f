"""The answers of the notebook 11_the_model, and mistakes that students make."""

import numpy as np

import robsim
from robsim.teach.exercises.exercise import exercise


@exercise(
    cases=lambda rng: tuple(rng.uniform((0.1, 0.05, 0.1), (1, 0.5, 0.5))),
    hint="Collect the factors of x(k), of x(k-1) and of x(k-2). Which one do you divide by?",
    mistakes={
        "This equation still has a factor before x(k): divide by it.": (
            lambda m, F, T: (2 * m / T**2 + F / T, -m / T**2, 1)
        ),
        "a2 has the wrong sign: in the result, x(k-2) stands on the other side.": (
            lambda m, F, T: ((2 * m + F * T) / (m + F * T), m / (m + F * T), T**2 / (m + F * T))
        ),
        "These are forward differences: the velocity takes x(k) and x(k-1).": (
            lambda m, F, T: (2 - F * T / m, F * T / m - 1, T**2 / m)
        ),
        "The second difference is divided by T, and must be divided by T squared.": (
            lambda m, F, T: ((2 * m + F) / (m + F), -m / (m + F), T / (m + F))
        ),
        "The velocity lacks its T: x(k) - x(k-1) is a distance.": lambda m, F, T: (
            (2 * m + F * T**2) / (m + F * T**2),
            -m / (m + F * T**2),
            T**2 / (m + F * T**2),
        ),
        "The second difference has x(k-1) twice, and this has it once.": (
            lambda m, F, T: (1.0, -m / (m + F * T), T**2 / (m + F * T))
        ),
        "a1 and a2 are right. g is not: the force has the same divisor.": (
            lambda m, F, T: ((2 * m + F * T) / (m + F * T), -m / (m + F * T), 1)
        ),
    },
)
def coefficients(m, F, T):
    """Return (a1, a2, g) for the mass m, the friction F and the step T (s)."""
    divisor = m / T**2 + F / T
    return (2 * m / T**2 + F / T) / divisor, -m / T**2 / divisor, 1 / divisor


def steps(rng):
    theta = robsim.RobotModel().theta * rng.uniform(0.8, 1.2, (3, 5))
    theta[:, 4] = rng.uniform(0.01, 0.1, 3)
    pose_1 = rng.uniform((0, 0, -3), (1200, 1200, 3))
    return theta, pose_1, pose_1 - rng.uniform(-0.3, 0.3, 3), rng.uniform(-1, 1, 2)


def with_factors(theta, pose_1, pose_2, u, factors):
    a1, a2, b1, b2, d1 = theta.T
    return a1 * pose_1 + a2 * pose_2 + (b1 * u[0] + b2 * u[1] + d1) * factors


def direction(heading):
    return np.array([np.cos(heading), np.sin(heading), 1])


def new_heading(theta, pose_1, pose_2, u):
    turned = with_factors(theta, pose_1, pose_2, u, direction(pose_1[2]))[2]
    return with_factors(theta, pose_1, pose_2, u, direction(turned))


def offset_apart(theta, pose_1, pose_2, u):
    a1, a2, b1, b2, d1 = theta.T
    return a1 * pose_1 + a2 * pose_2 + (b1 * u[0] + b2 * u[1]) * direction(pose_1[2]) + d1


def wrapped(theta, pose_1, pose_2, u):
    pose = with_factors(theta, pose_1, pose_2, u, direction(pose_1[2]))
    return np.array([*pose[:2], robsim.wrap_angle(pose[2])])


@exercise(
    cases=steps,
    hint="Write x(k) with the entries of theta[0] first. What is different in the other two rows?",
    mistakes={
        "The force points along the heading of step k-1, and this takes step k-2.": (
            lambda theta, pose_1, pose_2, u: with_factors(
                theta, pose_1, pose_2, u, direction(pose_2[2])
            )
        ),
        "The force points along the heading of step k-1, and this takes the new one.": new_heading,
        "y has its own row, theta[1]: this takes the row of x.": lambda theta, *given: next_pose(
            theta[[0, 0, 2]], *given
        ),
        "Steps k-1 and k-2 are exchanged: a1 belongs to pose_1.": (
            lambda theta, pose_1, pose_2, u: with_factors(
                theta, pose_2, pose_1, u, direction(pose_1[2])
            )
        ),
        "y takes the sine: this has the cosine in x and y.": (
            lambda theta, pose_1, pose_2, u: with_factors(
                theta, pose_1, pose_2, u, direction(pose_1[2])[[0, 0, 2]]
            )
        ),
        "x takes the cosine, y the sine: here they are exchanged.": (
            lambda theta, pose_1, pose_2, u: with_factors(
                theta, pose_1, pose_2, u, direction(pose_1[2])[[1, 0, 2]]
            )
        ),
        "Without cosine and sine, the robot drives to the lower right at any heading.": (
            lambda theta, pose_1, pose_2, u: with_factors(theta, pose_1, pose_2, u, np.ones(3))
        ),
        "The heading takes neither cosine nor sine: a torque has no direction in the picture.": (
            lambda theta, pose_1, pose_2, u: with_factors(
                theta, pose_1, pose_2, u, direction(pose_1[2])[[0, 1, 0]]
            )
        ),
        "d1 is part of the force, too: the cosine or the sine multiplies the whole sum.": (
            offset_apart
        ),
        "Do not wrap the heading: here it continues beyond pi.": wrapped,
        "The voltages are exchanged: u[0] is the left one, and belongs to b1.": (
            lambda theta, pose_1, pose_2, u: with_factors(
                theta, pose_1, pose_2, u[::-1], direction(pose_1[2])
            )
        ),
    },
)
def next_pose(theta, pose_1, pose_2, u):
    """Return the pose of step k: array (3,) of x, y, heading (rad)."""
    a1, a2, b1, b2, d1 = theta.T
    heading = pose_1[2]
    factors = np.array([np.cos(heading), np.sin(heading), 1])
    return a1 * pose_1 + a2 * pose_2 + (b1 * u[0] + b2 * u[1] + d1) * factors


def real_poles(rng):
    """Return a1 and a2 for two real poles; in half of the cases one is 1, as for the robot."""
    smaller = rng.uniform(-0.8, 0.8)
    larger = rng.choice((1.0, smaller + rng.uniform(0.05, 0.2)))
    return smaller + larger, -smaller * larger


def no_poles(result, a1, a2):
    """Return the fault of these poles, or None."""
    others = {
        "two signs are wrong: bring a1 z and a2 to the side of z squared.": np.roots([1, a1, a2]),
        "the sign of a2 is wrong: bring it to the side of z squared, too.": np.roots([1, -a1, a2]),
        "the sign of a1 is wrong: bring it to the side of z squared, too.": np.roots([1, a1, -a2]),
        "np.roots takes the coefficient of the highest power first.": np.roots([-a2, -a1, 1]),
        "the 2 divides the square root, too.": 2 * poles.right(a1, a2) - a1 / 2,
        "the 2 divides a1, too.": poles.right(a1, a2) + a1 / 2,
    }
    if np.allclose(result, poles.right(a1, a2)):
        return None
    if np.allclose(np.sort(result)[::-1], poles.right(a1, a2)):
        return "the larger one comes first."
    for sentence, other in others.items():
        if np.allclose(np.sort_complex(result), np.sort_complex(other)):
            return sentence
    return "put each of them into z squared = a1 z + a2: both sides must be equal."


@exercise(
    cases=real_poles,
    judge=no_poles,
    hint="Bring all terms to one side. Which coefficients does the quadratic equation have?",
)
def poles(a1, a2):
    """Return the two poles of x(k) = a1 x(k-1) + a2 x(k-2), the larger one first: array (2,)."""
    root = np.sqrt(a1**2 + 4 * a2)
    return np.array([a1 + root, a1 - root]) / 2


def physical(rng):
    least = (0.1, 0.1, 0.1, 0.1, 0.02, 0.1, 0.03, 0.03, 0.006, 0.001)
    most = (0.5, 0.5, 0.5, 0.5, 0.05, 0.3, 0.1, 0.1, 0.01, 0.005)
    return (rng.uniform(least, most),)


def numbers(robot):
    """Return the fifteen numbers, without their repetitions."""
    m, inertia, Fv, Fw, r, L, *motors = robot
    alpha, beta = np.reshape(motors, (2, 2))
    dt = 0.2
    along = 1 / (r * (m / dt**2 + Fv / dt))
    turn = L / (2 * r * (inertia / dt**2 + Fw / dt))
    return {
        "a1 and a2 of X and Y": m / (m + Fv * dt),
        "b1 and b2 of X and Y": along * alpha,
        "d1 of X and Y": along * beta.sum(),
        "a1 and a2 of P": inertia / (inertia + Fw * dt),
        "b1 and b2 of P": turn * alpha,
        "d1 of P": turn * (beta[0] - beta[1]),
    }


def moves_differently(result, robot):
    """Return what tells a twin from the robot."""
    if not np.all(np.asarray(result) > 0):
        return "all physical parameters are positive."
    if not np.isclose(result[0], 2 * robot[0]):
        return f"the mass must be {2 * robot[0]:.4g}."
    other, own = numbers(result), numbers(robot)
    changed = [name for name in own if not np.allclose(other[name], own[name], 1e-6, 0)]
    return f"it has other numbers {', '.join(changed)}." if changed else None


@exercise(
    cases=physical,
    judge=moves_differently,
    hint="By which number may you multiply both sides of an equation of motion? And which "
    "parameters stand in more than one equation?",
)
def twin(robot):
    """Return another robot with twice the mass and the same fifteen numbers: array (10,)."""
    return robot * [2, 2, 2, 2, 1, 1, 2, 2, 2, 2]
