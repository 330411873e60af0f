"""Wrong: it predicts as if the motors were off."""

import numpy as np
from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA


class FilterWithoutInput(KalmanFilter):
    """One that knows nothing of the motors."""

    def predict(self, u):
        """Predict with an input of 0 V."""
        super().predict(np.zeros(2))


estimate_state = FilterWithoutInput(MEASUREMENT_SIGMA, PROCESS_SIGMA)
