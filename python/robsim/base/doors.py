"""The doors of wings: public names, loaded on first use, which name their public module."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

from robsim.base.spelling import no_attribute


class _Wing(ModuleType):
    """A wing with several rooms: Python binds each room to the wing after loading."""

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, value)
        # Tests may set another object instead of a room.
        if name in vars(self)["_homes"] and isinstance(value, ModuleType):
            present(value, vars(self)["_homes"][name])


def late_names(
    wing: str, rooms: tuple[str, ...], apart: tuple[str, ...] = ()
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a wing with the public names of its rooms.

    The rooms are in the order in which they import one another. A room in `apart` is the only home
    of its names, as some users lack its packages.
    """
    sys.modules[wing].__class__ = _Wing
    namespace = sys.modules[wing].__dict__
    # Where the names of each room are public.
    homes = dict.fromkeys(rooms, wing) | {room: f"{wing}.{room}" for room in apart}
    namespace["_homes"] = homes

    def loaded(room: str) -> ModuleType:
        with sys.modules["robsim"]._loading:
            return importlib.import_module(f"{wing}.{room}")

    def names() -> list[str]:
        public = (name for room in rooms for name in loaded(room).__all__)
        return sorted(public, key=lambda name: (not name.isupper(), not name[0].isupper(), name))

    def get(name: str) -> Any:
        if name in homes:
            return loaded(name)
        if name.startswith("_") and name != "__all__":
            raise AttributeError(f"module {wing!r} has no attribute {name!r}")
        if name == "__all__":
            namespace[name] = names()
            return namespace[name]
        for room in rooms:
            if name in loaded(room).__all__:
                namespace[name] = getattr(loaded(room), name)
                return namespace[name]
        raise not_here(wing, name, names())

    return get, lambda: sorted([*names(), *homes])


class _Room(ModuleType):
    """A module whose error for a missing public name says in which wing that name is."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        raise not_here(self.__name__, name, self.__all__)


def not_here(module: str, name: str, known: Iterable[str]) -> AttributeError:
    """Return the error for a missing name, with the name's home or the closest known name."""
    robsim = sys.modules["robsim"]
    message = f"module {module!r} has no attribute {name!r}"
    for wing in ("robsim", *sorted({*robsim._WINGS} - {"plotting"})):  # which takes time
        home = robsim if wing == "robsim" else getattr(robsim, wing)
        if home.__name__ != module and name in home.__all__:
            return no_attribute(f"{message}: use {home.__name__}.{name}")
    return no_attribute(message, name, known)


def present(module: ModuleType, wing: str) -> None:
    """Set ``__module__`` of a module's public names to the wing from which users import them.

    So `help`, reprs, tracebacks and pickles show the public path, such as ``robsim.Trace``.
    """
    if type(module) is ModuleType and "__getattr__" not in vars(module):
        module.__class__ = _Room
    # The names at the top belong to `robsim` itself.
    homes = getattr(sys.modules.get("robsim"), "_HOMES", {})
    for name in module.__all__:
        value = getattr(module, name)
        if getattr(value, "__module__", "").startswith("robsim"):
            value.__module__ = "robsim" if wing == f"robsim.{homes.get(name)}" else wing
