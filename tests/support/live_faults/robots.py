"""Robots that note what they hear, with native times, and the motors that drive them."""

import os
import select
import socket
import threading
import tty

import motor_lines
from robsim.lab import MotorReceiver, SerialMotors, UdpMotors

TTL = 0.15  # s, of native links
NATIVE = ("udp", "serial")
KINDS = (*NATIVE, "python")


class Relay:
    """A cable that can be cut: it carries bytes from a line to a robot."""

    def __init__(self, source, target):
        self.source, self.target = source, target
        self.is_cut = self.is_over = False
        self._thread = threading.Thread(target=self._carry)
        self._thread.start()

    def _carry(self):
        while not self.is_over:
            if select.select([self.source], [], [], 0.02)[0]:
                data = os.read(self.source, 2048)
                if not self.is_cut:
                    os.write(self.target, data)

    def close(self):
        self.is_over = True
        self._thread.join()


class Robot:
    """A robot at a line: of UDP or a pseudo-terminal, through a relay if `is_cuttable`."""

    def __init__(self, kind, is_cuttable=False):
        self.relay, self._open = None, []
        if kind == "serial":
            end, slave = os.openpty()
            tty.setraw(slave)
            self.address = os.ttyname(slave)
            self._open = [end, slave]
            if is_cuttable:
                near, end = (pair.detach() for pair in socket.socketpair())
                self._open += [near, end]
                self.relay = Relay(self._open[0], near)
            self.receiver = MotorReceiver(descriptor=end, answers=not is_cuttable)
            return
        self.receiver = MotorReceiver()
        port = self.receiver.port
        if is_cuttable:
            near, far = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
            near.bind(("127.0.0.1", 0))
            far.connect(("127.0.0.1", port))
            port = near.getsockname()[1]
            self._open = [near.detach(), far.detach()]
            self.relay = Relay(*self._open)
        self.address = f"127.0.0.1:{port}"

    def heard(self):
        """A list of (t, u1, u2): what it acts upon from then on."""
        return [(event.t, *map(float, event.u)) for event in self.receiver.events]

    def drives(self):
        heard = self.heard()
        return bool(heard) and any(heard[-1][1:])

    def stood(self):
        """When it stood after its last input; None if it never drove."""
        heard = self.heard()
        driving = [i for i, (_, *u) in enumerate(heard) if any(u)]
        return heard[driving[-1] + 1][0] if driving else None

    def cut(self, is_silent):
        """Cut the line: the sender is told nothing, or that nobody is there."""
        if is_silent:
            self.relay.is_cut = True
            return
        self.relay.close()
        self.relay = None
        is_serial = len(self._open) == 4
        for _ in range(1 + is_serial):
            os.close(self._open.pop(0))

    def close(self):
        if self.relay is not None:
            self.relay.close()
        self.receiver.close()
        for end in self._open:
            os.close(end)


def motors_at(kind, address):
    """Motors of a kind, that drive the robot at an address."""
    if kind == "python":
        return PlainMotors(address)
    return (SerialMotors if kind == "serial" else UdpMotors)(address, ttl=TTL)


class PlainMotors:
    """A callable with a socket, in Python alone, as a user writes it; the robot obeys a minute."""

    failing = ()
    error = OSError

    def __init__(self, address):
        host, port = address.split(":")
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect((host, int(port)))
        self._number = self.calls = 0
        self._lock = threading.Lock()

    def __call__(self, u):
        with self._lock:
            self.calls += 1
            if self.calls in self.failing:
                raise self.error("of the fault")
            self._number += 1
            self._socket.send(motor_lines.drive_line(self._number, *map(float, u)))

    def close(self):
        self._socket.close()
