"""How public names present themselves; the `__init__` of each room calls `present`."""

from __future__ import annotations

import sys
from typing import Any


def present(namespace: dict[str, Any]) -> None:
    """Set ``__module__`` of the names in a module's ``__all__`` to that module.

    So `help`, reprs, tracebacks and pickles show the public path, such as ``robsim.Trace``, and
    not the private file that defines it.

    Parameters
    ----------
    namespace : dict
        The ``globals()`` of the module.
    """
    # `robsim` presents its own names when it is loaded; rooms that are loaded later know them.
    homes = getattr(sys.modules.get("robsim"), "_HOMES", {})
    for name in namespace["__all__"]:
        value = namespace[name]
        if getattr(value, "__module__", "").startswith("robsim"):
            at_the_top = namespace["__name__"] == f"robsim.{homes.get(name)}"
            value.__module__ = "robsim" if at_the_top else namespace["__name__"]
