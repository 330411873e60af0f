"""An unscented Kalman filter, as robsim has one."""

from task import MEASUREMENT_SIGMA, PROCESS_SIGMA

from robsim.reference import UnscentedKalmanFilter

estimate_state = UnscentedKalmanFilter(
    measurement_sigma=MEASUREMENT_SIGMA, process_sigma=PROCESS_SIGMA
)
