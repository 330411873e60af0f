"""Wrong: it believes the measurements too little, with four times their standard deviations."""

import numpy as np
from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

estimate_state = KalmanFilter(4 * np.array(MEASUREMENT_SIGMA), PROCESS_SIGMA)
