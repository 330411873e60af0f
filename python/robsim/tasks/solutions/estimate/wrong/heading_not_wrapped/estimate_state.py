"""Wrong: where the heading goes from pi to -pi, it sees a full turn."""

from kalman import KalmanFilter
from task import MEASUREMENT_SIGMA, PROCESS_SIGMA


class UnwrappedFilter(KalmanFilter):
    """One that forgets that headings are angles."""

    def innovation(self, z):
        """Return measurement minus prediction, as if all were numbers."""
        return z - self.x[:3]


estimate_state = UnwrappedFilter(MEASUREMENT_SIGMA, PROCESS_SIGMA)
