"""Keep the last measured pose."""

import numpy as np
from task import AREA, MEASUREMENT_SIGMA

import robsim

R = np.diag(np.square(MEASUREMENT_SIGMA))


class LastPose:
    """The last measured pose, and at first the centre of the area."""

    pose = (AREA[0] / 2, AREA[1] / 2, 0.0)

    def __call__(self, step):
        """Return it with the covariance of a measurement."""
        if step.measurement is not None:
            self.pose = step.measurement.pose
        return robsim.Estimate(self.pose, R)


estimate_state = LastPose()
