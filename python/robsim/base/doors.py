"""The doors of wings: public names, loaded when asked for, that say where they are public."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from robsim.base.spelling import no_attribute


class _Wing(ModuleType):
    """A wing with several rooms: Python binds each of them to it when it has been loaded."""

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, value)
        # Tests may set another object instead of a room.
        if name in vars(self)["_homes"] and isinstance(value, ModuleType):
            present(value, vars(self)["_homes"][name])


def late_names(
    wing: str, rooms: tuple[str, ...], apart: tuple[str, ...] = ()
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a wing with the public names of its rooms.

    The rooms are in the order in which they import one another. Names of rooms `apart` are in these
    alone, as some users lack their packages.
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
        raise no_attribute(f"module {wing!r} has no attribute {name!r}", name, names())

    return get, lambda: sorted([*names(), *homes])


def present(module: ModuleType, wing: str) -> None:
    """Set ``__module__`` of the names in a module's ``__all__`` to the wing that has them.

    So `help`, reprs, tracebacks and pickles show the public path, such as ``robsim.Trace``.
    """
    # The names at the top belong to `robsim` itself.
    homes = getattr(sys.modules.get("robsim"), "_HOMES", {})
    for name in module.__all__:
        value = getattr(module, name)
        if getattr(value, "__module__", "").startswith("robsim"):
            value.__module__ = "robsim" if wing == f"robsim.{homes.get(name)}" else wing
