"""Wrong: it corrects away from the sample."""

from recursive_least_squares import RecursiveLeastSquares


class WrongSign(RecursiveLeastSquares):
    """One that takes prediction minus output for the error."""

    def update_axis(self, axis, phi, y):
        """Take the sample of an axis into account, the wrong way."""
        prediction = phi @ self.theta[axis]
        super().update_axis(axis, phi, prediction - (y - prediction))


def init_parameter_estimator(model):
    """Return the estimator."""
    return WrongSign(model.theta)
