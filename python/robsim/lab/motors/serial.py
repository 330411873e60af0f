"""Motors behind a serial line."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from robsim._core import Line, LineError
from robsim.base.checks import check_float, check_int, check_text
from robsim.base.text import one_line
from robsim.lab.motors._line_motors import HOLD, TTL, LineMotors

if TYPE_CHECKING:
    from serial import Serial


class SerialMotors(LineMotors):
    """Motors of a robot at a serial line: send them inputs by calling it.

    A native thread repeats the newest input and stops the robot; it needs no interpreter. The
    robot stops by itself when it hears nothing for `ttl`. It is stopped by `stop`, `close`, the end
    of a ``with`` block or of the program, and where no input is sent for `hold`.

    It needs pyserial: ``pip install 'robsim[serial]'``. Many boards start anew when their port is
    opened, and hear nothing for the next seconds.

    Parameters
    ----------
    port : str
        The device, such as ``"/dev/ttyUSB0"``; it is opened for this program alone.
    baud_rate : int
        Speed of the line (bit/s).
    ttl : float
        Time to live of each input (s), 0.03 to 60: the robot stops by itself when it hears nothing
        for so long. The newest input is sent again each third of it.
    hold : float
        The link stops the robot when no input is sent for so long (s).

    Raises
    ------
    robsim.lab.LineError
        If the port cannot be opened.
    ImportError
        If pyserial is not there.
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
        """Stop the robot and close the port; the second time it does nothing.

        Raises
        ------
        robsim.lab.LineError
            If the line went wrong since the last input: the robot may not have been told to stop.
        """
        try:
            super().close()
        finally:
            self._serial.close()


def _opened(port: str, baud_rate: int) -> Serial:
    if sys.platform == "win32":
        raise LineError(
            "SerialMotors is made for Linux and macOS; on Windows, send the inputs with a function "
            "of your own that writes to pyserial's Serial"
        )
    try:
        from serial import Serial, SerialException
    except ImportError:
        raise ImportError(
            "SerialMotors needs pyserial, which is not installed: pip install 'robsim[serial]'"
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
