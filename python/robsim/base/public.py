"""How public names present themselves; the `__init__` of each room calls `present`."""

from __future__ import annotations

import sys
from typing import Any


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
