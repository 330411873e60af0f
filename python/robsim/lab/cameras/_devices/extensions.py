"""What FireWire and GigE Vision share: an extension of robsim, and what a camera sends."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

from robsim.lab.cameras.errors import NoBackEndError


@dataclass(frozen=True, kw_only=True)
class Extension:
    """An extension that may not be built, or whose library may not be installed.

    Attributes
    ----------
    module : str
        Its name, ``"robsim._firewire"``.
    cameras, library : str
        What it reads, and by what.
    debian, fedora, development : str
        Packages of the library, and the one of Debian that it is built with.
    """

    module: str
    cameras: str
    library: str
    debian: str
    fedora: str
    development: str

    def load(self) -> Any:
        """Return the module.

        Raises
        ------
        NoBackEndError
            If it, or what it needs, is not there; the message says what to install.
        """
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
