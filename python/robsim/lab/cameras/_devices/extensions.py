"""The common parts of FireWire and GigE Vision: extension, wishes, properties of a camera."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

from robsim.base.text import quoted
from robsim.lab.cameras.errors import NoBackEndError
from robsim.lab.cameras.features import CameraFeatures


@dataclass(frozen=True, kw_only=True)
class Extension:
    """An extension that may not be built, or whose library may not be installed."""

    module: str  # such as "robsim._firewire"
    cameras: str
    library: str
    debian: str  # a package of the library, as of Fedora
    fedora: str
    development: str  # the package of Debian to build with

    def load(self) -> Any:
        """Return the module; a NoBackEndError names the packages to install."""
        try:
            return importlib.import_module(self.module)
        except ModuleNotFoundError as error:
            raise NoBackEndError(
                f"this robsim was built without {self.library}: sudo apt-get install "
                f"{self.development} pkg-config, then pip install --force-reinstall --no-binary "
                "robsim robsim"
            ) from error
        except ImportError as error:  # a library of the system is missing
            raise NoBackEndError(
                f"{self.cameras} needs {self.library}: sudo apt-get install {self.debian} "
                f"(Debian, Ubuntu), dnf install {self.fedora} (Fedora) ({error})"
            ) from error


@dataclass(frozen=True, kw_only=True)
class Sent:
    """What an open camera sends, as it tells: its name, and what is None or 0 if unknown."""

    name: str
    fps: float  # 1/s
    region: tuple[int, int, int, int] | None
    coding: str | None
    advice: str = ""


@dataclass(frozen=True)
class Wishes:
    """What is asked of a camera, and of what reads it; each may be None."""

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
        """The common options of cameras on a bus, as the extensions take them."""
        features = (self.features or CameraFeatures())._wishes()
        return {"size": self.size, "region": self.region, "fps": self.fps, "features": features}

    def refuse(self, source: str, *names: str) -> None:
        for name in names:
            value = getattr(self, name)
            if value is not None:
                raise ValueError(f"{name} must be None for {source}, got {quoted(value)}")
