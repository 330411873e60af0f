"""Motors behind a UDP socket."""

from __future__ import annotations

from robsim._core import Line
from robsim.base.checks import check_float, check_int, check_text
from robsim.base.text import quoted
from robsim.lab.motors._line_motors import HOLD, TTL, LineMotors


class UdpMotors(LineMotors):
    """Motors of a robot that listens to UDP: send them inputs by calling it.

    A native thread repeats the newest input and stops the robot; it needs no interpreter. The
    robot stops by itself when it hears nothing for `ttl`. It is stopped by `stop`, `close`, the end
    of a ``with`` block or of the program, and where no input is sent for `hold`.

    Parameters
    ----------
    address : str
        Name or number of the robot's host, with the port: ``"192.168.4.1:5005"``,
        ``"[fe80::1]:5005"``; or without it, if `port` is given.
    port : int, optional
        The port that the robot listens at.
    ttl : float
        Time to live of each input (s), 0.03 to 60: the robot stops by itself when it hears nothing
        for so long. The newest input is sent again each third of it.
    hold : float
        The link stops the robot when no input is sent for so long (s).

    Raises
    ------
    robsim.lab.LineError
        If there is no such host. Whether a robot listens shows after the first inputs.

    Examples
    --------
    >>> with robsim.lab.UdpMotors("192.168.4.1:5005") as motors:
    ...     motors((0.5, 0.5))
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
                "address must be HOST:PORT, such as '192.168.4.1:5005', or port must be given, "
                f"got {quoted(address)}"
            )
        port = int(text[:6])
    host = host.removeprefix("[").removesuffix("]")
    if not host or not host.isprintable():
        raise ValueError(f"address must name a host, got {quoted(address)}")
    return host, check_int("port", port, minimum=1, maximum=65535)
