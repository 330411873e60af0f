"""Wrong: it takes the model for exact."""

from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA

estimate_state = KalmanFilter(MEASUREMENT_SIGMA, (0.0, 0.0, 0.0))
