"""The roles of a robot's markers: right and left, or front and back; what is given by them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Generic, TypeVar

from robsim._core import marker_roles
from robsim.base.text import listed, quoted

T = TypeVar("T")
#: The pairs of roles, each in the order of its markers: the first, the second.
ROLES = marker_roles()


class ByRole(Mapping[str, T], Generic[T]):
    """What each of two markers has, by its role: a dict that cannot be changed."""

    __slots__ = ("_values",)

    def __init__(self, values: Mapping[str, T]) -> None:
        self._values = dict(values)

    def __getitem__(self, role: str) -> T:
        return self._values[role]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __hash__(self) -> int:
        return hash(frozenset(self._values.items()))

    def __repr__(self) -> str:
        return repr(self._values)


def roles_of(name: str, values: Any) -> tuple[str, str]:
    """Return the pair of roles that a dict is by, in the order of the markers.

    Raises
    ------
    TypeError, ValueError
        If it is no dict, or by other names.
    """
    expected = (
        f"{name} must be by the roles {' and '.join(map(repr, ROLES[0]))}, or "
        f"{' and '.join(map(repr, ROLES[1]))}"
    )
    if not isinstance(values, Mapping):
        raise TypeError(f"{expected}, got {quoted(values)}")
    for roles in ROLES:
        if set(values) == set(roles):
            return roles
    raise ValueError(f"{expected}, got {quoted(list(values))}")


def taken_roles(table: dict[str, Any]) -> dict[str, Any]:
    return {role: table.pop(role) for roles in ROLES for role in roles if role in table}


def given_by_role(name: str, tables: Any, keys: Mapping[str, str]) -> dict[str, dict[str, Any]]:
    """Return what a file's tables of two markers give, such as ``[markers.right]``.

    Parameters
    ----------
    name : str
        What is read, for the messages.
    tables : any
        A table for each role.
    keys : dict of str to str
        The keys that such a table may have, and what of the markers they are.

    Returns
    -------
    dict of str to dict
        Such as ``{"positions": {"right": ..., "left": ...}}``; keys that no table has are left out.

    Raises
    ------
    TypeError, ValueError
        If there are not the tables of two roles, or they have other keys.
    """
    given: dict[str, dict[str, Any]] = {}
    for role in roles_of(name, tables):
        table = tables[role]
        if not isinstance(table, Mapping):
            raise TypeError(f"{name}.{role} must be a table, got {quoted(table)}")
        for key, value in table.items():
            if key not in keys:
                raise ValueError(f"{name}.{role} must have {listed(keys)} alone, got {quoted(key)}")
            given.setdefault(keys[key], {})[role] = value
    return given
