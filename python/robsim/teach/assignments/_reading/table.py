"""`Keys`: the keys of a table in `assignment.toml`, checked one by one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

from robsim.base.checks import check_choice, is_int
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.teach.errors import AssignmentError

_NEEDED: Any = object()


class Keys:
    """A table of a file: each key is asked for once, with what it must be.

    Parameters
    ----------
    values : mapping of str to value
        The table.
    file : str
        The name of the file, for messages.
    known : tuple of str
        All keys that there may be.
    where : str
        Which table of the file it is, for messages; "" = the file itself.

    Raises
    ------
    AssignmentError
        If it has other keys.
    """

    def __init__(
        self, values: Mapping[str, Any], file: str, known: tuple[str, ...], where: str = ""
    ) -> None:
        self._values = values
        self.file = file
        self.place = f"{file}, {where}" if where else file
        check_names(f"{self.place}: there is no key", values, known, self._error)

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def _error(self, message: str) -> AssignmentError:
        return AssignmentError(message, file=self.file)

    def refuse(self, message: object) -> NoReturn:
        raise self._error(f"{self.place}: {message}") from None

    def _got(self, key: str, expected: str) -> NoReturn:
        self.refuse(f"{key} must be {expected}, got {quoted(self._values[key])}")

    def _given(self, key: str, default: Any) -> bool:
        """Whether a key is there; raise AssignmentError if it is not, and must be."""
        if key not in self._values and default is _NEEDED:
            self.refuse(f"{key} is missing")
        return key in self._values

    def text(self, key: str, default: str = _NEEDED) -> str:
        """Return a text."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        return value if isinstance(value, str) and value else self._got(key, "a text")

    def choice(self, key: str, choices: tuple[str, ...], default: str = _NEEDED) -> str:
        """Return one of some texts."""
        if not self._given(key, default):
            return default
        try:
            return check_choice(key, self._values[key], choices)
        except (TypeError, ValueError) as error:
            self.refuse(error)

    def flag(self, key: str, default: bool = _NEEDED) -> bool:
        """Return true or false."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        return value if isinstance(value, bool) else self._got(key, "true or false")

    def number(self, key: str, default: float = _NEEDED, *, most: float) -> float:
        """Return a number from 0 to the most."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        if not (is_int(value) or isinstance(value, float)) or not 0 <= value <= most:
            self._got(key, f"a number within 0..{most:g}")
        return float(value)

    def names(self, key: str, default: tuple[str, ...] | None = _NEEDED) -> tuple[str, ...] | None:
        """Return a list of texts."""
        if not self._given(key, default):
            return default
        value = self._values[key]
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            self._got(key, 'a list of names, such as ["numpy"]')
        return tuple(value)

    def table(self, key: str) -> Mapping[str, Any]:
        """Return a table; empty, where there is none."""
        value = self._values.get(key, {})
        return value if isinstance(value, dict) else self._got(key, f"a table, [{key}]")

    def tables(self, key: str) -> list[Mapping[str, Any]]:
        """Return a list of tables; empty, where there is none."""
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            self._got(key, f"tables, each below a line [[{key}]]")
        return list(value)
