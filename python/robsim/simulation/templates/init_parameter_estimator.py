"""The recursive estimator of the robot's parameters.

Called once, at the start. Gets the RobotModel of define_model.
Returns the estimator. At every step it is `step.estimator` in estimate_parameters.py, which is
off until you set ENABLED = True there. It may be of your own class, which needs a method
update(phi, y), with phi (3, 5) and y (3,), that returns the parameters, (3, 5).
"""

import robsim

ENABLED = True  # False: robsim's default instead of this file


def init_parameter_estimator(model):
    """Return the estimator: one filter of 5 parameters for each of x, y and the heading."""
    # To try: forget old samples, to track parameters that change.
    # return robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=0.99)
    return robsim.RecursiveLeastSquares(5, n_filters=3, forgetting=1.0)
