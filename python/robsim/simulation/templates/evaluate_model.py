"""How the simulated robot moves.

Called at every step, first of all. Gets `world`:
    world.k, world.t, world.dt   number of the step, time (s), time between two steps (s)
    world.model                  the RobotModel of define_model
    world.last, world.before     the true poses of the last step and of the one before:
                                 x, y (px), heading (rad)
    world.u                      the voltages of the last step: left, right motor (V)
Returns the new pose: x, y (px), heading (rad).
x goes to the right and y down; the heading counts from +x towards +y, clockwise on the picture.
"""

ENABLED = True  # False: robsim's own default instead of this file


def evaluate_model(world):
    """Return the new pose by the model's own equations."""
    # To try: from t = 5 s on the right motor gets half of what the controller asks for.
    # left, right = world.u
    # if world.t >= 5:
    #     return world.model.predict(world.last, world.before, (left, right / 2))
    # To try: wheels that do not slip sideways.
    # import robsim
    # return robsim.Unicycle()(world)
    return world.model.predict(world.last, world.before, world.u)
