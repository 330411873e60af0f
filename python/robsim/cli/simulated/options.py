"""The options of a simulation, which ``robsim run`` and ``robsim gui`` share."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robsim.cli.text import about, parse_control, parse_dropout, parse_noise, parse_size
from robsim.control.by_name import POINTS

if TYPE_CHECKING:
    from robsim.simulation import Scenario
    from robsim.simulation.simulation import Simulation


def shared_options(
    folder: Path | None,
    *,
    scenario: Path | Scenario | None,
    control: str | None,
    noise: str | None,
    dropout: str | None,
    area: str | None,
    time_limit: float | None,
    **others: Any,
) -> dict[str, Any]:
    """Return the options of a simulation that are given, of those that the commands share."""
    from robsim.simulation import Scenario
    from robsim.simulation.time_limit import TimeLimit

    _check_quotes(folder, control)
    world = given(
        area=parse_size("--area", area),
        noise=parse_noise("--noise", noise),
        dropout=parse_dropout("--dropout", dropout),
        **others,
    )
    check_each(world)
    with about("--time-limit"):
        limit = None if time_limit is None else TimeLimit(time_limit).seconds
    return world | given(
        time_limit=limit,
        measure=_needs_pose(control) or None,
        control=parse_control("--control", control),
        scenario=Scenario.load(scenario) if isinstance(scenario, Path) else scenario,
    )


def simulation_of(folder: Path | None, options: dict[str, Any]) -> Simulation:
    """Return the simulation, with the callbacks of a folder if there is one."""
    from robsim.simulation import Simulation

    return Simulation(**options) if folder is None else Simulation.from_folder(folder, **options)


def given(**options: Any) -> dict[str, Any]:
    """Return the options that are given: the others stay as the scenario or the folder has them."""
    return {name: value for name, value in options.items() if value is not None}


def check_each(options: dict[str, Any]) -> None:
    """Raise an error that names an option as the shell does, if one alone is wrong."""
    from robsim.simulation import Scenario

    for name, value in options.items():
        with about(f"--{name}"):
            Scenario(**{name: value})


def _check_quotes(folder: Path | None, control: str | None) -> None:
    """Raise ValueError if a second point was taken for the folder."""
    if control and re.fullmatch(r"-?[\d.]+,-?[\d.]+", str(folder)):
        raise ValueError(
            f"--control: put quotes around the points, as '{control} {folder}': without them "
            f"{folder} is taken for a folder"
        )


def _needs_pose(control: str | None) -> bool:
    return control is not None and control.partition(":")[0] in POINTS
