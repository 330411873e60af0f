"""The allowed imports of a submission: refused ones get a clear sentence; this is no sandbox."""

from __future__ import annotations

import ast
import builtins
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pkgutil import resolve_name
from types import ModuleType
from typing import Any, NoReturn

from robsim import _core
from robsim.teach.submissions.copies import copies_refused
from robsim.teach.submissions.rules import Rules

#: Slots whose stage of robsim is in the core.
_STAGES = {"locate": "measure", "RecursiveLeastSquares": "estimate_parameters"}


class _Masked(MetaPathFinder):
    """A finder that raises a sentence for each masked module."""

    def __init__(self, masked: Sequence[str]) -> None:
        self._masked = masked

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if mask := _above(name, self._masked):
            raise NotHereError(mask)
        return None


def _above(name: str, masked: Sequence[str]) -> str | None:
    return next((mask for mask in masked if f"{name}.".startswith(f"{mask}.")), None)


class NotHereError(ImportError):
    """A submission uses a masked module or name."""

    def __init__(self, mask: str) -> None:
        super().__init__(
            f"{mask} is unavailable in this assignment: write your own code", name=mask
        )


class _Absent:
    """The replacement of a masked function or class."""

    def __init__(self, mask: str) -> None:
        object.__setattr__(self, "_mask", mask)

    def __call__(self, *args: object, **options: object) -> NoReturn:
        raise NotHereError(object.__getattribute__(self, "_mask"))

    def __getattribute__(self, name: str) -> NoReturn:
        raise NotHereError(object.__getattribute__(self, "_mask"))


@contextmanager
def masked(rules: Rules, *, for_good: bool = False) -> Iterator[dict[int, str]]:
    """Hide the masked modules and names inside the context, also already imported ones.

    It yields the masks by the ids of their objects. With `for_good`, robsim itself loses the
    objects, and a search of the memory finds no working one.
    """
    values = {mask: _value_of(mask) for mask in rules.masked}
    with copies_refused(values), ExitStack() as restored:
        _take(values, restored)
        if for_good:
            restored.pop_all()
            _spoil(values)
        finder = _Masked(rules.masked)
        sys.meta_path.insert(0, finder)
        restored.callback(sys.meta_path.remove, finder)
        yield {id(value): mask for mask, value in values.items() if value is not None}


def _take(values: Mapping[str, Any], restored: ExitStack) -> None:
    for name in tuple(sys.modules):  # other threads import
        if _above(name, [*values]):
            restored.callback(sys.modules.__setitem__, name, sys.modules.pop(name))
    for mask, value in values.items():
        for package in _packages_of(mask):
            _take_attribute(package, mask, restored)
        _take_everywhere(value, mask, restored)


def _spoil(values: dict[str, Any]) -> None:
    """Remove the methods of masked classes, masked functions from all modules, and their stages."""
    for mask, value in values.items():
        if value is not None and (slot := _STAGES.get(mask.rpartition(".")[2])):
            _core.close_default(slot)
        if isinstance(value, type):
            for name in [name for name, part in vars(value).items() if callable(part)]:
                setattr(value, name, _Absent(mask))
            continue
        ours = [one for name, one in sys.modules.copy().items() if _above(name, ["robsim"])]
        for module in ours:
            names = vars(module).copy().items()  # other threads import
            for name in [name for name, part in names if part is value is not None]:
                setattr(module, name, _Absent(mask))
        values[mask] = None


def _value_of(mask: str) -> Any:
    """Return a masked function or class of robsim; None = a module, or not robsim's."""
    package, _, name = mask.rpartition(".")
    try:
        is_module = find_spec(mask) is not None
    except (ImportError, ValueError):
        return None
    value = None if is_module else getattr(sys.modules.get(package), name, None)
    return value if callable(value) and type(value) is not _Absent else None


def _take_everywhere(value: Any, mask: str, restored: ExitStack) -> None:
    """Remove an object from the core and all rooms that offer it; their own code keeps it."""
    for name, module in sys.modules.copy().items():
        if value is None or not f"{name}.".startswith("robsim.") or name.startswith("robsim.teach"):
            continue
        offered = tuple(vars(module)) if name == "robsim._core" else vars(module).get("__all__", ())
        for attribute in [key for key in offered if vars(module).get(key) is value]:
            restored.callback(setattr, module, attribute, value)
            setattr(module, attribute, _Absent(mask))


def _packages_of(mask: str) -> tuple[str, ...]:
    """Return the modules that have a name: each top-level name of robsim is also in a wing."""
    package, _, name = mask.rpartition(".")
    both = ("robsim", f"robsim.{vars(sys.modules['robsim'])['_HOMES'].get(name)}")
    return both if package in both and both[1] in sys.modules else (package,)


