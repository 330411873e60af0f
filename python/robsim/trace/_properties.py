"""The groups of columns as properties of a trace, documented from the schema."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from robsim.base.checks import Floats
from robsim.trace.columns import GROUPS


class Column(property):
    """The group of its name: an array with a row for each step."""

    def __set_name__(self, owner: type, name: str) -> None:
        group = GROUPS[name]
        super().__init__(lambda trace: trace._numbers(group))
        self.__doc__ = group.description

    if TYPE_CHECKING:

        @overload
        def __get__(self, trace: None, owner: type, /) -> Self: ...
        @overload
        def __get__(self, trace: Any, owner: type | None = None, /) -> Floats: ...
        def __get__(self, trace: Any, owner: type | None = None, /) -> Any: ...


class Flag(property):
    """The group of its name: True or False at each step."""

    def __set_name__(self, owner: type, name: str) -> None:
        group = GROUPS[name]
        super().__init__(lambda trace: np.asarray(trace._numbers(group) > 0))
        self.__doc__ = group.description

    if TYPE_CHECKING:

        @overload
        def __get__(self, trace: None, owner: type, /) -> Self: ...
        @overload
        def __get__(self, trace: Any, owner: type | None = None, /) -> NDArray[np.bool_]: ...
        def __get__(self, trace: Any, owner: type | None = None, /) -> Any: ...
