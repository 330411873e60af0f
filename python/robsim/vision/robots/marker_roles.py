"""The roles of a robot's markers, right and left, or front and back; values by role."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Generic, TypeVar

from robsim._core import marker_roles
from robsim.base.text import quoted

T = TypeVar("T")
#: The pairs of roles, each in the order of its markers: the first, the second.
ROLES = marker_roles()


class ByRole(Mapping[str, T], Generic[T]):
    """A value for each of two markers, by its role: an immutable dict."""

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
    """Return a dict's pair of roles, in the order of the markers; else TypeError or ValueError."""
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
