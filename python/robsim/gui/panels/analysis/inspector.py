"""The inspector: a step as a tree."""

from __future__ import annotations

import inspect
import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np
from PIL import Image

from robsim._core import Frame, Step
from robsim.base.text import one_line, quoted, said_by
from robsim.gui._link import Link
from robsim.gui.panels.part import Handlers, Part

_MOST_NODES = 200  # of a level
_MOST_TEXT = 300  # characters
_MOST_NUMBERS = 6  # of an array, or keys of a dict, in its text
_SCALARS = (bool, int, float, complex, str, bytes, np.generic)
_CODE = (type, FunctionType, BuiltinFunctionType, MethodType, ModuleType)
_CONTAINERS = (list, tuple, set, frozenset)
_ROUNDED = ("number", "array", "object")  # kinds whose texts contain numbers
_NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d*)?(?:e[-+]?\d+)?(?=j?(?![\w.]))")

_LEAST_PIXELS, _MOST_PIXELS = 16, 480  # along a side of a picture


@dataclass(frozen=True)
class Missing:
    """A placeholder for a value that is unavailable now."""

    reason: str


def nodes_of(value: Any) -> list[dict[str, Any]]:
    """Return the children of a value, as nodes for the message ``tree``."""
    children = [*islice(_children(value), _MOST_NODES + 1)]
    nodes = [_node(name, child) for name, child in children[:_MOST_NODES]]
    if len(children) > _MOST_NODES:
        more = {"name": "...", "text": f"only the first {_MOST_NODES} are shown"}
        nodes[-1] = {**more, "kind": "missing", "more": False}
    return nodes


def child_of(value: Any, name: str) -> Any:
    """Return the child of a value by its node name; KeyError if the node is unknown."""
    for other, child in islice(_children(value), _MOST_NODES):
        if other == name:
            return child
    raise KeyError(name)


def _plain(value: Any) -> Any:
    """Return the plain Python container of a value, even if a user's class overrides methods."""
    return next(kind for kind in (dict, *_CONTAINERS) if _is(value, kind))


def _is(value: Any, kinds: type | tuple[type, ...]) -> bool:
    """Return the result of `isinstance` without reading the object's ``__class__``."""
    return issubclass(type(value), kinds)


def _node(name: str, value: Any) -> dict[str, Any]:
    try:
        kind, text = _described(value)
        has_more = next(_children(value), None) is not None
    except Exception as error:  # in use by the run, such as an estimator during a step
        kind, text, has_more = "missing", said_by(error), False
    node = {"name": name, "text": _short(text), "kind": kind, "more": has_more}
    if kind in _ROUNDED and (rounded := _NUMBER.sub(_rounded, text)) != text:
        node |= {"text": _short(rounded), "full": _short(text)}
    return node


def _rounded(found: re.Match[str]) -> str:
    """Return a number with 6 significant digits and all digits before the point."""
    digits = found[0]
    if digits.isdecimal():
        return digits
    number = float(digits)
    return f"{number:.0f}" if 1e6 <= number < 1e15 else f"{number:.6g}"


def _short(text: str) -> str:
    line = one_line(text[: 2 * _MOST_TEXT])
    return line if len(line) <= _MOST_TEXT else f"{line[: _MOST_TEXT - 4]} ..."


def _described(value: Any) -> tuple[str, str]:
    """Return the kind of a value, and its text."""
    if _is(value, Missing):
        return "missing", value.reason
    if value is None:
        return "none", "None"
    if _is(value, np.ndarray):
        return "array", _array_text(np.asarray(value))
    if _is(value, _SCALARS):
        return _scalar(value)
    if _is(value, (dict, *_CONTAINERS)):
        return _container(value)
    if _is(value, _CODE):
        return "code", f"{type(value).__name__} {getattr(value, '__name__', '')}"
    if _is_ours(value):
        return "object", repr(value)
    return "object", type(value).__qualname__


def _container(value: Any) -> tuple[str, str]:
    is_dict = _is(value, dict)
    count = _plain(value).__len__(value)
    text = f"{type(value).__name__} of {count}" if count else "empty"
    if is_dict and count:
        keys = [_key(key) for key in islice(dict.keys(value), _MOST_NUMBERS)]
        text = f"{text}: {', '.join(keys)}{', ...' if count > _MOST_NUMBERS else ''}"
    return ("dict" if is_dict else "list"), text


def _scalar(value: Any) -> tuple[str, str]:
    if _is(value, (str, bytes)):
        return "text", str.__repr__(value) if _is(value, str) else bytes.__repr__(value)
    return "number", quoted(value.item() if _is(value, np.generic) else value)


def _array_text(array: Any) -> str:
    items = array.flat[:_MOST_NUMBERS].tolist()
    is_plain = array.dtype != object
    first = ", ".join(quoted(one) if is_plain else _described(one)[1] for one in items)
    kind = "" if array.dtype == np.float64 else f" ({array.dtype})"
    if array.ndim == 0:
        return f"{first}{kind}"
    if array.ndim == 1 and array.size <= _MOST_NUMBERS:
        return f"[{first}]{kind}"
    dots = ", ..." if array.size > _MOST_NUMBERS else ""
    text = f"{' x '.join(map(str, array.shape))} values{kind}"
    return f"{text}: {first}{dots}" if array.size else text


