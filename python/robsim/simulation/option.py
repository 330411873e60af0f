"""The classes of options: the columns of a row of `robsim.simulation.options`, and its check."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim.base.checks import check_choice, check_float, check_int, check_size
from robsim.base.text import quoted
from robsim.base.values import Level

#: The owner of an option where a world has several robots.
WORLD, ROBOT = "world", "robot"


@dataclass(frozen=True, kw_only=True)
class Option:
    """An option of a simulated world."""

    of: str  # WORLD or ROBOT
    default: Any
    doc: str
    kind: str = ""  # type in words, for the documentation
    plain: bool = False  # whether files may have it as a whole number, too
    unit: str = ""  # also the comment in files
    types: tuple[type, ...] = ()  # of a normal form that is a table in files
    example: str = ""  # a value, for messages
    normal: Callable[[Any], Any] | None = None  # value to normal form; TypeError, ValueError
    is_live: bool = False  # whether it may change in the middle of a run
    group: str = ""  # where people look for it
    label: str = ""  # of its slider in the panel; empty: no slider
    level: Level | None = None  # of the slider
    part: str = ""  # of the value: the slider sets this attribute
    name: str = ""
    annotation: str = ""  # type in the source
    limits = ""  # in words

    @property
    def takes_none(self) -> bool:
        return "None" in self.annotation

    @property
    def is_table(self) -> bool:
        """Whether files store its values only as tables."""
        return bool(self.types) and not self.plain

    @property
    def type_names(self) -> str:
        *others, last = [kind.__name__ for kind in self.types]
        return f"{', '.join(others)} or {last}" if others else last

    def checked(self, value: Any) -> Any:
        """Return the normal form of a value; raise TypeError or ValueError for a wrong value."""
        if not (value is None and self.takes_none):
            value = self._plain_form(value)
        if self.normal is not None:
            value = self.normal(value)
        if self.is_table and value is not None and type(value) not in self.types:
            raise self._no_data(self.type_names, value)  # a subclass may hold code
        return value

    def _plain_form(self, value: Any) -> Any:
        return value

    def _no_data(self, expected: str, value: Any) -> TypeError:
        remedy = self.example and f": write, for example, {self.name}={self.example}"
        if callable(value):
            remedy = ": code is not data; pass it to Simulation itself"
        return TypeError(f"{self.name} must be {expected}, got {quoted(value)}{remedy}")


@dataclass(frozen=True, kw_only=True)
class Number(Option):
    """A number within limits; a whole number becomes an int."""

    minimum: float
    maximum: float
    kind: str = "float"
    step: float = 1.0  # of the slider

    def __post_init__(self) -> None:
        level = Level(self.unit, self.maximum, self.step, self.default or 0, self.minimum)
        object.__setattr__(self, "level", level)

    @property
    def limits(self) -> str:  # type: ignore[override]
        return f"{self.minimum:g}..{self.maximum:g}"

    def _plain_form(self, value: Any) -> Any:
        limits = {"minimum": self.minimum, "maximum": self.maximum}
        number = check_float(self.name, value, self.unit, **limits)
        return int(number) if number.is_integer() else number


@dataclass(frozen=True, kw_only=True)
class Whole(Number):
    """A whole number within limits; messages give the reason for a whole number."""

    minimum: int
    maximum: int
    reason: str = ""
    kind: str = "int"

    def _plain_form(self, value: Any) -> Any:
        try:
            return check_int(self.name, value, minimum=self.minimum, maximum=self.maximum)
        except TypeError as error:
            raise TypeError(f"{error}{self.reason and ': '}{self.reason}") from None


@dataclass(frozen=True, kw_only=True)
class Choice(Option):
    """A word from a list."""

    choices: tuple[str, ...]
    kind: str = "str"

    def _plain_form(self, value: Any) -> Any:
        return check_choice(self.name, value, self.choices)


@dataclass(frozen=True, kw_only=True)
class Switch(Option):
    """On or off; None is off."""

    kind: str = "bool"

    def _plain_form(self, value: Any) -> Any:
        if value is None or isinstance(value, (bool, np.bool_)):
            return bool(value)
        raise self._no_data("True or False", value)


@dataclass(frozen=True, kw_only=True)
class Size(Option):
    """Width and height in px."""

    kind: str = "tuple of int"

    def _plain_form(self, value: Any) -> Any:
        return check_size(self.name, value)


def _row_of(kind: type[Option]) -> Callable[..., Any]:
    """Return a function that makes a row of this kind, as a field of `Options`."""

    def row(of: str, default: Any, doc: str, **more: Any) -> Any:
        option = kind(of=of, default=default, doc=doc, **more)
        return dataclasses.field(default=default, metadata={"option": option})

    return row


value, number, whole = _row_of(Option), _row_of(Number), _row_of(Whole)
choice, switch, size = _row_of(Choice), _row_of(Switch), _row_of(Size)
