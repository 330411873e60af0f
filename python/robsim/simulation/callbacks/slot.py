"""The class of a slot, row of the table and descriptor, and its handle on reading."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from robsim.base.text import quoted

if TYPE_CHECKING:
    from robsim.simulation.slotted import Slotted
T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., object])
_MISSING: Any = object()


class SlotHandle(Generic[T]):
    """A slot of a simulation, ``sim.control``, and the decorator that fills it, ``@sim.control``.

    It equals its `callback`, the given value, and is false for an empty slot. True = the default of
    an optional stage, None = the default, or off.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, runner: Slotted, slot: Slot[T]) -> None:
        self._runner = runner
        self._slot = slot
        self.__doc__ = slot.__doc__

    @property
    def callback(self) -> T | None:
        """The value in the slot."""
        value: T | None = self._runner._callbacks[self._slot.name]
        return value

    def __call__(self, callback: F = _MISSING, /, *others: object, **named: object) -> F:
        """Fill the slot with a callback and return it; TypeError if the slot cannot call it."""
        name = self._slot.name
        if others or named:
            raise TypeError(
                f"sim.{name} takes one callback, got {1 + len(others) + len(named)} values: use "
                f"@sim.{name} to fill the slot, and sim.{name}.callback to get the callback"
            )
        if callback is _MISSING:
            raise TypeError(f"use @sim.{name}, without parentheses")
        if not callable(callback):
            raise TypeError(
                f"{name} must be callable, got {quoted(callback)}: use @sim.{name} to fill the "
                f"slot, and sim.{name}.callback to get the callback"
            )
        self._runner._set_slot(name, callback)
        return callback

    def __eq__(self, other: object) -> bool:
        callback = self.callback
        if isinstance(other, SlotHandle):
            other = other.callback
        return callback is other or bool(callback == other)

    def __bool__(self) -> bool:
        return self.callback is not None and self.callback is not False

    def __repr__(self) -> str:
        return f"<slot {self._slot.name}: {self.callback!r}>"


class Slot(Generic[T]):
    """A slot: a row of the table, and the descriptor ``sim.control``.

    `half` is `ROBOT` or `WORLD`, `when` is `ONCE` or `STEP`. An empty `argument` = no argument. An
    `is_optional` slot may stay empty; with `is_switch`, True is its default stage, named `default`.
    Values of `native` types run without the interpreter. `result_types` are the classes of a
    result; such a class may itself be the callback, since a call of it makes a result.
    `other_names` are wrong names of its file, first in the program of 2008.
    Sentences call it by its `title`.
    """

    name: str

    def __init__(
        self,
        half: str,
        when: str,
        argument: str,
        result: str,
        doc: str,
        *,
        is_optional: bool = False,
        is_switch: bool = False,
        native: tuple[type, ...] = (),
        result_types: tuple[type, ...] = (),
        other_names: tuple[str, ...] = (),
        title: str,
        default: str = "",
    ) -> None:
        self.half = half
        self.when = when
        self.argument = argument
        self.result = result
        self.doc = doc
        self.is_optional = is_optional
        self.is_switch = is_switch
        self.native = native
        self.result_types = result_types
        self.other_names = other_names
        self.title = title
        self.default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name
        self.__doc__ = f"{self.call}: {self.doc}"

    @property
    def call(self) -> str:
        """The call of the callback, such as ``control(step) -> (u1, u2)``."""
        return f"``{self.signature} -> {self.result}``"

    @property
    def signature(self) -> str:
        """The callback with its argument, such as ``control(step)``."""
        return f"{self.name}({self.argument})"

    @property
    def template(self) -> Path:
        """The template file for a custom callback."""
        return Path(__file__).parents[1] / "templates" / f"{self.name}.py"

    @property
    def n_arguments(self) -> int:
        return 1 if self.argument else 0

    @property
    def arguments(self) -> str:
        return f"one argument, {self.argument}" if self.argument else "no argument"

    @overload
    def __get__(self, runner: None, owner: type) -> Slot[T]: ...

    @overload
    def __get__(self, runner: Slotted, owner: type) -> SlotHandle[T]: ...

    def __get__(self, runner: Slotted | None, owner: type) -> Slot[T] | SlotHandle[T]:
        return self if runner is None else SlotHandle(runner, self)

    def __set__(self, runner: Slotted, value: T | str | None) -> None:
        runner._set_slot(self.name, value)


_in_run: dict[int, object] = {}  # by their ids


@contextmanager
def held(callbacks: Iterable[object]) -> Iterator[None]:
    """Keep callbacks with ``_remembers_run`` for this run; RuntimeError: another run has one."""
    run = object()
    mine = [one for one in callbacks if getattr(one, "_remembers_run", False) is True]
    try:
        for callback in mine:
            # One call, which no other thread interrupts.
            if _in_run.setdefault(id(callback), run) is not run:
                raise RuntimeError(
                    f"another run already uses this {type(callback).__name__}, which stores the "
                    "state of one robot: give each simulation a separate object"
                )
        yield
    finally:
        for callback in mine:
            if _in_run.get(id(callback)) is run:
                del _in_run[id(callback)]
