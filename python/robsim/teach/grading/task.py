"""The common data of all runs of a submission, and of all calls of its functions."""

from __future__ import annotations

import dataclasses
import glob
import importlib.util
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, Generic, Literal, TypeVar

from robsim.simulation import Scenario
from robsim.simulation.slots import ESTIMATORS, ROBOT, STEP, WORLD, names
from robsim.teach.isolation import Isolation, WorkerLimits
from robsim.teach.isolation.limits import room_for
from robsim.teach.submissions import Rules, SubmissionFiles
from robsim.teach.submissions.copies import codes_of

#: The slots of the world half.
WORLD_SLOTS = names(half=WORLD)
#: A submission's view of the frames: all, only the blobs in them, nothing; None = all if it
#: fills `measure`, else nothing.
Frames = bool | Literal["blobs"] | None


def given_to(slots: Iterable[str], frames: Frames) -> str:
    """Return the input of a submission that fills some slots: "frames", "blobs" or "pose"."""
    if frames == "blobs":
        return "blobs"
    return "frames" if ("measure" in slots if frames is None else frames) else "pose"


def rules_of(
    slots: str | Iterable[str],
    functions: str | Iterable[str],
    imports: Iterable[str] | None,
    masked: Iterable[str],
    defaults: bool,
    limits: WorkerLimits,
) -> Rules:
    """Return the rules of an assignment; raise TypeError or ValueError."""
    given: dict[str, Any] = {"slots": slots, "functions": functions, "imports": imports}
    given |= {"masked": masked, "defaults": defaults}
    rules = Rules(
        **given,
        files=limits.submission_files,
        size=limits.submission_size,
        file_size=limits.submission_file_size,
    )
    of_world = [slot for slot in rules.slots if slot in WORLD_SLOTS]
    if of_world and len(of_world) < len(rules.slots):
        other = next(slot for slot in rules.slots if slot not in of_world)
        raise ValueError(
            f"slots must all belong to the robot half, or all belong to the world, got {other} and "
            f"{of_world[0]}: callbacks of the world know the truth"
        )
    return rules


def check_samples(slots: Sequence[str], scenario: Scenario) -> None:
    stages = {*names(half=ROBOT, when=STEP)} - ESTIMATORS
    others = [slot for slot in slots if slot in stages]
    estimators = [slot for slot in slots if slot in ESTIMATORS]
    if estimators and others and scenario.identify_from == "truth":
        raise ValueError(
            f"slots has {estimators[0]} and {others[0]}, and identify_from is 'truth', but "
            f"{others[0]} must not know the robot's true pose. Use "
            "Scenario(identify_from='measurement'), or grade the two slots separately"
        )


R = TypeVar("R")


@dataclass(frozen=True)
class Done(Generic[R]):
    """The result of a run, or of calls."""

    result: R
    output: str  # printed by the submission, cut, with escapes
    layers: str  # of its sandbox, in a line


@dataclass(frozen=True, kw_only=True)
class Task:
    """The common data of all graded runs of a submission."""

    submission: SubmissionFiles
    rules: Rules
    frames: Frames = None
    limits: WorkerLimits = field(default_factory=WorkerLimits)
    isolation: Isolation = "auto"
    callbacks: Mapping[str, Any] = field(default_factory=dict)  # of the teacher

    def only(self, names: Iterable[str]) -> Task:
        """Return a copy for some of its slots and functions, which loads no others."""
        names = {*names}

        def some(known: tuple[str, ...]) -> tuple[str, ...]:
            return tuple(name for name in known if name in names)

        slots, functions = some(self.rules.slots), some(self.rules.functions)
        rules = dataclasses.replace(self.rules, slots=slots, functions=functions)
        files = dataclasses.replace(self.submission, slots=some(self.submission.slots))
        return dataclasses.replace(self, rules=rules, submission=files)

    @property
    def limits_of_worker(self) -> WorkerLimits:
        """The limits, with room for the submitted files, which are written there, too."""
        sizes = [len(content) for content in self.submission.sources.values()]
        return dataclasses.replace(
            self.limits,
            file_size=max(self.limits.file_size, *sizes),
            folder_size=max(self.limits.folder_size, 2 * room_for(sizes)),
        )


def hidden_files(rules: Rules) -> list[str]:
    """Return the files of masked modules, and of masked functions and classes of robsim."""
    hidden = [one for file in _files_with_code(rules) for one in _files_of(file)]
    for name in rules.masked:
        with suppress(ImportError, ValueError):
            found = importlib.util.find_spec(name)
            if found is not None and found.has_location and found.origin is not None:
                folders = found.submodule_search_locations
                hidden += list(folders) if folders else _files_of(found.origin)
    return hidden


def modules_with_masked(rules: Rules) -> list[str]:
    """Return the modules of robsim with code of masked functions and classes."""
    files = _files_with_code(rules)
    ours = [one for one in sys.modules.copy().items() if one[0].startswith("robsim.")]
    return sorted(name for name, module in ours if getattr(module, "__file__", None) in files)


def _files_with_code(rules: Rules) -> set[str]:
    files = set()
    for name in rules.masked:
        with suppress(ImportError, ValueError):
            if name.startswith("robsim.") and importlib.util.find_spec(name) is None:
                files |= {code.co_filename for code in codes_of(resolve_name(name))}
    return files


def _files_of(source: str) -> list[str]:
    """Return the file of a module, and its compiled files, existing or possible."""
    levels = ("", 1, 2)
    compiled = [importlib.util.cache_from_source(source, optimization=level) for level in levels]
    others = Path(compiled[0]).parent.glob(f"{glob.escape(Path(source).stem)}.*.pyc")
    return [source, *compiled, *map(str, others)]
