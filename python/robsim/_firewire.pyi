"""Cameras on FireWire, by libdc1394. Users take robsim.Camera("firewire://")."""

from collections.abc import Sequence
from typing import Any

from robsim._core import CaptureDevice

_Wishes = Sequence[tuple[str, Sequence[float] | None]]

class FireWireCamera(CaptureDevice):
    """A camera for a grabber. Users take robsim.Camera."""

    def __init__(
        self,
        choice: str,
        *,
        size: tuple[int, int] | None,
        region: tuple[int, int, int, int] | None,
        fps: float | None,
        coding: str,
        features: _Wishes,
    ) -> None: ...
    def open(self) -> None: ...
    def close(self) -> None: ...
    def set_features(self, wishes: _Wishes) -> None: ...
    @property
    def video(self) -> dict[str, Any]: ...
    @property
    def guid(self) -> str: ...
    @property
    def restarts(self) -> int: ...
    @property
    def features(self) -> list[tuple[str, bool, list[float], str, float, float]]: ...

def cameras() -> list[tuple[str, str, str]]: ...
def nodes() -> tuple[list[str], list[str]]: ...
