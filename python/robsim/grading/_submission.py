"""`Submission`: what somebody has handed in, and its runs."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from robsim._base.checks import check_bool, check_choice, check_int
from robsim._base.seeds import Seed
from robsim._base.source_line import SourceLine
from robsim._base.spelling import check_names
from robsim._base.text import quoted
from robsim.campaigns import CampaignResult, campaign
from robsim.campaigns._choices import FOLDER, WholeRun
from robsim.campaigns._engines.executors import DaskClient
from robsim.grading._errors import SubmissionError
from robsim.grading._graded_run import GradedRun, Task, graded_run
from robsim.grading._isolation import Isolation, Limits
from robsim.grading._isolation._request import LEVELS
from robsim.grading._keys import Key
from robsim.grading._robot_half import ROBOT_SLOTS
from robsim.grading._seeds import RunSeeds
from robsim.grading._submissions import Rules, read_submission
from robsim.simulation import FailedCallback, Scenario
from robsim.simulation._callbacks.checks import check_callback
from robsim.simulation._options import step_count
from robsim.trace import Trace


class Submission:
    """What somebody has handed in, run in a process that is shut in.

    Nothing of it is run in this process. Each run has a process of its own, which has the robot
    half alone: frames or poses go over, inputs and numbers come back, and are checked. This
    process has the world half, the truth and the trace. An honest submission gives the same trace
    as in one process, byte for byte.

    A stage that the submission does not fill is done here, so that nobody can say what it gave.
    Samples of the truth (`identify_from`) go to it only where parameters are estimated: they tell
    where the robot is. With ``"measurement"`` they tell what it knows.

    Parameters
    ----------
    path : path
        A folder with a file for each slot, one Python file, a notebook, or a zip of these.
    slots : str or sequence of str
        The slots of the robot half that it may fill.
    imports : sequence of str, optional
        The modules that it may import. Default: all that there are.
    masked : sequence of str
        Modules that it cannot have, such as ``"robsim.reference"``. Of those that robsim itself
        needs to run a submission (`robsim.evaluation`, `robsim.vision`, ...), and of single names,
        only what is written in plain Python is refused: code that searches memory finds them.
    frames : bool, optional
        Whether it sees the frames. Default: if it fills `measure`. Poses are cheaper.
    limits : Limits, optional
        What a run may take: time, memory, output, files.
    isolation : {"auto", "strict", "process", "none"}
        How its process is shut in; see `check_isolation`.
    key : Key, optional
        What the seeds of the runs come from. Default: those that are given with each run, else
        secret ones that are forgotten.
    student : str, optional
        The name for the key. Default: that of the file or folder.

    Raises
    ------
    SubmissionError
        If it cannot be read, has what it may not have, or fills none of the slots.
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Attributes
    ----------
    name : str
        Its name.
    output : str
        What it has printed in the last run by `run`, cut; what cannot be seen stands as escapes.
    isolation_line : str
        What has shut it in then.

    Examples
    --------
    >>> submission = robsim.grading.Submission("mine", slots="control")  # doctest: +SKIP
    >>> trace = submission.run(robsim.Scenario(measure=True), steps=100)  # doctest: +SKIP
    """

    def __init__(
        self,
        path: str | PathLike[str],
        *,
        slots: str | Iterable[str],
        imports: Iterable[str] | None = None,
        masked: Iterable[str] = (),
        frames: bool | None = None,
        limits: Limits | None = None,
        isolation: Isolation = "auto",
        key: Key | None = None,
        student: str | None = None,
    ) -> None:
        rules = _rules(slots, imports, masked)
        if frames is not None:
            check_bool("frames", frames)
        for name, value, kind in (("limits", limits, Limits), ("key", key, Key)):
            if value is not None and not isinstance(value, kind):
                raise TypeError(f"{name} must be {kind.__name__}, got {quoted(value)}")
        check_choice("isolation", isolation, LEVELS)
        files = read_submission(path, rules)
        self.name = files.name
        self.output = ""
        self.isolation_line = ""
        self._key = key
        self._student = files.name if student is None else _name("student", student)
        self._task = Task(
            submission=files,
            rules=rules,
            frames=frames,
            limits=limits or Limits(),
            isolation=isolation,
        )

    @property
    def slots(self) -> tuple[str, ...]:
        """The slots for which it has something."""
        return self._task.submission.slots

    @property
    def notes(self) -> tuple[str, ...]:
        """What was left out when it was read, as sentences."""
        return self._task.submission.notes

    def run(
        self,
        scenario: Scenario,
        *,
        steps: int,
        seed: Seed = None,
        test: str = "",
        number: int = 0,
        **callbacks: Any,
    ) -> Trace:
        """Run it once.

        Parameters
        ----------
        scenario : Scenario
            The world. Where it has no model, that of the default parameters.
        steps : int
            Number of steps.
        seed : int, SeedSequence or Generator, optional
            Seed of the run, which is then that of ``Simulation(scenario, seed=seed)``: for public
            tests, as who knows it knows all noise. Default: from the key, by `test` and `number`;
            without a key a secret one.
        test : str
            The name of the test, for the key.
        number : int
            The number of the run in the test, for the key.
        **callbacks
            What fills slots that the submission may not fill, as for `Simulation`; it is run here,
            and is trusted.

        Returns
        -------
        Trace
            The run, with the truth.

        Raises
        ------
        SubmissionError
            If the submission fails: its code raises an exception, takes too long, ends its process,
            or gives what cannot be; with slot, step and line.
        AssignmentError
            If one of `callbacks` fails.
        GraderError
            If no process can be started.
        """
        task = self._task_with(callbacks)
        n_steps = _checked(scenario, steps)
        _name("test", test)
        seeds = _seeds(self._key, self._student, test, number, n_steps, seed)
        return self._noted(task, scenario, n_steps, seeds).trace

    def _noted(self, task: Task, scenario: Scenario, steps: int, seeds: RunSeeds) -> GradedRun:
        self.output = self.isolation_line = ""
        try:
            result = graded_run(task, scenario, steps, seeds)
        except SubmissionError as error:
            self.output = error.output
            raise
        self.output, self.isolation_line = result.output, result.layers
        return result

    def runs(
        self,
        scenario: Scenario,
        *,
        runs: int,
        steps: int,
        metrics: Iterable[str | Callable[..., Any]] | Mapping[str, Any] | str | Callable[..., Any],
        seed: Seed = None,
        test: str = "",
        executor: int | str | Executor | DaskClient | None = None,
        store: str | PathLike[str] | None = None,
        keep: str = "numbers",
        progress: bool = False,
        callbacks: Mapping[str, Any] | None = None,
    ) -> CampaignResult:
        """Run it many times.

        Parameters
        ----------
        scenario, steps, test
            As in `run`.
        runs : int
            Number of runs.
        metrics, executor, store, keep, progress
            As in `robsim.campaign`.
        seed : int, SeedSequence or Generator, optional
            What the seeds of the runs come from: that of run i is
            ``SeedSequence(seed, spawn_key=(i,))``, for public tests. Default: from the key, by
            `test` and i; without a key secret ones.
        callbacks : mapping of str to callback, optional
            What fills other slots, as in `run`; for other processes it must have a name in a
            module. One that remembers its run is none for many.

        Returns
        -------
        CampaignResult
            A row for each run; of one that failed, what the submission did, and where. Its case has
            the name of the submission.

        Raises
        ------
        TypeError, ValueError
            If an argument is wrong; the message names it.
        """
        _checked(scenario, steps)
        _name("test", test)
        if callbacks is not None and not isinstance(callbacks, Mapping):
            raise TypeError(
                f"callbacks must be a mapping of slot to callback, got {quoted(callbacks)}"
            )
        key = self._key or (Key.new() if seed is None else None)
        whole = _GradedRuns(
            self._task_with(callbacks or {}),
            None if seed is not None else key,
            self._student,
            test,
        )
        return campaign(
            scenario,
            vary={FOLDER: {self.name: whole}},
            metrics=metrics,
            runs=runs,
            steps=steps,
            seed=0 if seed is None else seed,  # the key has those that count
            executor=executor,
            store=store,
            keep=keep,
            progress=progress,
        )

    def _task_with(self, callbacks: Mapping[str, Any]) -> Task:
        """Return what is run, with callbacks of the teacher's."""
        check_names("the robot half has no slot", callbacks, ROBOT_SLOTS, TypeError)
        for slot, callback in callbacks.items():
            if slot in self._task.rules.slots:
                raise ValueError(f"{slot} is for the submission to fill: leave it out of slots")
            check_callback(slot, callback)
        return dataclasses.replace(self._task, callbacks=dict(callbacks))

    def __repr__(self) -> str:
        return f"<Submission {quoted(self.name)}: fills {', '.join(self.slots)}>"


