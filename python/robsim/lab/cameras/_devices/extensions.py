"""The common part of FireWire and GigE Vision: an extension of robsim, and camera data."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

from robsim.lab.cameras.errors import NoBackEndError


@dataclass(frozen=True, kw_only=True)
class Extension:
    """An extension that may be missing, like its library."""

    module: str  # such as "robsim._firewire"
    cameras: str
    library: str
    debian: str  # the library's package in Debian
    fedora: str
    development: str  # Debian's package for building

    def load(self) -> Any:
        """Return the module; a NoBackEndError names the packages to install."""
        try:
            return importlib.import_module(self.module)
        except ModuleNotFoundError as error:
            raise NoBackEndError(
                f"this robsim was built without {self.library}: run sudo apt-get install "
                f"{self.development} pkg-config, then pip install --force-reinstall --no-binary "
                "robsim robsim"
            ) from error
        except ImportError as error:  # a library of the system is missing
            raise NoBackEndError(
                f"{self.cameras} needs {self.library}: run sudo apt-get install {self.debian} "
                f"(Debian, Ubuntu) or dnf install {self.fedora} (Fedora) ({error})"
            ) from error


@dataclass(frozen=True, kw_only=True)
class Sent:
    """The reported output of an open camera: its name, and values; None or 0 = unknown."""

    name: str
    fps: float  # 1/s
    region: tuple[int, int, int, int] | None
    coding: str | None
    advice: str = ""
