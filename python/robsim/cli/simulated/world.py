"""The options of a world in the shell, one for each row of `robsim.simulation.options`."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Mapping
from inspect import Parameter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from robsim.cli.shared import WORLD, entry_of, kind_of
from robsim.cli.text import (
    about,
    parse_control,
    parse_dropout,
    parse_headings,
    parse_noise,
    parse_size,
    parse_start,
)
from robsim.control.by_name import POINTS
from robsim.simulation.option import Size
from robsim.simulation.slots import SLOTS

if TYPE_CHECKING:
    from robsim.simulation import Scenario, Simulation

Command = Callable[..., None]

_PARSERS: dict[str, Callable[[str, str], Any]] = {
    "headings": parse_headings,
    "noise": parse_noise,
    "dropout": parse_dropout,
    "start": parse_start,
    "control": parse_control,
}


def takes_world(command: Command) -> Command:
    """Give a command the options of a world, as its ``**world``; missing options are None."""
    signature = inspect.signature(command, eval_str=True)
    parameters = [one for one in signature.parameters.values() if one.kind is not one.VAR_KEYWORD]
    for name in WORLD:
        kind: Any = Annotated[kind_of(name), entry_of(name)]
        parameters.append(Parameter(name, Parameter.KEYWORD_ONLY, default=None, annotation=kind))
    shown = signature.replace(parameters=parameters)
    command.__signature__ = shown  # type: ignore[attr-defined]
    return command


def options_of(
    folder: Path | None,
    world: Mapping[str, Any],
    *,
    scenario: Path | Scenario | None,
    time_limit: float | None,
) -> dict[str, Any]:
    """Return the given options of `Simulation`; the scenario or the folder has the others."""
    from robsim.simulation import Scenario

    control = world["control"]
    _check_quotes(folder, control)
    options = {name: _checked(name, value) for name, value in world.items() if value is not None}
    if control is not None and control.partition(":")[0] in POINTS:
        options["measure"] = True
    if isinstance(scenario, Path):
        scenario = Scenario.load(scenario)
    others = {"time_limit": time_limit, "scenario": scenario}
    return options | {name: value for name, value in others.items() if value is not None}


def _checked(name: str, value: Any) -> Any:
    """Return the value of an option; an error names the option as the shell does."""
    option, row = f"--{name.replace('_', '-')}", WORLD[name]
    if name in _PARSERS:
        value = _PARSERS[name](option, value)
    elif isinstance(row, Size):
        value = parse_size(option, value)
    with about(option):
        return value if name in SLOTS else row.checked(value)


def simulation_of(folder: Path | None, options: dict[str, Any]) -> Simulation:
    """Return the simulation, with the callbacks of a folder if it is given."""
    from robsim.simulation import Simulation

    return Simulation(**options) if folder is None else Simulation.from_folder(folder, **options)


def _check_quotes(folder: Path | None, control: str | None) -> None:
    """Raise ValueError if a second point was taken for the folder."""
    if control and re.fullmatch(r"-?[\d.]+,-?[\d.]+", str(folder)):
        raise ValueError(
            f"--control: put quotes around the points, as '{control} {folder}'; otherwise "
            f"{folder} is taken for a folder"
        )
