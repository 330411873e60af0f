"""The model of the robot, as known to the robot's software.

Called once, at the start. Has no argument.
Returns a RobotModel. The simulated world also moves the robot by it, unless the world should
differ: robsim.Simulation(mismatch=...). The callbacks evaluate_model and init_parameter_estimator
also get it.
"""

import robsim

ENABLED = True  # False: robsim's default instead of this file


def define_model():
    """Return the model of the robot."""
    # To try: a weaker right motor. Does the robot still turn on the spot?
    # return robsim.RobotModel(robsim.RobotParameters(motor_gain=(0.05, 0.04)))
    return robsim.RobotModel(
        robsim.RobotParameters(
            mass=0.3,  # kg
            inertia=0.1,  # kg m^2
            linear_friction=0.1,  # N s/m
            angular_friction=0.1,  # N m s/rad
            wheel_radius=0.03,  # m
            wheel_base=0.11,  # m, distance of the wheels.
            motor_gain=(0.05, 0.05),  # N m/V, left, right motor
            motor_offset=(1e-6, 1e-6),  # N m at 0 V, left, right motor
            dt=0.2,  # s, time between two steps
        )
    )
