"""The runs of a campaign, one after the other, as done by a worker in any engine."""

from __future__ import annotations

import time
from contextlib import ExitStack
from typing import NamedTuple

from robsim._core import Sights
from robsim.base.source_line import line_of_error
from robsim.base.text import one_line, quoted, said_by
from robsim.campaigns._metrics import numbers_of
from robsim.campaigns.choices import Callback, Factory, Folder, WholeRun
from robsim.campaigns.spec import CampaignSpec, Case
from robsim.simulation import Simulation
from robsim.simulation.callbacks.errors import callback_of
from robsim.trace import Trace

#: A run, by the index of its case and its own number.
Job = tuple[int, int]


class Row(NamedTuple):
    """The row of a run; for a failed run the error, and the numbers of other metrics."""

    case: int
    run: int
    error: str | None
    line: str | None
    seconds: float
    numbers: dict[str, float]
    trace: bytes | None = None  # packed, where traces are kept


class CaseRuns:
    """The runs of a case: one simulation, reset for each."""

    def __init__(self, spec: CampaignSpec, case: Case) -> None:
        self._spec = spec
        self.case = case
        choices = spec._chosen(case)
        self._scenario = spec._scenario_of(case)
        self._fixed = {
            one.slot: one.function for one in choices.values() if isinstance(one, Callback)
        }
        self._factories = [one for one in choices.values() if isinstance(one, Factory)]
        # An option for a slot overrides a whole folder.
        folders = [one for one in choices.values() if isinstance(one, Folder)]
        self._folders = sorted(folders, key=lambda folder: -len(folder.slots))
        self._whole = next((one for one in choices.values() if isinstance(one, WholeRun)), None)
        self._named = set(choices)
        self._slots = {*choices, *(slot for folder in folders for slot in folder.slots)}
        self._simulation: Simulation | None = None
        self.sights: Sights | None = None  # of the same run of other cases

    def trace(self, run: int) -> Trace:
        """Run, and return the trace."""
        seed = self._spec.seed_of(run)
        if self._whole is not None:
            return self._whole.trace(self._scenario, self._spec.steps, seed=seed, run=run)
        if self._simulation is None:
            self._simulation = Simulation(
                self._scenario, seed=seed, time_limit=self._spec.time_limit, **self._fixed
            )
            self._simulation._warns = all(folder.warns for folder in self._folders)
            self._simulation._give(self._spec.given, self._slots)
        else:
            self._simulation.reset(seed=seed)
        simulation, self._simulation = self._simulation, None
        if self.sights is not None:
            simulation._core.share(self.sights)
        with ExitStack() as stack:
            for folder in self._folders:
                for slot, callback in stack.enter_context(folder.callbacks()).items():
                    if len(folder.slots) == 1 or slot not in self._named:
                        setattr(simulation, slot, callback)
            for factory in self._factories:
                setattr(simulation, factory.slot, factory.make())
            trace = simulation.run(self._spec.steps)
        simulation._warns = False  # the first run has warned
        self._simulation = simulation  # one that failed is not used again
        return trace

    def numbers(self, run: int) -> dict[str, float]:
        """Run, and return the numbers of the metrics; raise the error of the first that fails."""
        numbers, errors = self._numbers_of(self.trace(run))
        for name, error in errors.items():
            error.add_note(f"metric {quoted(name)}")
            raise error
        return numbers

    def _numbers_of(self, trace: Trace) -> tuple[dict[str, float], dict[str, BaseException]]:
        return numbers_of(self._spec._functions, trace, self._spec._taken)

    def row(self, run: int) -> Row:
        """Run, and return the numbers, and the error if any."""
        begin = time.perf_counter()
        numbers: dict[str, float] = {}
        packed, text, line = None, None, None
        try:
            trace = self.trace(run)
            numbers, errors = self._numbers_of(trace)
            packed = trace._packed() if self._spec.keep == "traces" else None
        except (Exception, SystemExit) as error:  # a callback that ends Python fails as others do
            text, line = said_by(error), _line_of(error)
        else:
            if errors:
                text = "; ".join(f"metric {quoted(n)}: {said_by(e)}" for n, e in errors.items())
                line = _line_of(next(iter(errors.values())))
        seconds = time.perf_counter() - begin
        return Row(self.case.index, run, text, line, seconds, numbers, packed)


class Worker:
    """Runs of any cases; it keeps the last case's simulation, or those that share frames."""

    def __init__(self, spec: CampaignSpec) -> None:
        self._spec = spec
        self._runs: dict[int, CaseRuns] = {}
        self._run, self._sights = -1, Sights()

    def row(self, job: Job) -> Row:
        case, run = job
        if case not in self._runs:
            if not self._spec._shares_frames:
                self._runs.clear()
            self._runs[case] = CaseRuns(self._spec, self._spec.cases[case])
        if self._spec._shares_frames:
            if run != self._run:
                self._run, self._sights = run, Sights()
            self._runs[case].sights = self._sights
        return self._runs[case].row(run)


def _line_of(error: BaseException) -> str | None:
    failed = callback_of(error)
    source = line_of_error(error) if failed is None else failed.source
    return None if source is None else one_line(source)
