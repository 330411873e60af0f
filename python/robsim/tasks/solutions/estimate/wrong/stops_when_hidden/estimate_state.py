"""Wrong: while the robot is hidden, it stays where it is."""

from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

import robsim


class StandingFilter(KalmanFilter):
    """One that does nothing without a measurement."""

    def __call__(self, step):
        """Return the old estimate where there is no measurement."""
        if step.measurement is None and self.x is not None:
            return robsim.Estimate(self.x[:3], self.P[:3, :3])
        return super().__call__(step)


estimate_state = StandingFilter(MEASUREMENT_SIGMA, PROCESS_SIGMA)
