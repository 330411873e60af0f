"""`CampaignSpec`: the complete specification of a campaign's numbers, as one value."""

from __future__ import annotations

import functools
import hashlib
import inspect
import itertools
import platform
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib.metadata import version
from typing import Any

import numpy as np

from robsim.base.checks import check_choice, check_float, check_int
from robsim.base.seeds import Seed, seed_record, seed_sequence, seed_value
from robsim.base.text import quoted
from robsim.campaigns._metrics import Metric, metrics_value
from robsim.campaigns.choices import (
    Callback,
    Choice,
    Factory,
    Folder,
    Label,
    WholeRun,
    options_value,
    scenario_of,
)
from robsim.simulation import Scenario
from robsim.simulation.options import step_count

_MOST_RUNS = 10**7
_MOST_CASES = 10**5
#: Columns of the rows that are neither an option nor a number of a metric.
ROW_COLUMNS = ("case_id", "run", "error", "line", "seconds")


@dataclass(frozen=True)
class Case:
    """A combination of options.

    Attributes
    ----------
    index : int
        Its place in the product of the options, in which the last option changes first.
    labels : dict
        Option to the label of its value.

    Examples
    --------
    >>> spec = robsim.campaigns.CampaignSpec(
    ...     vary={"headings": [36, None]}, metrics="tracking", runs=1, steps=5
    ... )
    >>> [case.labels for case in spec.cases]
    [{'headings': 36}, {'headings': 'None'}]
    """

    index: int
    labels: Mapping[str, Label]

    def __str__(self) -> str:
        return ", ".join(f"{name}={label}" for name, label in self.labels.items()) or "the scenario"


