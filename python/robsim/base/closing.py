"""`Closing`: objects that a ``with`` block closes; without numpy, for the start page."""

from __future__ import annotations

from abc import abstractmethod
from typing import Self


class Closing:
    """An object that a ``with`` block closes at its end."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def close(self) -> None:
        """End it."""
