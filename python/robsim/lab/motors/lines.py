"""Motors behind a serial line or a UDP socket."""

from __future__ import annotations

import atexit
import sys
from contextlib import suppress
from typing import TYPE_CHECKING, Self
from weakref import WeakSet

from robsim._core import Line, LineError, MotorLink
from robsim.base.checks import check_float, check_int, check_text
from robsim.base.text import one_line, quoted

if TYPE_CHECKING:
    from serial import Serial
#: s; a robot stops automatically after this time without a message.
TTL = 0.3
#: s; the link stops the robot after this time without an input.
HOLD = 1.0
_open: WeakSet[LineMotors] = WeakSet()


class LineMotors(MotorLink):
    """A native link that stops the robot at the end of a ``with`` block and of the program."""

    def __init__(self, line: Line, address: str, *, ttl: float, hold: float) -> None:
        super().__init__(line, ttl=ttl, hold=hold)
        self._address = address
        _open.add(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        try:
            self.close()
        except OSError as trouble:
            if error is None:
                raise
            error.add_note(f"when the line to the robot was closed: {trouble}")

    def __repr__(self) -> str:
        state = ", closed" if self.is_closed else ", halted" if self.is_halted else ""
        return f"<{type(self).__name__} {quoted(self._address)}, ttl={self.ttl:g}{state}>"


@atexit.register
def _stop_all() -> None:
    links = list(_open)
    for link in links:  # all must stop, before the first wait
        link.halt()
    for link in links:
        with suppress(OSError, RuntimeError):  # the line is cut, or belongs to the parent process
            link.close()


class SerialMotors(LineMotors):
    """Motors of a robot on a serial line: call the object to send inputs.

    A native thread repeats the newest input and stops the robot, even without the interpreter. The
    robot stops automatically after `ttl` without a message. `stop`, `close`, the end of a ``with``
    block or of the program, and `hold` without an input stop the robot, too.

    This requires pyserial: ``pip install 'robsim[serial]'``. Many boards restart when their port is
    opened, and receive nothing for the next seconds.

    Parameters
    ----------
    port : str
        The device, such as ``"/dev/ttyUSB0"``; it is opened exclusively.
    baud_rate : int
        Speed of the line (bit/s).
    ttl : float
        Time to live of each input (s), 0.03 to 60: the robot stops automatically after this time
        without a message. The link resends the newest input three times per `ttl`.
    hold : float
        The link stops the robot after this time without an input (s).

    Raises
    ------
    robsim.lab.LineError
        If the port cannot be opened.
    ImportError
        If pyserial is missing.

    Examples
    --------
    >>> try:
    ...     robsim.lab.SerialMotors("/dev/no-such-port")
    ... except robsim.lab.LineError as error:
    ...     print(type(error).__name__)
    LineError
    """

    def __init__(
        self, port: str, baud_rate: int = 115200, *, ttl: float = TTL, hold: float = HOLD
    ) -> None:
        check_text("port", port)
        check_int("baud_rate", baud_rate, minimum=1, maximum=100_000_000)
        check_float("ttl", ttl, "s")
        check_float("hold", hold, "s", exclusive_minimum=0)
        self._serial = _opened(port, baud_rate)
        try:
            line = Line.of_descriptor(self._serial.fileno(), f"serial line {one_line(port)}")
            super().__init__(line, port, ttl=ttl, hold=hold)
        except BaseException:
            self._serial.close()
            raise

    def close(self) -> None:
        """Stop the robot and close the port; a second call does nothing.

        Raises
        ------
        robsim.lab.LineError
            If the line failed since the last input: the robot may not have received the stop.
        """
        try:
            super().close()
        finally:
            self._serial.close()


def _opened(port: str, baud_rate: int) -> Serial:
    if sys.platform == "win32":
        raise LineError(
            "SerialMotors works only on Linux and macOS; on Windows, send the inputs with your own "
            "function, which writes to pyserial's Serial"
        )
    try:
        from serial import Serial, SerialException
    except ImportError:
        raise ImportError(
            "SerialMotors requires pyserial, which is not installed: pip install 'robsim[serial]'"
        ) from None
    try:
        return Serial(port, baud_rate, exclusive=True)
    except SerialException as error:
        raise LineError(
            f"serial line {one_line(port)} cannot be opened: {_reason(error)}"
        ) from error


def _reason(error: OSError) -> str:
    reasons = {
        2: "there is no such device; is the cable plugged in? (python -m serial.tools.list_ports)",
        11: "another program has opened it",
        13: "no permission; on Linux, add yourself to the group of the device (often dialout)",
    }
    return reasons.get(error.errno or 0, one_line(error))


class UdpMotors(LineMotors):
    """Motors of a robot that listens to UDP: call the object to send inputs.

    A native thread repeats the newest input and stops the robot, even without the interpreter. The
    robot stops automatically after `ttl` without a message. `stop`, `close`, the end of a ``with``
    block or of the program, and `hold` without an input stop the robot, too.

    Parameters
    ----------
    address : str
        Name or number of the robot's host, with the port: ``"192.168.4.1:5005"``,
        ``"[fe80::1]:5005"``; the port may be passed as `port` instead.
    port : int, optional
        The port of the robot.
    ttl : float
        Time to live of each input (s), 0.03 to 60: the robot stops automatically after this time
        without a message. The link resends the newest input three times per `ttl`.
    hold : float
        The link stops the robot after this time without an input (s).

    Raises
    ------
    robsim.lab.LineError
        If the host is unknown. Whether a robot listens is only known after the first inputs.

    Examples
    --------
    A robot has an address of the network, such as ``"192.168.4.1:5005"``.

    >>> with robsim.lab.SimulatedLab() as lab, robsim.lab.UdpMotors(lab.address) as motors:
    ...     sent_at = motors((0.5, 0.5))
    ...     print(motors.ttl, motors.is_halted)
    0.3 False
    """

    def __init__(
        self, address: str, port: int | None = None, *, ttl: float = TTL, hold: float = HOLD
    ) -> None:
        host, number = _host_and_port(check_text("address", address), port)
        check_float("ttl", ttl, "s")
        check_float("hold", hold, "s", exclusive_minimum=0)
        name = f"[{host}]:{number}" if ":" in host else f"{host}:{number}"
        super().__init__(Line.udp_to(host, number), name, ttl=ttl, hold=hold)


def _host_and_port(address: str, port: int | None) -> tuple[str, int]:
    host = address
    if port is None:
        host, _, text = address.rpartition(":")
        if not (text.isascii() and text.isdigit() and host):
            raise ValueError(
                "address must be HOST:PORT, such as '192.168.4.1:5005', if port is omitted, "
                f"got {quoted(address)}"
            )
        port = int(text[:6])
    host = host.removeprefix("[").removesuffix("]")
    if not host or not host.isprintable():
        raise ValueError(f"address must name a host, got {quoted(address)}")
    return host, check_int("port", port, minimum=1, maximum=65535)
