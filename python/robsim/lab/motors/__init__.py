"""The link to a real robot: senders of inputs, their limits, and the robot's receiver.

All senders are callable, ``motors(u)``, and have ``stop`` and ``close``. ``PROTOCOL.md`` in this
folder defines the messages, and the duties of a robot.
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
