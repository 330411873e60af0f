"""Wrong: it believes the model too little, with four times the process noise."""

import numpy as np
from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

estimate_state = KalmanFilter(MEASUREMENT_SIGMA, 4 * np.array(PROCESS_SIGMA))
