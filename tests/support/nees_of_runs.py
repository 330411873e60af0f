"""The NEES of the runs of a campaign at every step, and the verdicts on some runs together."""

import numpy as np

from robsim.estimation import nees, nees_consistency, wrapped_error

_COORDINATES = 3


def nees_by_step(trace):
    """The NEES of the estimated pose at each step: a metric."""
    errors = wrapped_error(trace.pose_estimated, trace.pose_true)
    return {f"{k:04}": value for k, value in enumerate(nees(errors, trace.covariance))}


def reports(values, runs):
    """The reports on every so many runs, of values (R, N) of R runs in N steps.

    A verdict depends on the NEES alone: here it is that of (sqrt(NEES), 0, 0) and the identity.
    """
    errors = np.zeros((*values.shape, _COORDINATES))
    errors[..., 0] = np.sqrt(values)
    P = np.eye(_COORDINATES)
    covariances = np.broadcast_to(P, (runs, values.shape[1], *P.shape))
    return [
        nees_consistency(errors[first : first + runs], covariances)
        for first in range(0, len(errors), runs)
    ]
