"""The controller along the path, for you to write. sheet.md describes the task."""

from task import MAXIMUM_VOLTAGE, WAYPOINT_RADIUS, WAYPOINTS

reached = []  # the numbers of the waypoints


def control(step):
    """Return the voltages of the left and the right motor (V)."""
    if step.measurement is None:  # the robot is not seen
        return 0.0, 0.0
    x, y, _ = step.measurement.pose
    for number, (goal_x, goal_y) in enumerate(WAYPOINTS):
        if abs(x - goal_x) < WAYPOINT_RADIUS and abs(y - goal_y) < WAYPOINT_RADIUS:
            reached.append(number)
    return 0.5 * MAXIMUM_VOLTAGE, 0.4 * MAXIMUM_VOLTAGE
