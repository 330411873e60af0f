"""The motion of the simulated robot.

Called at every step from step 1 on, as the first stage; at step 0 the robot stands at the start.
Gets `world`:
    world.k, world.t, world.dt   number of the step, time (s), time between two steps (s)
    world.model                  the RobotModel of the world: from define_model, unless
                                 mismatch=... is given
    world.pose_1, world.pose_2   the true poses of step k-1 and of step k-2: x, y (px),
                                 heading (rad); at step 1 both are the start
    world.last_u                 the voltages that act until step k, from step k-1 unless
                                 motor_delay=... is given: left, right motor (V)
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
