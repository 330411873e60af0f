"""GigE Vision cameras, read by Aravis."""

from collections.abc import Sequence
from typing import TypedDict

from robsim._core import CaptureDevice

aravis_version: str

class Identity(TypedDict):
    address: str
    vendor: str
    model: str
    serial: str
    user_name: str

class Info(Identity):
    format: str
    coding: str
    region: tuple[int, int, int, int]
    fps: float
    packet_size: int
    advice: str

class GigeCamera(CaptureDevice):
    def __init__(
        self,
        source: str,
        *,
        size: tuple[int, int] | None,
        region: tuple[int, int, int, int] | None,
        fps: float | None,
        format: str,
        features: Sequence[tuple[str, Sequence[float] | None]],
        packet_size: int,
    ) -> None: ...
    def open(self) -> None: ...
    def close(self) -> None: ...
    @property
    def info(self) -> Info | None: ...
    @property
    def features(self) -> list[tuple[str, bool, list[float], str, float, float]]: ...
    def set_features(self, wishes: Sequence[tuple[str, Sequence[float] | None]]) -> None: ...

def find_cameras(seconds: float = 1.0) -> list[Identity]: ...
def lost_between(last: int, id: int) -> int: ...
