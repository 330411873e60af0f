"""Sets the public module path of exported names; the `__init__` of each room calls it."""

from __future__ import annotations

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
    for name in namespace["__all__"]:
        value = namespace[name]
        if getattr(value, "__module__", "").startswith("robsim"):
            value.__module__ = namespace["__name__"]
