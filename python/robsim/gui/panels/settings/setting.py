"""The classes of controls."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from robsim.base.text import quoted
from robsim.base.values import Level
from robsim.gui._link import Refused

#: What is to be said of a change beyond itself, such as what it has switched on, too.
Remarks = list[str]


class Setting(ABC):
    """A control: its value is that of the run, wherever it was changed."""

    name: str
    tip: str = ""  # beyond the texts of the browser
    label: str = ""  # instead of that in the texts of the browser
    card: str  # of the browser, on which it stands
    kind: ClassVar[str]

    @property
    @abstractmethod
    def value(self) -> Any:
        """The value of the run; any thread may ask."""

    @abstractmethod
    def set(self, value: Any) -> Remarks:
        """Change it, in the thread of the run; raise `Refused` if that cannot be."""

    @abstractmethod
    def limits(self) -> dict[str, Any]:
        """Return what it can be set to, as fields of the message ``setup``."""

    def described(self) -> dict[str, Any]:
        """Return its entry in the message ``setup``."""
        names = ("name", "kind", "card", "label", "tip", "value")
        return {name: getattr(self, name) for name in names} | self.limits()


class Choice(Setting):
    """One of some names."""

    kind: ClassVar[str] = "choice"

    @abstractmethod
    def choices(self) -> Mapping[str, str | None]:
        """Return the names, and why one cannot be chosen, or None."""

    @abstractmethod
    def choose(self, name: str) -> Remarks:
        """Change it, in the thread of the run, to a name that can be chosen."""

    def set(self, value: Any) -> Remarks:
        choices = self.choices()
        if value not in choices:
            raise Refused(f"{self.name} must be one of {', '.join(choices)}, got {quoted(value)}")
        if (reason := choices[value]) is not None:
            raise Refused(reason)
        return self.choose(value)

    def limits(self) -> dict[str, Any]:
        return {"choices": [{"value": n, "disabled": why} for n, why in self.choices().items()]}


class Range(Setting):
    """A number between two limits."""

    kind: ClassVar[str] = "range"
    range: Level

    @abstractmethod
    def move(self, value: float) -> Remarks:
        """Change it, in the thread of the run, to a number within the limits."""

    def is_within(self, value: float) -> bool:
        return self.range.low <= value <= self.range.high

    def set(self, value: Any) -> Remarks:
        if not isinstance(value, float) or not self.is_within(value):
            limits = f"{self.range.low:g}..{self.range.high:g} {self.range.unit}".rstrip()
            raise Refused(f"{self.name} must be within {limits}, got {quoted(value)}")
        return self.move(value)

    def limits(self) -> dict[str, Any]:
        return {name: getattr(self.range, name) for name in ("low", "high", "step", "unit")}
