"""The wishes for a camera of any kind: size, region, rate, coding, features."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from robsim.base.text import quoted
from robsim.lab.cameras.features import CameraFeatures


@dataclass(frozen=True)
class Wishes:
    """Wishes for a camera and its reader; each may be None."""

    back_end: str | None
    size: tuple[int, int] | None
    region: tuple[int, int, int, int] | None
    fps: float | None
    coding: str | None
    features: CameraFeatures | None

    @property
    def dt(self) -> float | None:
        """Time between two frames (s)."""
        return None if self.fps is None else 1 / self.fps

    @property
    def given(self) -> dict[str, Any]:
        """The common options of cameras on a bus, in the extensions' form."""
        features = (self.features or CameraFeatures())._wishes()
        return {"size": self.size, "region": self.region, "fps": self.fps, "features": features}

    def refuse(self, source: str, *names: str) -> None:
        for name in names:
            value = getattr(self, name)
            if value is not None:
                raise ValueError(f"{name} must be None for {source}, got {quoted(value)}")
