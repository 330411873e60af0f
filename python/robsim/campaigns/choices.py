"""The possible values of a campaign's option: a value, a callback or its factory, a folder."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from inspect import isclass, isroutine
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from robsim.base.checks import check_float, check_name, is_int
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.simulation import Scenario
from robsim.simulation.callback_folder import CallbackFolder
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.callbacks.signatures import accepts
from robsim.simulation.scenario import OPTIONS
from robsim.simulation.slots import AT_START, SLOTS, is_default
from robsim.trace import Trace

#: The option whose values are whole folders of callbacks.
FOLDER = "folder"

Label = str | int | float


@dataclass(frozen=True)
class Data:
    """A value of an option of the scenario."""

    value: Any


@dataclass(frozen=True)
class Callback:
    """A callback without memory, shared by all runs, or a native component."""

    slot: str
    function: Any


@dataclass(frozen=True)
class Factory:
    """A factory of a fresh callback for each run."""

    slot: str
    make: Callable[[], Any]


@dataclass(frozen=True)
class Folder:
    """A folder of callbacks, with its files at the creation of the campaign."""

    path: str
    absolute: str
    sources: Mapping[str, bytes]
    slots: tuple[str, ...]
    warns: bool = True  # of doubtful results

    @classmethod
    def read(cls, path: str | PathLike[str], slots: tuple[str, ...]) -> Folder:
        """Read the files for some slots; raise the exceptions of `Simulation.from_folder`."""
        folder = CallbackFolder(path, slots)
        folder.load()
        absolute = str(Path(path).absolute())
        return cls(fspath(path), absolute, dict(folder.sources), slots)

    @contextmanager
    def callbacks(self) -> Iterator[dict[str, Any]]:
        """Give callbacks with separate modules, which import each other in the context."""
        folder, callbacks = CallbackFolder.of_sources(
            Path(self.path), Path(self.absolute), self.sources, self.slots
        )
        with folder.importable():
            yield {slot: callback for slot, callback in callbacks.items() if callback is not False}


class WholeRun(ABC):
    """An external way to do runs, without a simulation here: a value of `FOLDER`."""

    @abstractmethod
    def trace(
        self, scenario: Scenario, steps: int, *, seed: np.random.SeedSequence, run: int
    ) -> Trace:
        """Do a run, given its seed and its number in the campaign."""

    @property
    @abstractmethod
    def content(self) -> bytes:
        """The content that the runs depend on, in addition to scenario, steps and seed."""


Choice = Data | Callback | Factory | Folder | WholeRun


def options_value(vary: Any) -> dict[str, dict[Label, Choice]]:
    """Return the option ``vary`` as choices by option and label; else raise."""
    if vary is None:
        return {}
    if not isinstance(vary, Mapping):
        raise TypeError(f"vary must be a mapping of option to its values, got {quoted(vary)}")
    return {_option_name(name): _choices(name, values) for name, values in vary.items()}


def _option_name(name: Any) -> str:
    if not isinstance(name, str):
        raise TypeError(f"vary must have option names as keys, got {quoted(name)}")
    check_names("vary: a simulation has no option", [name], (*OPTIONS, *SLOTS, FOLDER), ValueError)
    return name


def _choices(name: str, values: Any) -> dict[Label, Choice]:
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise TypeError(
            f"vary: {name} must have a list of values, or a mapping of label to value, "
            f"got {quoted(values)}"
        )
    if isinstance(values, Mapping):
        labelled = [(_label(name, label), value) for label, value in values.items()]
    else:
        labelled = [(_label_of(name, value), value) for value in values]
    if not labelled:
        raise ValueError(f"vary: {name} must have at least one value, got none")
    choices: dict[Label, Choice] = {}
    for label, value in labelled:
        if str(label) in map(str, choices):
            raise ValueError(f"vary: {name} must have different labels, got {quoted(label)} twice")
        choices[label] = choice_of(name, value)
    return choices


_LONGEST_LABEL = 40  # characters


def _label(name: str, label: Any) -> Label:
    if isinstance(label, str):
        return check_name(f"vary: a label of {name}", label)
    if is_int(label):
        return int(label)
    if isinstance(label, float):
        return check_float(f"vary: a label of {name}", label)
    raise TypeError(f"vary: a label of {name} must be text or a number, got {quoted(label)}")


def _label_of(name: str, value: Any) -> Label:
    """Return the label of a value without one: numbers stay numbers."""
    if isinstance(value, PathLike) or (isinstance(value, str) and name in (*SLOTS, FOLDER)):
        value = Path(value).name
    if isinstance(value, (str, float)) or is_int(value):
        return _label(name, value)
    if isinstance(value, (bool, type(None))):
        return str(value)
    if isclass(value) or isroutine(value):
        if value.__name__ != "<lambda>":
            return check_name(f"vary: a label of {name}", value.__name__)
    else:
        is_data = not callable(value) or (name in SLOTS and type(value) in SLOTS[name].native)
        text = repr(value) if is_data else ""
        if 0 < len(text) <= _LONGEST_LABEL and text.isprintable():
            return text
    raise ValueError(
        f"vary: {name} needs a label for {quoted(value)}: give a mapping of label to value, such "
        "as {'mine': ...}"
    )


def choice_of(name: str, value: Any, argument: str = "vary: ") -> Choice:
    """Return a value of an option as a choice; messages begin with its argument."""
    if isinstance(value, (Data, Callback, Factory, Folder, WholeRun)):
        return value
    if name == FOLDER:
        if not isinstance(value, (str, PathLike)):
            raise TypeError(f"{argument}folder must be the path of a folder, got {quoted(value)}")
        return Folder.read(value, tuple(SLOTS))
    if name not in SLOTS:
        return Data(value)
    if is_default(name, value):
        value = None
    if isinstance(value, (str, PathLike)):
        return Folder.read(value, (name,))
    is_data = value is None or isinstance(value, bool) or type(value) in SLOTS[name].native
    if is_data and name in OPTIONS:
        check_callback(name, value)
        return Data(value)
    if not callable(value) or is_data or name in AT_START:
        check_callback(name, value)
        return Callback(name, value)
    return _code(name, value, argument)


def _code(slot: str, value: Any, argument: str) -> Factory | Callback:
    """Return a callable for a slot of each step: the callback, or its factory."""
    is_plain = isroutine(value) or isclass(value) or isinstance(value, functools.partial)
    if accepts(value, 0) and is_plain:
        check_callback(slot, value())
        return Factory(slot, value)
    if isclass(value) or not isroutine(value) or getattr(value, "__self__", None) is not None:
        what = "the class" if isclass(value) else "an object that may store data of a run:"
        raise TypeError(
            f"{argument}{slot} must be a plain function, or a function without arguments that "
            f"makes the callback, such as lambda: ..., got {what} {quoted(value)}"
        )
    check_callback(slot, value)
    return Callback(slot, value)


def scenario_of(base: Scenario, chosen: Mapping[str, Choice]) -> Scenario:
    """Return the scenario of a case."""
    data = {name: choice.value for name, choice in chosen.items() if isinstance(choice, Data)}
    return base.replace(**data) if data else base
