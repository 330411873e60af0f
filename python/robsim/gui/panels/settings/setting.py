"""The classes of controls."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from robsim.base.text import quoted
from robsim.base.values import Level
from robsim.gui._link import Refused

#: Additional effects of a change, such as other switches.
Remarks = list[str]


class Setting(ABC):
    """A control: it always has the run's value, even after a change elsewhere."""

    name: str
    tip: str = ""  # in addition to the browser's texts
    label: str = ""  # replaces the browser's text
    card: str  # the browser's card that shows it
    kind: ClassVar[str]

    @property
    @abstractmethod
    def value(self) -> Any:
        """The value of the run; any thread may read this."""

    @abstractmethod
    def set(self, value: Any) -> Remarks:
        """Change the value, in the thread of the run; raise `Refused` if that is impossible."""

    @abstractmethod
    def limits(self) -> dict[str, Any]:
        """Return the allowed values, as fields of the message ``setup``."""

    def described(self) -> dict[str, Any]:
        """Return the entry of this setting in the message ``setup``."""
        names = ("name", "kind", "card", "label", "tip", "value")
        return {name: getattr(self, name) for name in names} | self.limits()


class Choice(Setting):
    """A choice between names."""

    kind: ClassVar[str] = "choice"

    @abstractmethod
    def choices(self) -> Mapping[str, str | None]:
        """Return the names; the value is the reason against a choice, or None."""

    @abstractmethod
    def choose(self, name: str) -> Remarks:
        """Choose an available name, in the thread of the run."""

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
        """Set the value, in the thread of the run, to a number within the limits."""

    def is_within(self, value: float) -> bool:
        return self.range.low <= value <= self.range.high

    def set(self, value: Any) -> Remarks:
        if not isinstance(value, float) or not self.is_within(value):
            limits = f"{self.range.low:g}..{self.range.high:g} {self.range.unit}".rstrip()
            raise Refused(f"{self.name} must be within {limits}, got {quoted(value)}")
        return self.move(value)

    def limits(self) -> dict[str, Any]:
        return {name: getattr(self.range, name) for name in ("low", "high", "step", "unit")}
