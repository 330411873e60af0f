"""How public names present themselves; the `__init__` of each room calls `present`.

Each has its public module path, and the classes say what is wrong with the arguments of a call.
"""

from __future__ import annotations

import functools
import inspect
import sys
from collections.abc import Callable, Iterable
from types import FunctionType
from typing import Any, ParamSpec, TypeVar

from robsim._base.spelling import closest

P = ParamSpec("P")
R = TypeVar("R")


def present(namespace: dict[str, Any]) -> None:
    """Set ``__module__`` of the names in a module's ``__all__`` to that module.

    So `help`, reprs, tracebacks and pickles show the public path, such as ``robsim.Trace``, and
    not the private file that defines it. The classes get the errors of `told_by_name`.

    Parameters
    ----------
    namespace : dict
        The ``globals()`` of the module.
    """
    # `robsim` presents its own names when it is loaded; rooms that are loaded later know them.
    at_the_top = getattr(sys.modules.get("robsim"), "__all__", ())
    for name in namespace["__all__"]:
        value = namespace[name]
        if getattr(value, "__module__", "").startswith("robsim"):
            value.__module__ = "robsim" if name in at_the_top else namespace["__name__"]
        init = vars(value).get("__init__") if isinstance(value, type) else None
        if isinstance(init, FunctionType) and not hasattr(init, "__wrapped__"):
            value.__init__ = told_by_name(init)


def told_by_name(method: Callable[P, R]) -> Callable[P, R]:
    """Return a method that says which argument of a call is wrong, and what was meant.

    A class can have a dict ``_OPTIONS_ELSEWHERE``: option of its ``__init__`` to a sentence that
    says where it belongs.
    """

    @functools.wraps(method)
    def told(*args: P.args, **options: P.kwargs) -> R:
        try:
            return method(*args, **options)
        except TypeError as error:
            # An error of the call itself has not reached a line of the method.
            if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                raise
            raise _explained(method, type(args[0]), args[1:], options) or error from None

    return told


def _explained(
    method: Callable[..., object], owner: type, args: tuple[Any, ...], options: dict[str, Any]
) -> TypeError | None:
    """Return the error of a call whose arguments do not fit; None if they do."""
    _, *parameters = inspect.signature(method).parameters.values()
    names = [one.name for one in parameters]
    positional = [one.name for one in parameters if one.kind is not one.KEYWORD_ONLY]
    is_init = method.__name__ == "__init__"
    kind = owner.__name__ if is_init else f"{owner.__name__}.{method.__name__}"
    for name in options:
        if name not in names:
            hint = hint_at_option(owner if is_init else object, name, names)
            return TypeError(f"{kind} has no option {name!r}: {hint}")
    if len(args) > len(positional):
        by_name = next((name for name in names if name not in positional), None)
        example = f": give options by name, such as {by_name}=..." if by_name else ""
        limit = f"only {', '.join(positional)}" if positional else "nothing"
        return TypeError(f"{kind} takes {limit} without a name, got {len(args)} values{example}")
    given = {*positional[: len(args)], *options}
    missing = [o.name for o in parameters if o.default is o.empty and o.name not in given]
    return TypeError(f"{kind} must be given {' and '.join(missing)}") if missing else None


def hint_at_option(owner: type, name: str, names: Iterable[str]) -> str:
    """Return what may be meant by an option that a class does not have."""
    elsewhere: dict[str, str] = getattr(owner, "_OPTIONS_ELSEWHERE", {})
    if name in elsewhere:
        return elsewhere[name]
    meant = closest(name, names)
    return f"did you mean {meant!r}?" if meant else f"there are {', '.join(names)}"
