"""What a store notes of its campaign, so that another one is refused; what it was computed with."""

from __future__ import annotations

import functools
import hashlib
import inspect
import platform
import re
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from typing import Any

import numpy as np

from robsim.base.seeds import seed_record, seed_sequence
from robsim.base.text import quoted
from robsim.campaigns.choices import Callback, Factory, Folder, WholeRun
from robsim.campaigns.spec import CampaignSpec
from robsim.simulation import Scenario


def description_of(spec: CampaignSpec) -> dict[str, Any]:
    """Return what the numbers of a campaign depend on, but for the number of runs, as plain data.

    Code is told by its name and its text. What it calls elsewhere does not show.
    """
    given = {} if spec.given == "all" else {"given": spec.given}  # which older stores do not note
    return given | {
        "steps": spec.steps,
        "seed": seed_record(seed_sequence(spec.seed)),
        "options": {name: list(choices) for name, choices in spec.vary.items()},
        "scenarios": [_digest(_scenario_text(spec._scenario_of(case))) for case in spec.cases],
        "code": dict(_code(spec)),
        "metrics": {name: _told(metric) for name, metric in spec._functions.items()},
        "time_limit": spec.time_limit,
    }


def difference(there: Mapping[str, Any], here: Mapping[str, Any]) -> str | None:
    """Return in words what is not the same in two descriptions, None if all is."""
    for key, value in here.items():
        other = there.get(key)
        if other == value:
            continue
        if key == "scenarios":
            return "the scenario, or a value in vary, is another one there"
        if key in ("code", "metrics") and isinstance(other, Mapping):
            names = [name for name in (*value, *other) if value.get(name) != other.get(name)]
            return f"{names[0]} is not the same {'code' if key == 'code' else 'metric'} there"
        return f"{key} is {quoted(other)} there, {quoted(value)} here"
    return None


def surroundings() -> dict[str, str]:
    """Return versions and machine: in others the last digits of linear algebra may differ."""
    return {
        "robsim": version("robsim"),
        "numpy": np.__version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
    }


def _scenario_text(scenario: Scenario) -> str:
    try:
        return scenario.to_toml()
    except ValueError:  # an image that is too large for a text
        return repr(sorted((name, hash(value)) for name, value in scenario.changes().items()))


def _code(spec: CampaignSpec) -> Iterator[tuple[str, str]]:
    for name, choices in spec.vary.items():
        for label, choice in choices.items():
            what = f"{name} {label!r}"
            if isinstance(choice, Folder):
                files = sorted(choice.sources.items())
                yield what, _digest("".join(f"{file}\0{_digest(text)}" for file, text in files))
            elif isinstance(choice, WholeRun):
                yield what, _digest(choice.content)
            elif isinstance(choice, (Callback, Factory)):
                code = choice.make if isinstance(choice, Factory) else choice.function
                yield what, _told(code)


def _told(code: Any) -> str:
    """Return what tells a callable from another: its name, a digest of its text and arguments."""
    if isinstance(code, functools.partial):
        named = sorted(code.keywords.items())
        return f"{_told(code.func)}({_digest(_whole((code.args, named)))})"
    name = getattr(code, "__qualname__", type(code).__qualname__)
    try:
        text = inspect.getsource(code)
    except (OSError, TypeError):  # typed at a prompt, or compiled
        return name if callable(code) else _digest(repr(code))
    return f"{name} {_digest(text)}"


def _whole(value: Any) -> str:
    """Return what a value is, without what is cut in a message, or differs from start to start."""
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        return re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))


def _digest(text: str | bytes) -> str:
    content = text.encode() if isinstance(text, str) else text
    return hashlib.sha256(content).hexdigest()[:16]
