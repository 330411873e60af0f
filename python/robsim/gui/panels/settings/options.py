"""The options of a world in the panel: the forms of their values, as data of files."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from robsim.gui._link import Refused
from robsim.gui.panels.settings.world import made
from robsim.simulation import Scenario
from robsim.simulation.option import Choice, Number, Option
from robsim.simulation.options import OPTIONS
from robsim.simulation.scenario_file import data_of, options_of, units_of
from robsim.vision.robots.lookup import as_robot, robot_names

NONE, VALUE = "none", "value"  # forms; the others are words of the option, or the names of types


def option_of(name: str, data: Any) -> Any:
    """Return an option's value from a browser's data; TypeError, ValueError if it is invalid."""
    if name not in OPTIONS:
        raise Refused(f"unknown option {name!r}")
    if data is None:
        return OPTIONS[name].checked(None)
    if isinstance(data, str) and name == "seed" and data.isdecimal():
        return int(data)  # a browser cannot hold such large numbers
    if isinstance(data, str) and name == "markers" and data in robot_names():
        return OPTIONS[name].checked(data)
    return options_of({name: data})[name]


def default_of(name: str) -> Any:
    """Return the normal form of the default of an option."""
    return OPTIONS[name].checked(OPTIONS[name].default)


def described(option: Option, scenario: Scenario) -> dict[str, Any]:
    """Return a scenario's option in the form of the message ``options``."""
    value, default = getattr(scenario, option.name), default_of(option.name)
    form, forms = _form_of(option, value), _forms(option, scenario)
    is_known = form in forms
    if is_known:
        forms[form] = _data(option.name, form, value)
    kinds = {kind.__name__: kind for kind in option.types}
    facts = ("name", "group", "doc", "unit", "limits")
    return {name: getattr(option, name) for name in facts} | {
        "units": {"": option.unit} | (units_of(kinds[form]) if form in kinds else {}),
        "forms": [{"name": name, "data": data} for name, data in forms.items()],
        "form": form,
        "default": _data(option.name, _form_of(option, default), default),
        "changed": value != default,
        "fixed": not is_known,
    }


def _data(name: str, form: str, value: Any) -> Any:
    """Return the data of a value in an editable form."""
    if value is None or name == "seed":
        return value and str(value)
    return form if name in ("robot", "markers") or value == form else data_of(name, value)


def _forms(option: Option, scenario: Scenario) -> dict[str, Any]:
    """Return the editable forms of a value, each with initial data."""
    if isinstance(option, Choice):
        return {choice: choice for choice in option.choices}
    name, (width, height) = option.name, scenario.area
    forms: dict[str, Any] = {NONE: None} if _takes_none(option) else {}
    if name in ("robot", "markers"):
        forms |= {robot: robot for robot in robot_names()}
    for kind in option.types:
        if (example := _example(kind)) is not None:
            forms[kind.__name__] = data_of(name, example)
    if name == "start":
        return forms | {"random": "random", VALUE: [width / 2, height / 2, 0.0]}
    if isinstance(option, Number):
        forms[VALUE] = option.minimum if option.default is None else option.default
    elif not option.types or option.plain:
        first = {"seed": "1", "resolution": [width, height]}
        forms[VALUE] = first.get(name) or data_of(name, default_of(name))
    return forms


def _takes_none(option: Option) -> bool:
    try:
        return option.checked(None) is None
    except TypeError:
        return False


def _example(kind: Any) -> Any:
    """Return an initial value of a type; None if the panel cannot make one."""
    try:
        return made(kind, kind._LEVEL.default) if hasattr(kind, "_LEVEL") else kind()
    except TypeError:
        return None


def _form_of(option: Option, value: Any) -> str:
    if value is None:
        return NONE
    if isinstance(option, Choice) or value == "random":
        return str(value)
    for name in robot_names() if option.name in ("robot", "markers") else ():
        with suppress(OSError, ValueError):  # a file that was damaged by hand
            if value in (as_robot(name), as_robot(name).marker_layout()):
                return name
    kind = type(value)
    return kind.__name__ if kind in option.types else VALUE
