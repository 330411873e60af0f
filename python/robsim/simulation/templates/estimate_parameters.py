"""The parameters of the robot, estimated as it drives.

Called at every step, before the measurement. Gets `step`, of which you need:
    step.sample      what was learned last: step.sample.phi (3, 5) and step.sample.y (3,), so that
                     y = sum(phi * parameters, axis=1); rows x, y (px) and heading (rad).
                     None at the start, after a bounce and where the robot was not seen
    step.estimator   the object that init_parameter_estimator made
Returns the parameters, (3, 5): rows x, y, heading, columns a1, a2, b1, b2, d1, as explained in
help(robsim.RobotModel). None: nothing new.
"""

ENABLED = False  # True: this stage is on


def estimate_parameters(step):
    """Give the estimator the newest sample."""
    if step.sample is None:
        return None
    # To try: learn from every tenth sample only. How much worse is the result?
    # if step.k % 10 != 0:
    #     return None
    return step.estimator.update(step.sample.phi, step.sample.y)