@dataclass(frozen=True)
class _GradedRuns(WholeRun):
    """Graded runs as those of a campaign."""

    task: Task
    key: Key | None
    student: str
    test: str

    def trace(
        self, scenario: Scenario, steps: int, *, seed: np.random.SeedSequence, run: int
    ) -> Trace:
        given = seed if self.key is None else None
        seeds = _seeds(self.key, self.student, self.test, run, steps, given)
        try:
            return graded_run(self.task, scenario, steps, seeds).trace
        except SubmissionError as error:  # a row has the line of a callback
            if error.slot is not None and error.file is not None:
                line = SourceLine(error.file, error.line or 1, "")
                error.callback = FailedCallback(error.slot, error.step, line)  # type: ignore[attr-defined]
            raise

    @property
    def content(self) -> bytes:
        rules, files = self.task.rules.to_dict(), self.task.submission.to_message()
        return pickle.dumps((rules, self.task.frames, self.student, self.test)) + files


def _rules(
    slots: str | Iterable[str], imports: Iterable[str] | None, masked: Iterable[str]
) -> Rules:
    wanted: Any = (slots,) if isinstance(slots, str) else slots
    rules = Rules(slots=wanted, imports=imports, masked=masked)  # type: ignore[arg-type]
    if others := [slot for slot in rules.slots if slot not in ROBOT_SLOTS]:
        raise ValueError(
            f"slots must be of the robot half, {', '.join(ROBOT_SLOTS)}, got {others[0]}: what "
            "fills it knows the truth"
        )
    return rules


def _name(argument: str, name: str) -> str:
    if not isinstance(name, str):
        raise TypeError(f"{argument} must be a name, got {quoted(name)}")
    return name


def _checked(scenario: Scenario, steps: int) -> int:
    if not isinstance(scenario, Scenario):
        raise TypeError(f"scenario must be a Scenario, got {quoted(scenario)}")
    return step_count(steps)


def _seeds(key: Key | None, student: str, test: str, run: int, steps: int, seed: Seed) -> RunSeeds:
    if seed is not None:
        return RunSeeds.of(seed)
    check_int("number", run, minimum=0, maximum=2**62)
    return RunSeeds.of_key(key or Key.new(), student, test, run, steps)
