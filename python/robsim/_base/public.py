"""What is public, and the name that it is known by. The face of each room calls it."""

from __future__ import annotations

from typing import Any


def present(namespace: dict[str, Any]) -> None:
    """Let what a module offers in ``__all__`` say that it is of this module.

    So `help`, reprs, tracebacks and pickles name the public place, such as ``robsim.Trace``, and
    not the file that it happens to be written in.

    Parameters
    ----------
    namespace : dict
        The ``globals()`` of the module.
    """
    for name in namespace["__all__"]:
        value = namespace[name]
        if getattr(value, "__module__", "").startswith("robsim"):
            value.__module__ = namespace["__name__"]
