"""Robots that note what they hear, with native times, and the motors that drive them."""

import os
import select
import socket
import threading
import tty

import motor_lines
from robsim.motors import LineError, MotorReceiver, RecordedMotors, SerialMotors, UdpMotors

TTL = 0.15  # s, of native links
KINDS = ("udp", "serial", "python", "recorded")
NATIVE = ("udp", "serial")


class Relay:
    """A cable that can be cut: it carries bytes from a line to a robot."""

    def __init__(self, source, target):
        self._source, self._target = source, target
        self._wake = os.pipe()
        self._is_cut = False
        self._thread = threading.Thread(target=self._carry)
        self._thread.start()

    def _carry(self):
        while True:
            ready, _, _ = select.select([self._source, self._wake[0]], [], [])
            if self._wake[0] in ready:
                return
            data = os.read(self._source, 2048)
            if not self._is_cut:
                os.write(self._target, data)

    def cut(self):
        """Carry nothing from now on; the sender is told nothing."""
        self._is_cut = True

    def close(self):
        os.write(self._wake[1], b"!")
        self._thread.join()
        for end in self._wake:
            os.close(end)


class LineRobot:
    """A robot at a line: of UDP or a pseudo-terminal, through a relay if `is_cuttable`."""

    def __init__(self, kind, is_cuttable=False):
        self.kind = kind
        self._open = []
        self.relay = None
        if kind == "serial":
            self._at_serial_line(is_cuttable)
        else:
            self._at_udp(is_cuttable)

    def _at_serial_line(self, is_cuttable):
        master, slave = os.openpty()
        tty.setraw(slave)
        self._open = [master, slave]
        self.address = os.ttyname(slave)
        end = master
        if is_cuttable:
            near, end = (pair.detach() for pair in socket.socketpair())
            self._open += [near, end]
            self.relay = Relay(master, near)
        self.receiver = MotorReceiver(descriptor=end, answers=not is_cuttable)

    def _at_udp(self, is_cuttable):
        self.receiver = MotorReceiver()
        port = self.receiver.port
        if is_cuttable:
            near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            near.bind(("127.0.0.1", 0))
            port = near.getsockname()[1]
            far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            far.connect(("127.0.0.1", self.receiver.port))
            self._open = [near.detach(), far.detach()]
            self.relay = Relay(*self._open)
        self.address = f"127.0.0.1:{port}"

    def motors(self):
        """Motors of this kind, that drive it."""
        if self.kind == "serial":
            return SerialMotors(self.address, ttl=TTL)
        if self.kind == "udp":
            return UdpMotors(self.address, ttl=TTL)
        return PlainMotors(self.address)

    def heard(self):
        """A list of (t, u1, u2): what it acts upon from then on."""
        return [(event.t, *map(float, event.u)) for event in self.receiver.events]

    def cut(self, is_silent):
        """Cut the line: the sender is told nothing, or that nobody is there."""
        if is_silent:
            self.relay.cut()
            return
        self.relay.close()
        self.relay = None
        os.close(self._open.pop(0))
        if self.kind == "serial":
            os.close(self._open.pop(0))

    def close(self):
        if self.relay is not None:
            self.relay.close()
        self.receiver.close()
        for end in self._open:
            os.close(end)


class PlainMotors:
    """A callable with a socket, in Python alone, as a user writes it; the robot obeys a minute."""

    failing = ()
    error = OSError

    def __init__(self, address):
        host, port = address.split(":")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((host, int(port)))
        self._number = 0
        self._lock = threading.Lock()
        self.calls = 0

    def __call__(self, u):
        with self._lock:
            self.calls += 1
            if self.calls in self.failing:
                raise self.error("of the fault")
            self._number += 1
            line = motor_lines.drive_line(self._number, *map(float, u))
            self._socket.send(line)

    def close(self):
        self._socket.close()


class RecordingRobot:
    """Motors that are the robot themselves."""

    kind = "recorded"
    relay = None

    def __init__(self):
        self._motors = RecordedMotors()

    def motors(self):
        return self._motors

    def heard(self):
        motors = self._motors
        return [
            (t, *u) for t, u in zip(motors.times.tolist(), motors.inputs.tolist(), strict=False)
        ]

    def close(self):
        self._motors.close()


def robot_of(kind, is_cuttable=False):
    return RecordingRobot() if kind == "recorded" else LineRobot(kind, is_cuttable)


def closed(motors):
    """Close motors whose line may be cut."""
    try:
        motors.close()
    except LineError:
        return
