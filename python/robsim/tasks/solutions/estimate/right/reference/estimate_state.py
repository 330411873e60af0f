"""An extended Kalman filter with the noises of the world."""

from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

estimate_state = KalmanFilter(MEASUREMENT_SIGMA, PROCESS_SIGMA)
