"""Campaigns as TOML files, for the command line."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

from robsim.base.files import as_path, codec
from robsim.base.text import cut, quoted
from robsim.campaigns._metrics import score_value
from robsim.campaigns.choices import FOLDER
from robsim.campaigns.spec import CampaignSpec
from robsim.simulation import Scenario
from robsim.simulation.options import OPTIONS
from robsim.simulation.scenario_file import MOST_BYTES, options_of
from robsim.simulation.slots import SLOTS

#: A campaign that can be run, with comments.
EXAMPLE = Path(__file__).with_name("example.toml").read_text(encoding="utf-8")

_NONE = "none"  # TOML has no None


def load_spec(path: str | PathLike[str], *, runs: int | None = None) -> CampaignSpec:
    """Read a campaign from a TOML file (see `EXAMPLE`); paths in it are relative to its folder.

    Functions and folders named in it are Python code, and run. `runs` replaces its number of runs.
    ValueError: the file is not TOML, or something in it is missing, unknown or wrong.
    """
    given = {} if runs is None else {"runs": runs}
    table = _table(as_path(path).absolute().parent)
    spec: CampaignSpec = codec.load_table(
        path, lambda values: table.read("campaign", values | given), "campaign file ", MOST_BYTES
    )
    return spec


def _table(folder: Path) -> codec.Table:
    def metrics(_: str, value: Any) -> list[Any]:
        return [_metric(one, folder) for one in (value if isinstance(value, list) else [value])]

    return codec.Table(
        CampaignSpec,
        {
            **dict.fromkeys(("runs", "steps", "seed", "time_limit", "keep"), ""),
            "metrics": metrics,
            "scenario": partial(_scenario, folder),
            "vary": codec.named(partial(_values, folder)),
        },
    )


def _metric(name: Any, folder: Path) -> Any:
    """Return a metric: its name, the function of ``"module:function"``, a score of a table."""
    if isinstance(name, dict):
        if not isinstance(kind := name.get("kind"), str):
            raise ValueError(
                f"metrics: a table must have a kind, such as 'score_path', got {quoted(name)}"
            )
        return score_value(kind, {key: value for key, value in name.items() if key != "kind"})
    if not isinstance(name, str) or ":" not in name:
        return name
    module, _, function = name.partition(":")
    if not all(map(str.isidentifier, module.split("."))):
        raise ValueError(f"metrics must be names or 'module:function', got {quoted(name)}")
    # Other processes also receive this path.
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    try:
        return getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"metrics: there is no {quoted(name)}: {cut(error)}") from error


def _scenario(folder: Path, name: str, value: Any) -> Scenario:
    if isinstance(value, str):
        return Scenario.load(folder / value)
    return Scenario(**options_of(codec.as_table(name, value, ", or a file")))


def _values(folder: Path, name: str, values: Any) -> Any:
    if isinstance(values, dict):
        labels = _labels(values)
        return {
            label: _value(name, value, folder)
            for label, value in zip(labels, values.values(), strict=True)
        }
    if not isinstance(values, list):
        raise TypeError(
            f"{name} must be a list of values, or a table of labels, got {codec.in_words(values)}"
        )
    return [_value(name, value, folder) for value in values]


def _labels(values: Mapping[str, Any]) -> list[Any]:
    """Return the labels of a table: as numbers, if all are numbers."""
    for kind in (int, float):
        try:
            return [kind(label) for label in values]
        except ValueError:
            pass
    return list(values)


def _value(name: str, value: Any, folder: Path) -> Any:
    if name == FOLDER or (name in SLOTS and isinstance(value, str) and value != _NONE):
        return folder / value if isinstance(value, str) else value
    if value == _NONE and ((name in OPTIONS and OPTIONS[name].is_table) or name in SLOTS):
        return None
    return options_of({name: value})[name] if name in OPTIONS else value
