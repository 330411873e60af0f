"""The line to a real robot: what sends inputs, what limits them, and the robot's end of the line.

All that sends is callable, ``motors(u)``, and has ``stop`` and ``close``. ``PROTOCOL.md`` in this
folder says what goes over the line, and what a robot must do.
"""

from robsim._core import HaltedError, Limits, LineCounts, LineError, MotorEvent, MotorReceiver
from robsim.lab.motors.lines import SerialMotors, UdpMotors
from robsim.lab.motors.recorded import RecordedMotors

__all__ = [
    "HaltedError",
    "Limits",
    "LineCounts",
    "LineError",
    "MotorEvent",
    "MotorReceiver",
    "RecordedMotors",
    "SerialMotors",
    "UdpMotors",
]
