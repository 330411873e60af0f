"""The history of a tool's product: each change can be undone."""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")

_MOST_CHANGES = 500  # limit of undo


class History(Generic[T]):
    """The current value with earlier and later values; the values themselves never change."""

    def __init__(self, now: T) -> None:
        self.begin(now)

    def begin(self, now: T) -> None:
        """Start a new history with a value; there is nothing to undo."""
        self._now = now
        self._before: list[T] = []
        self._after: list[T] = []
        self._is_open = False

    def go_to(self, now: T, *, goes_on: bool = False) -> None:
        """Set the value; with `goes_on`, one undo reverts this and the previous change."""
        if not (goes_on and self._is_open):
            self._before = [*self._before[1 - _MOST_CHANGES :], self._now]
        self._is_open = True
        self._after.clear()
        self._now = now

    def end_change(self) -> None:
        """End the change under way: the next one is separate, even with `goes_on`."""
        self._is_open = False

    @property
    def can_undo(self) -> bool:
        return bool(self._before)

    @property
    def can_redo(self) -> bool:
        """Whether an undone change can be repeated."""
        return bool(self._after)

    def undo(self) -> None:
        """Undo the last change, if any."""
        self.end_change()
        if self._before:
            self._after.append(self._now)
            self._now = self._before.pop()

    def redo(self) -> None:
        """Redo the last undone change, if any."""
        self.end_change()
        if self._after:
            self._before.append(self._now)
            self._now = self._after.pop()
