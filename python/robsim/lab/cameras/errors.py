"""What can be wrong with a camera, by name."""

from __future__ import annotations

from typing import ClassVar

from robsim.base.text import cut


class CaptureError(OSError):
    """A camera cannot be opened or read; the message says what to do.

    Each kind has a class of its own, which builds on this one.

    Parameters
    ----------
    message : str
        What is wrong, and what to do.
    """

    fault: ClassVar[str] = "failed"  # as the core names it

    def __init__(self, message: str) -> None:
        super().__init__(message)


class NoBackEndError(CaptureError):
    """What the camera is read with is not installed."""

    fault = "no_back_end"


class NoBusError(CaptureError):
    """The computer has no bus of this kind."""

    fault = "no_bus"


class NoPermissionError(CaptureError, PermissionError):
    """The camera is there, and this user must not read it."""

    fault = "no_permission"


class NoCameraError(CaptureError):
    """There is no such camera."""

    fault = "no_camera"


class NoBandwidthError(CaptureError):
    """The bus has no room left for what the camera is to send."""

    fault = "no_bandwidth"


class CameraBusyError(CaptureError):
    """Another program has the camera."""

    fault = "busy"


class FrameTimeoutError(CaptureError, TimeoutError):
    """No frame came in time. The next one may still come: it can be tried again."""

    fault = "time_out"


class UnpluggedError(CaptureError):
    """The camera was there, and is gone."""

    fault = "unplugged"


class EndOfStream(CaptureError, EOFError):
    """The file is over: there are no more frames."""

    fault = "end"


def unreached(name: str, timeout: float, error: Exception) -> CaptureError:
    """Return why nothing answers at the address of a camera within a time (s)."""
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
