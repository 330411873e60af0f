"""What the mouse makes, change by change: each can be undone."""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")

_MOST_CHANGES = 500  # that can be undone


class History(Generic[T]):
    """The newest value, and earlier and later ones; the values themselves never change."""

    def __init__(self, now: T) -> None:
        self.begin(now)

    def begin(self, now: T) -> None:
        """Go on with another one; there is nothing to be undone."""
        self._now = now
        self._before: list[T] = []
        self._after: list[T] = []
        self._is_open = False

    def go_to(self, now: T, *, goes_on: bool = False) -> None:
        """Change it; `goes_on`: it is the same change as the one before, undone with it."""
        if not (goes_on and self._is_open):
            self._before = [*self._before[1 - _MOST_CHANGES :], self._now]
        self._is_open = True
        self._after.clear()
        self._now = now

    def end_change(self) -> None:
        """Let the next change be another one, even if it is said to go on."""
        self._is_open = False

    @property
    def can_undo(self) -> bool:
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        """Whether there is a change that was undone."""
        return bool(self._after)

    def undo(self) -> None:
        """Undo the last change; nothing if there is none."""
        self.end_change()
        if self._before:
            self._after.append(self._now)
            self._now = self._before.pop()

    def redo(self) -> None:
        """Do again what was undone last; nothing if there is nothing."""
        self.end_change()
        if self._after:
            self._before.append(self._now)
            self._now = self._after.pop()
