"""The motion of the simulated robot.

Called at every step, as the first stage. Gets `world`:
    world.k, world.t, world.dt   number of the step, time (s), time between two steps (s)
    world.model                  the RobotModel of define_model
    world.pose_1, world.pose_2   the true poses of step k-1 and of step k-2:
                                 x, y (px), heading (rad)
    world.last_u                 the voltages of step k-1: left, right motor (V)
Returns the new pose: x, y (px), heading (rad).
x points right and y down; the heading is measured from +x towards +y, clockwise on the image.
"""

ENABLED = True  # False: robsim's default instead of this file


def evaluate_model(world):
    """Return the new pose by the model's own equations."""
    # To try: from t = 5 s on, the right motor gets half of its voltage.
    # left, right = world.last_u
    # if world.t >= 5:
    #     return world.model.predict(world.pose_1, world.pose_2, (left, right / 2))
    # To try: wheels that do not slip sideways.
    # import robsim
    # return robsim.Unicycle()(world)
    return world.model.predict(world.pose_1, world.pose_2, world.last_u)
