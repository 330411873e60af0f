"""The controller: computes the motor voltages.

Called at every step, as the last stage. Gets `step`, the data that the robot's software may use:
    step.k, step.t, step.dt   number of the step, time (s), time between two steps (s)
    step.measurement          step.measurement.pose is x, y (px), heading (rad). None: not seen,
                              or ENABLED = False in measure.py
    step.estimate             the same from estimate_state.py: step.estimate.pose, or None
    step.parameters           the parameters of the robot from estimate_parameters.py, or None
    step.last_u               the voltages of the previous step: left, right motor (V)
    step.frame, step.blobs    the camera's image and its coloured blobs.
Returns the voltages of the left and of the right motor (V).
x points right and y down; the heading is measured from +x towards +y, clockwise on the image.
"""

ENABLED = True  # False: robsim's default instead of this file


def control(step):
    """Turn slowly to the right on the spot."""
    # To try: a curve.
    # return 0.3, 0.28
    # To try: stop when facing down. For this, set ENABLED = True in measure.py.
    # if step.measurement is not None and step.measurement.pose[2] > 1.57:
    #     return 0.0, 0.0
    return 0.05, -0.05
