"""The errors of cameras, by name."""

from __future__ import annotations

from typing import ClassVar

from robsim.base.text import cut


class CaptureError(OSError):
    """A camera cannot be opened or read; the message gives the remedy.

    Each kind of error has a class that derives from this class.

    Parameters
    ----------
    message : str
        The problem and the remedy.
    """

    fault: ClassVar[str] = "failed"  # as the core names it

    def __init__(self, message: str) -> None:
        super().__init__(message)


class NoBackEndError(CaptureError):
    """The library for reading the camera is missing."""

    fault = "no_back_end"


class NoBusError(CaptureError):
    """The computer has no bus of this kind."""

    fault = "no_bus"


class NoPermissionError(CaptureError, PermissionError):
    """The camera exists, but this user has no permission to read it."""

    fault = "no_permission"


class NoCameraError(CaptureError):
    """The camera does not exist."""

    fault = "no_camera"


class NoBandwidthError(CaptureError):
    """The bus has no bandwidth left for the camera."""

    fault = "no_bandwidth"


class CameraBusyError(CaptureError):
    """Another program uses the camera."""

    fault = "busy"


class FrameTimeoutError(CaptureError, TimeoutError):
    """No frame came in time. Later frames may still arrive, so reading can be retried."""

    fault = "time_out"


class UnpluggedError(CaptureError):
    """The camera was unplugged or stopped."""

    fault = "unplugged"


class EndOfStream(CaptureError, EOFError):
    """The file has ended: there are no more frames."""

    fault = "end"


def unreached(name: str, timeout: float, error: Exception) -> CaptureError:
    """Return why nothing answers at a camera's address within a time (s)."""
    if isinstance(error, TimeoutError):
        return FrameTimeoutError(
            f"{name} did not answer within {timeout:g} s: is it on, and does the address lead to "
            "it?"
        )
    return NoCameraError(
        f"{name} cannot be reached ({cut(error)}): is the camera on, and are host and port right?"
    )


_KINDS: tuple[type[CaptureError], ...] = (CaptureError, *CaptureError.__subclasses__())
_BY_FAULT = {kind.fault: kind for kind in _KINDS}


def error_of(fault: str, text: str) -> CaptureError:
    return _BY_FAULT[fault](text)
