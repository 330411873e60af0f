"""An extended Kalman filter that takes the model for less exact than it is."""

import numpy as np
from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

estimate_state = KalmanFilter(MEASUREMENT_SIGMA, 1.4 * np.array(PROCESS_SIGMA))