def _children(value: Any) -> Iterator[tuple[str, Any]]:
    if _is(value, np.ndarray):
        array = np.asarray(value)
        if array.ndim and (array.ndim > 1 or array.size > _MOST_NUMBERS):
            yield from ((f"[{i}]", row) for i, row in enumerate(array))
    elif _is(value, (Missing, *_SCALARS, *_CODE)):
        return
    elif _is(value, dict):
        yield from ((_key(key), child) for key, child in list(dict.items(value)))
    elif _is(value, _CONTAINERS):
        items = _plain(value).__iter__(value)
        yield from ((f"[{i}]", child) for i, child in enumerate(items))
    elif value is not None:
        yield from _attributes(value)


def _key(key: Any) -> str:
    return _short(key if isinstance(key, str) else _described(key)[1])


def _is_ours(value: Any) -> bool:
    return type(value).__module__.split(".")[0] == "robsim"


def _attributes(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the public properties of robsim's objects; of other objects only stored attributes."""
    stored = _stored(value)
    if _is_ours(value):
        for name in _properties(type(value)):
            stored = {key: child for key, child in stored.items() if key != name}
            yield name, _asked(value, name)
        stored = {key: child for key, child in stored.items() if not key.startswith("_")}
    yield from ((_key(key), child) for key, child in stored.items())


def _stored(value: Any) -> dict[Any, Any]:
    try:
        found = object.__getattribute__(value, "__dict__")
    except AttributeError:
        return {}
    return dict(found) if isinstance(found, Mapping) else {}


def _properties(kind: type) -> list[str]:
    """Return the names of the public properties of a class, in the order of their definition."""
    bases = [base for base in reversed(kind.__mro__) if base.__module__ != "builtins"]
    names = dict.fromkeys(name for base in bases for name in vars(base))
    return [
        name
        for name in names
        if not name.startswith("_")
        and isinstance(inspect.getattr_static(kind, name, None), property)
    ]


def _asked(value: Any, name: str) -> Any:
    try:
        return getattr(value, name)
    except Exception as error:  # not decided yet, or in use by the run
        return Missing(str(error))


def picture_of(value: Any) -> tuple[dict[str, Any], bytes] | None:
    """Return the fields of the message for an array, and its picture (PNG); None for other values.

    Numbers are grey, from the smallest finite one to the largest. A large array is reduced.
    """
    if not _is(value, np.ndarray) or value.ndim < 2 or min(value.shape[:2]) < _LEAST_PIXELS:
        return None
    is_image = value.dtype == np.uint8 and value.shape[2:] == (3,)
    if not is_image and (value.ndim != 2 or value.dtype.kind not in "biuf"):
        return None
    step = -(-max(value.shape[:2]) // _MOST_PIXELS)
    pixels, ends = np.asarray(value)[::step, ::step], {}
    if not is_image:
        numbers = pixels.astype(np.float64)
        finite = numbers[np.isfinite(numbers)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
        scaled = (np.nan_to_num(numbers, nan=low).clip(low, high) - low) / ((high - low) or 1.0)
        pixels, ends = np.rint(255 * scaled).astype(np.uint8), {"low": low, "high": high}
    out = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(out, "PNG", compress_level=1)
    return {"size": [*value.shape[1::-1]], **ends}, out.getvalue()


class Inspector(Part):
    """Sends the contents of a step, level by level."""

    _newest: tuple[int, Step] | None = None  # number of resets, and the step
    _past: Step | None = None  # the last requested past step

    def handlers(self) -> Handlers:
        return {"inspect": self._inspect}

    def take(self, step: Step) -> None:
        self._newest = self.panel.record.n_resets, step

    def changed(self) -> None:
        self._past = None  # a reset invalidates it

    def _inspect(self, link: Link, message: dict[str, Any]) -> None:
        newest, path, n_steps = self._newest_step(), message["path"], self.panel.record.n_steps
        k = n_steps - 1 if message["k"] is None else message["k"]
        if newest is not None and (message["k"] is None or k == newest.k):
            _tell(link, newest, path)
        elif not 0 <= k < n_steps:
            _tell(link, None, path)
        elif self._past is not None and self._past.k == k:
            _tell(link, self._past, path)
        else:
            self.panel.check_room()
            self.panel.past.ask(k, lambda frame, _: self._tell_past(link, k, path, frame))

    def _newest_step(self) -> Step | None:
        """Return the newest step; None if no step came since the last reset."""
        n_resets, step = self._newest or (-1, None)
        return step if n_resets == self.panel.record.n_resets else None

    def _tell_past(self, link: Link, k: int, path: list[str], frame: Frame | None) -> None:
        if k < self.panel.record.n_steps:
            self._past = self.panel.record.step(k, frame)
            _tell(link, self._past, path)


def _tell(link: Link, step: Step | None, path: list[str]) -> None:
    """Send a level of the tree of a step; an unknown level is empty."""
    value: Any = step
    try:
        for name in path:
            value = child_of(value, name)
        nodes = nodes_of(value)
    except KeyError:
        nodes = []
        value = None
    k = None if step is None else step.k
    about, *picture = picture_of(value) or (None,)
    head = {"type": "tree", "k": k, "path": path, "nodes": nodes, "picture": about}
    link.send(head, picture)
