"""Online estimation of the robot's parameters.

Called at every step, before the measurement. Gets `step`. You need:
    step.sample      the newest sample: regressor step.sample.phi (3, 5), output step.sample.y (3,),
                     y = sum(phi * parameters, axis=1); rows x, y (px) and heading (rad).
                     It is None at the start, after a bounce, after lost frames, and when
                     the robot was not seen.
    step.estimator   the object from init_parameter_estimator.
Returns the parameters, (3, 5): rows x, y, heading, columns a1, a2, b1, b2, d1. They are explained
in help(robsim.RobotModel). None: no update.
"""

ENABLED = False  # True: this stage is on


def estimate_parameters(step):
    """Give the estimator the newest sample."""
    if step.sample is None:
        return None
    # To try: use every tenth sample only. How much worse is the result?
    # if step.k % 10 != 0:
    #     return None
    return step.estimator.update(step.sample.phi, step.sample.y)
