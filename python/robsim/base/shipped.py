"""The folders that ship with robsim."""

from __future__ import annotations

from pathlib import Path

#: Folder of the shipped images, robot definitions and colours.
ASSETS = Path(__file__).parents[1] / "assets"
#: Folder of the shipped notebooks.
NOTEBOOKS = Path(__file__).parents[1] / "notebooks"
