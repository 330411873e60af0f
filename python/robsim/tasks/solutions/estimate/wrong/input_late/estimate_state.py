"""Wrong: it predicts with the input of the step before the last."""

import numpy as np
from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA


class LateFilter(KalmanFilter):
    """One that mixes up the steps of its inputs."""

    last_u = np.zeros(2)

    def predict(self, u):
        """Predict with the input of the call before."""
        super().predict(self.last_u)
        self.last_u = u


estimate_state = LateFilter(MEASUREMENT_SIGMA, PROCESS_SIGMA)
