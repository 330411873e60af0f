"""The doors of wings: public names, loaded when asked for, that say where they are public."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

from robsim.base.spelling import no_attribute, suggestion


def late_names(
    wing: str, rooms: tuple[str, ...], apart: tuple[str, ...] = ()
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a wing with the public names of its rooms.

    Parameters
    ----------
    wing : str
        Its ``__name__``.
    rooms : tuple of str
        Its rooms, in the order in which they import one another.
    apart : tuple of str
        Rooms whose names are in them alone: not everybody has them, or what they need.
    """
    namespace = sys.modules[wing].__dict__

    def loaded(room: str) -> ModuleType:
        with sys.modules["robsim"]._loading:
            return importlib.import_module(f"{wing}.{room}")

    def names() -> list[str]:
        public = (name for room in rooms for name in loaded(room).__all__)
        return sorted(public, key=lambda name: (not name.isupper(), not name[0].isupper(), name))

    def get(name: str) -> Any:
        if name in rooms or name in apart:
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
        raise no_attribute(f"module {wing!r} has no attribute {name!r}" + suggestion(name, names()))

    return get, lambda: sorted([*names(), *rooms, *apart])


def present(namespace: dict[str, Any], home: str | None = None) -> None:
    """Set ``__module__`` of the names in a module's ``__all__`` to the wing that has them.

    So `help`, reprs, tracebacks and pickles show the public path, such as ``robsim.Trace`` or
    ``robsim.lab.Camera``, and not the private file that defines it.

    Parameters
    ----------
    namespace : dict
        The ``globals()`` of the module.
    home : str, optional
        The module that has them, if it is not the wing.
    """
    # `robsim` presents its own names when it is loaded; rooms that are loaded later know them.
    homes = getattr(sys.modules.get("robsim"), "_HOMES", {})
    wing = home or ".".join(namespace["__name__"].split(".")[:2])
    for name in namespace["__all__"]:
        value = namespace[name]
        if getattr(value, "__module__", "").startswith("robsim"):
            value.__module__ = "robsim" if wing == f"robsim.{homes.get(name)}" else wing
