"""State estimation: the pose of the robot and its covariance.

Called at every step, after the measurement. Gets `step`. You need:
    step.measurement   the result of measure: step.measurement.pose is x, y (px), heading (rad).
                       None: not seen, or ENABLED = False in measure.py
    step.parameters    the last result of estimate_parameters, (3, 5), or None
    step.last_u        the voltages of the previous step: left, right motor (V)
    step.dt            the time since the previous step (s)
Returns an Estimate: the pose, x, y (px), heading (rad), and its covariance, (3, 3).
"""

import numpy as np

import robsim

ENABLED = False  # True: this stage is on

# Variances of x, y (px^2) and of the heading (rad^2).
MEASURED = np.diag((0.5**2, 0.5**2, 0.01**2))  # of a measurement
ONE_SECOND = np.diag((125.0, 125.0, 0.0125))  # added per second without a measurement
AT_FIRST = np.diag((600.0**2, 600.0**2, 2.0**2))  # of the initial estimate


class LastPose:
    """Keep the last measured pose, with a covariance that grows until the next measurement.

    Its memory is in self, so that two runs do not share it.
    """

    def __init__(self):
        self.forget()

    def forget(self):
        """Reset to the initial estimate: the centre of the work area, with a large covariance."""
        self.pose, self.covariance = (600.0, 600.0, 0.0), AT_FIRST

    def __call__(self, step):
        """Return the estimate of a step."""
        if step.k == 0:  # a run begins
            self.forget()
        if step.measurement is not None:
            self.pose, self.covariance = step.measurement.pose, MEASURED
        else:
            self.covariance = self.covariance + step.dt * ONE_SECOND
        # To try: a covariance that grows faster, the larger the voltages are.
        # self.covariance = self.covariance + step.dt * (step.last_u @ step.last_u) * ONE_SECOND
        return robsim.Estimate(self.pose, self.covariance)


estimate_state = LastPose()

if __name__ == "__main__":  # python estimate_state.py checks the estimator
    print(robsim.check_estimator(LastPose))
