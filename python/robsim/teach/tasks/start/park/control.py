"""The controller that parks the robot, for you to write. sheet.md describes the task."""

from task import GOAL, MAXIMUM_VOLTAGE


def control(step):
    """Return the voltages of the left and the right motor (V)."""
    if step.measurement is None:  # the robot is not seen
        return 0.0, 0.0
    x, _, heading = step.measurement.pose
    if abs(x - GOAL[0]) > 20 and abs(heading) < 1:
        return 0.5 * MAXIMUM_VOLTAGE, 0.4 * MAXIMUM_VOLTAGE
    return 0.0, 0.0