@dataclass(frozen=True, kw_only=True)
class CampaignSpec:
    """The complete specification of a campaign's numbers.

    Attributes
    ----------
    scenario : Scenario
        The common options of the runs; its seed is not used.
    vary : dict
        Option to its choices by label; the cases are their product.
    metrics : dict
        Functions of the trace, by name.
    runs, steps : int
        Runs of each case; steps of each run.
    seed : int or SeedRecord
        Source of the runs' seeds, see `seed_of`.
    time_limit : float or None
        Maximum duration of a call of a callback (s), in wall-clock time: on a busy machine calls
        take longer, so that a tight limit makes runs fail by chance.
    keep : str
        Content of the store for each run: ``"numbers"``, or its trace, too: ``"traces"``.
    given : str
        Data available to callbacks: ``"all"``, or only the data during grading, ``"frames"``,
        ``"blobs"``, ``"pose"``.

    Examples
    --------
    >>> robsim.campaigns.CampaignSpec(
    ...     vary={"headings": [36, None]}, metrics="tracking", runs=4, steps=20, seed=1
    ... )
    <CampaignSpec: 2 cases x 4 runs of 20 steps, metrics tracking>
    """

    scenario: Scenario | None = None
    vary: Any = None
    metrics: Any
    runs: int
    steps: int
    seed: Seed = None
    time_limit: float | None = None
    keep: str = "numbers"
    given: str = "all"
    _is_unseeded: bool = field(default=False, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        scenario = Scenario() if self.scenario is None else self.scenario
        if not isinstance(scenario, Scenario):
            raise TypeError(f"scenario must be a robsim.Scenario, got {quoted(scenario)}")
        seed = scenario.seed if self.seed is None else self.seed
        object.__setattr__(self, "_is_unseeded", seed is None)
        if self.time_limit is not None:
            check_float("time_limit", self.time_limit, "s", exclusive_minimum=0)
        check_choice("keep", self.keep, ("numbers", "traces"))
        check_choice("given", self.given, ("all", "frames", "blobs", "pose"))
        for name, value in {
            "scenario": scenario.replace(seed=None),
            "vary": options_value(self.vary),
            "metrics": metrics_value(self.metrics),
            "runs": check_int("runs", self.runs, minimum=1, maximum=_MOST_RUNS),
            "steps": step_count(self.steps),
            "seed": seed_value(seed_sequence(seed)),
        }.items():
            object.__setattr__(self, name, value)
        n_cases = np.prod([len(choices) for choices in self.vary.values()], dtype=object)
        if n_cases > _MOST_CASES:
            raise ValueError(f"vary must have at most {_MOST_CASES} combinations, got {n_cases}")
        if self.steps < 1:
            raise ValueError("steps must be at least 1, got 0")
        for case in self.cases:
            self._scenario_of(case)  # raises for options that do not fit together

    @cached_property
    def cases(self) -> tuple[Case, ...]:
        """The product of the options, in which the last option changes first."""
        products = itertools.product(*self.vary.values())
        return tuple(
            Case(index, dict(zip(self.vary, labels, strict=True)))
            for index, labels in enumerate(products)
        )

    @cached_property
    def _taken(self) -> frozenset[str]:
        """The names of columns that no metric may have."""
        return frozenset((*ROW_COLUMNS, *self.vary))

    @cached_property
    def _shares_frames(self) -> bool:
        """Whether cases differ only in code without effect on frames, which they then share."""
        assert self.scenario is not None
        if self.scenario.camera_delay or len(self.cases) == 1:
            return False
        return all(_only_looks(one) for options in self.vary.values() for one in options.values())

    def _chosen(self, case: Case) -> dict[str, Choice]:
        return {name: self.vary[name][label] for name, label in case.labels.items()}

    def _scenario_of(self, case: Case) -> Scenario:
        """Return the scenario of a case, without a seed."""
        assert self.scenario is not None
        try:
            return scenario_of(self.scenario, self._chosen(case))
        except (TypeError, ValueError) as error:
            error.add_note(f"vary: in the case {case}")
            raise

    def seed_of(self, run: int) -> np.random.SeedSequence:
        """Return the seed of a run, which is the same for all cases of the campaign.

        Parameters
        ----------
        run : int
            Number of the run, from 0.

        Returns
        -------
        SeedSequence
            ``SeedSequence(entropy, spawn_key=(*spawn_key, run))``, with the values of `seed`.
        """
        root = seed_sequence(self.seed)
        check_int("run", run, minimum=0, maximum=_MOST_RUNS - 1)
        return np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, run))

    def _with_seed(self, seed: Seed) -> CampaignSpec:
        return replace(self, seed=seed)

    @property
    def _functions(self) -> dict[str, Metric]:
        functions: dict[str, Metric] = self.metrics
        return functions

    def __repr__(self) -> str:
        return (
            f"<CampaignSpec: {len(self.cases)} cases x {self.runs} runs of {self.steps} steps, "
            f"metrics {', '.join(self.metrics)}>"
        )


_LOOKING = {"init_parameter_estimator", "estimate_parameters", "measure", "estimate_state"}


def _only_looks(choice: Choice) -> bool:
    if isinstance(choice, Folder):
        return _LOOKING.issuperset(choice.sources.keys() & set(choice.slots))
    return isinstance(choice, (Callback, Factory)) and choice.slot in _LOOKING


def description_of(spec: CampaignSpec) -> dict[str, Any]:
    """Return the data that the numbers of a campaign depend on, without the number of runs.

    Code is identified by its name and its text, but not by the code it calls.
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
    """Return in words the first difference of two descriptions, None for equal ones."""
    for key, value in here.items():
        other = there.get(key)
        if other == value:
            continue
        if key == "scenarios":
            return "the scenario, or a value in vary, differs there"
        if key in ("code", "metrics") and isinstance(other, Mapping):
            names = [name for name in (*value, *other) if value.get(name) != other.get(name)]
            return f"{names[0]} is different {'code' if key == 'code' else 'metric'} there"
        return f"{key} is {quoted(other)} there, {quoted(value)} here"
    return None


def surroundings() -> dict[str, str]:
    """Return versions and machine: the last digits of linear algebra may depend on them."""
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
    """Return the identity of a callable: its name, a digest of its text and arguments."""
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
    """Return a value's full text, without parts that differ from start to start."""
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):
        return re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))


def _digest(text: str | bytes) -> str:
    content = text.encode() if isinstance(text, str) else text
    return hashlib.sha256(content).hexdigest()[:16]