def _take_attribute(package: str, mask: str, restored: ExitStack) -> None:
    """Remove a name from a module; the import of a masked module then fails."""
    name = mask.rpartition(".")[2]
    module = sys.modules.get(package)
    if module is None:
        return
    if name not in vars(module):
        if _is_late(module, name):
            setattr(module, name, _Absent(mask))
            restored.callback(delattr, module, name)
        return
    value = vars(module)[name]
    if issubclass(type(value), ModuleType):  # an _Absent of another mask has no __class__
        delattr(module, name)
    else:
        setattr(module, name, _Absent(mask))
    restored.callback(setattr, module, name, value)


def _is_late(module: ModuleType, name: str) -> bool:
    """Whether the first use of a name would load the name; the finder refuses modules."""
    rooms = vars(module).get("_homes")  # of a wing, which has the names of its rooms
    return name in vars(module).get("__all__", ()) if rooms is None else name not in rooms


def builtins_for(rules: Rules, own: Sequence[str], taken: Mapping[int, str]) -> dict[str, Any]:
    """Return the built-in names of a submission, with an ``import`` that follows the rules.

    The submission may always import its own modules. `taken` is the result of `masked`.
    """
    plain_import = builtins.__import__
    allowed = None if rules.imports is None else {*rules.imports, *own, "__future__"}

    def checked_import(
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] = (),
        level: int = 0,
    ) -> ModuleType:
        if not level:
            for whole in (name, *(f"{name}.{inner}" for inner in fromlist or ())):
                if mask := _above(whole, rules.masked):
                    raise NotHereError(mask)
                is_private = whole.startswith("robsim.") and "._" in whole
                if taken and is_private and not whole.endswith("__"):
                    raise NotHereError(whole)
            top = name.partition(".")[0]
            if allowed is not None and top not in allowed:
                may = ", ".join(sorted(rules.imports or ())) or "nothing"
                raise ImportError(
                    f"{top} may not be imported in this assignment; allowed: {may}", name=top
                )
        module = plain_import(name, globals, locals, fromlist, level)
        for inner in fromlist or ():
            if mask := taken.get(id(vars(module).get(inner))):
                raise NotHereError(mask)
        for whole in (name,) if not fromlist else [f"{name}.{inner}" for inner in fromlist]:
            room = sys.modules.get(whole) if whole.startswith("robsim.") else None
            for value in () if room is None else tuple(vars(room).values()):
                if mask := taken.get(id(value)):
                    raise NotHereError(mask)
        return module

    return {**vars(builtins), "__import__": checked_import}


def masked_in(sources: Mapping[str, bytes], masked: Sequence[str]) -> dict[str, str]:
    """Return the first mask whose object each module names, in any room, by the names of modules.

    It imports the rooms of robsim that a module names.
    """
    found: dict[str, str] = {}
    taken = {id(one): mask for mask in masked if (one := _value_of(mask)) is not None}
    for name, source in sources.items():
        with suppress(SyntaxError, ValueError, RecursionError, MemoryError):  # reported at loading
            for written in _dotted_names(ast.parse(source)):
                if mask := _above(written, masked) or taken.get(id(_of_robsim(written))):
                    found.setdefault(name, mask)
    return found


def _of_robsim(name: str) -> Any:
    with suppress(ImportError, AttributeError, ValueError):  # ValueError: no dotted name
        return resolve_name(name) if name.startswith("robsim.") else None


def _dotted_names(tree: ast.AST) -> Iterator[str]:
    """Yield all imports and attributes, the latter with imported names instead of aliases."""
    nodes, imported = [*_of_a_run(tree)], dict[str, str]()
    for node in nodes:
        if isinstance(node, ast.Import):
            imported |= {alias.asname: alias.name for alias in node.names if alias.asname}
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names = {one.asname or one.name: f"{node.module}.{one.name}" for one in node.names}
            imported |= names
            yield from names.values()
    for node in nodes:
        if isinstance(node, ast.Attribute):
            first, _, rest = ast.unparse(node).partition(".")
            yield f"{imported.get(first, first)}.{rest}"


def _of_a_run(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes except those for scripts or type checkers."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        yield (node := waiting.pop())
        tested = ast.walk(node.test) if isinstance(node, ast.If) else ()
        names = {one.id for one in tested if isinstance(one, ast.Name)}
        if isinstance(node, ast.If) and names & {"__name__", "TYPE_CHECKING"}:
            waiting += node.orelse
        else:
            waiting += ast.iter_child_nodes(node)
