"""Make the estimator of the parameters. So far: keep the parameters of the model."""


class Estimator:
    """The state between two samples."""

    def __init__(self, theta):
        self.theta = theta

    def update(self, phi, y):
        # To do: y = sum(phi * theta, axis=1), with a row for each of x, y and the heading.
        return self.theta


def init_parameter_estimator(model):
    return Estimator(model.theta)
