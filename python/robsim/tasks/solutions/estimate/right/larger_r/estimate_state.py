"""An extended Kalman filter that takes the measurements for less exact than they are."""

import numpy as np
from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

estimate_state = KalmanFilter(1.4 * np.array(MEASUREMENT_SIGMA), PROCESS_SIGMA)
