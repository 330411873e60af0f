"""`Submission`: a student's code, and its runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from os import PathLike
from typing import Any, Literal, TypeVar

from numpy.typing import ArrayLike

from robsim.base.checks import check_bool, check_choice, check_kind, check_text
from robsim.base.files import as_path
from robsim.base.seeds import Seed
from robsim.base.spelling import check_names
from robsim.base.text import quoted
from robsim.campaigns import CampaignResult, campaign
from robsim.campaigns.choices import FOLDER
from robsim.campaigns.engines.executors import DaskClient
from robsim.simulation import Scenario
from robsim.simulation.callbacks.checks import check_callback
from robsim.simulation.options import step_count
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.grading.arrays import as_arrays
from robsim.teach.grading.calling import Shape, called, wanted
from robsim.teach.grading.graded_run import GradedRuns, graded_run, seeds_of
from robsim.teach.grading.keys import Key
from robsim.teach.grading.robot_half import ROBOT_SLOTS
from robsim.teach.grading.task import Done, Task, check_samples, rules_of
from robsim.teach.isolation import Isolation, WorkerLimits
from robsim.teach.isolation.limits import LEVELS
from robsim.teach.submissions import read_submission
from robsim.trace import Trace

R = TypeVar("R")


class Submission:
    """A student's code, which runs in a separate process in a sandbox.

    The grader's process runs none of the student's code. Each run of a submission has a separate
    process with only the robot's software. That process receives frames or poses, and returns
    inputs and numbers, which the grader checks. The world, the truth and the trace stay in the
    grader's process. The trace of an honest submission is identical to a run in a single process,
    byte for byte.

    The grader computes all stages that the submission does not fill, so their results are trusted.
    Samples of the truth (`identify_from`) reveal the robot's pose. So only submissions that may
    fill the parameter estimator and no other stage get these samples; other submissions get only
    the parameters.

    A submission may fill slots of the world instead of slots of the robot's software. Then its
    process gets only the documented inputs of `evaluate_model` and `adjust_background`.

    Parameters
    ----------
    path : path
        A folder with a file for each slot or function, one Python file, a notebook, or a zip of
        these.
    slots : str or sequence of str
        The slots that the submission may fill, either of the robot's software or of the world.
    functions : str or sequence of str
        The functions that it may define, for `call`.
    imports : sequence of str, optional
        The modules that it may import. Default: all installed modules.
    masked : sequence of str
        Modules that it cannot use, such as ``"robsim.estimation.reference"``. robsim itself needs
        some modules to run a submission (`robsim.estimation`, `robsim.vision`, ...). For these
        modules, and for single names, the sandbox refuses only plain Python access: a search of the
        memory can still find them.
    defaults : bool
        Whether robsim's own code may fill slots: True, ``ENABLED = False``, its templates,
        its objects. By default such slots count as empty.
    frames : bool or "blobs", optional
        Whether it sees the frames, or only the blobs in them. By default the submission sees the
        frames only if it fills `measure`. Poses are cheaper.
    limits : WorkerLimits, optional
        The limits of its size and of a run: time, memory, output, files.
    isolation : {"auto", "strict", "process", "none"}
        The isolation of its process; see `check_isolation`.
    key : Key, optional
        The source of the runs' seeds. Default: the given seed of each run, else secret seeds, which
        are not stored.
    student : str, optional
        The name for the key. Default: the name of the file or folder.
    test : str, optional
        The default name of the test, for the key. pytest's fixture uses the name of
        the test function.
    given : mapping of str to bytes, optional
        Files for it by name, such as a module with the values of its task. They replace its
        copies.

    Raises
    ------
    SubmissionError
        If the submission is unreadable, has forbidden content, or fills no slot.
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Attributes
    ----------
    name : str
        Its name.
    output : str
        The printed output of the last run or call, cut; invisible characters are escaped.
    isolation_line : str
        The layers of the sandbox in that run.

    Examples
    --------
    >>> import pathlib
    >>> pathlib.Path("mine").mkdir()
    >>> size = pathlib.Path("mine/control.py").write_text("def control(step): return 0.2, 0.2")
    >>> submission = robsim.teach.Submission("mine", slots="control")
    >>> submission.run(robsim.Scenario(measure=True, seed=1), steps=20).u[0].tolist()
    [0.2, 0.2]
    """

    def __init__(
        self,
        path: str | PathLike[str],
        *,
        slots: str | Iterable[str] = (),
        functions: str | Iterable[str] = (),
        imports: Iterable[str] | None = None,
        masked: Iterable[str] = (),
        defaults: bool = False,
        frames: bool | Literal["blobs"] | None = None,
        limits: WorkerLimits | None = None,
        isolation: Isolation = "auto",
        key: Key | None = None,
        student: str | None = None,
        test: str | None = None,
        given: Mapping[str, bytes] | None = None,
    ) -> None:
        if isinstance(frames, str):
            check_choice("frames", frames, ("blobs",))
        elif frames is not None:
            check_bool("frames", frames)
        for name, value, kind in (("limits", limits, WorkerLimits), ("key", key, Key)):
            check_kind(name, value, kind, or_none=True)
        check_choice("isolation", isolation, LEVELS)
        path = as_path(path)
        _check_given(given)
        given_student = None if student is None else check_text("student", student)
        self._test = None if test is None else check_text("test", test)
        limits = limits or WorkerLimits()
        rules = rules_of(slots, functions, imports, masked, defaults, limits)
        files = read_submission(path, rules, given)
        self.name = files.name
        self.output = ""
        self.isolation_line = ""
        self._key = key
        self._student = files.name if given_student is None else given_student
        self._task = Task(
            submission=files, rules=rules, frames=frames, limits=limits, isolation=isolation
        )

    @property
    def slots(self) -> tuple[str, ...]:
        """The slots that it fills."""
        return tuple(name for name in self._task.submission.slots if name in SLOTS)

    @property
    def functions(self) -> tuple[str, ...]:
        """The functions of the assignment that the submission defines."""
        return tuple(name for name in self._task.submission.slots if name not in SLOTS)

    @property
    def notes(self) -> tuple[str, ...]:
        """A sentence for each omitted file."""
        return self._task.submission.notes

    def run(
        self,
        scenario: Scenario,
        *,
        steps: int,
        seed: Seed = None,
        test: str | None = None,
        number: int = 0,
        **callbacks: Any,
    ) -> Trace:
        """Run the submission once.

        Parameters
        ----------
        scenario : Scenario
            The world. A scenario without a model uses the default parameters.
        steps : int
            Number of steps.
        seed : int, SeedSequence or Generator, optional
            Seed of the run, the same as in ``Simulation(scenario, seed=seed)``: only for public
            tests, because it reveals all noise. Default: a seed from the key, `test` and `number`,
            or a secret seed without a key.
        test : str, optional
            The name of the test, for the key; each has other worlds. Default: the `Submission`'s
            name; required with a key.
        number : int
            The number of the run in the test, for the key.
        **callbacks
            The callbacks for other slots, as for `Simulation`; they run here, and are
            trusted.

        Returns
        -------
        Trace
            The run, with the truth.

        Raises
        ------
        SubmissionError
            If the submission fails: its code raises an exception, takes too long, ends its process,
            or returns an invalid result. The error names the slot, the step and the line.
        AssignmentError
            If one of `callbacks` fails.
        GraderError
            If no process can be started.
        TypeError, ValueError
            If an argument is wrong; the message names it. Also raised if `slots` has the parameter
            estimator and other stages, and the scenario identifies from the truth.
        """
        task = self._task_with(callbacks, scenario)
        n_steps = _checked(scenario, steps)
        test = self._test_of(test, seed)
        seeds = seeds_of(self._key, self._student, test, number, n_steps, seed)
        return self._noted(lambda: graded_run(task, scenario, n_steps, seeds))

    def _noted(self, act: Callable[[], Done[R]]) -> R:
        """Return the result of a run or of calls; note its output and isolation."""
        self.output = self.isolation_line = ""
        try:
            done = act()
        except SubmissionError as error:
            self.output = error.output
            raise
        self.output, self.isolation_line = done.output, done.layers
        return done.result

    def call(
        self,
        name: str,
        *arrays: ArrayLike,
        shape: Shape | list[Shape] | None = None,
        finite: bool = True,
    ) -> Any:
        """Call a function of the submission in a separate process in a sandbox.

        Parameters
        ----------
        name : str
            A name in `functions`.
        *arrays : array_like
            The arguments: at most 16 arrays of up to three axes, of real numbers, as float64, int64
            or uint8, of 64 MiB in all. An array without axes becomes a number.
        shape : tuple, or list of tuples, optional
            The required result: an array of that shape, None for an axis of any length, as in
            ``(None, 2)``; or, as a list, a tuple of several arrays. Default: any.
        finite : bool
            Whether all numbers must be finite.

        Returns
        -------
        array, number, or tuple of these
            The result, with the same limits as the arguments; lists of numbers become arrays.

        Raises
        ------
        SubmissionError
            If the function is missing, fails, takes too long, ends its process, or returns an
            invalid result. The error names the function and the line.
        GraderError
            If no process can be started.
        TypeError, ValueError
            If an argument is wrong; the message names it.

        Examples
        --------
        >>> submission = robsim.teach.Submission("mine", functions="fit")  # doctest: +SKIP
        >>> theta = submission.call("fit", phi, y, shape=(3, 5))  # doctest: +SKIP
        """
        (result,) = self.calls(name, [arrays], shape=shape, finite=finite)
        return result

    def calls(
        self,
        name: str,
        arguments: Iterable[Sequence[ArrayLike]],
        *,
        shape: Shape | list[Shape] | None = None,
        finite: bool = True,
    ) -> list[Any]:
        """Call a function of the submission many times in a single process.

        It may remember previous calls. Use `call` for independent calls.

        Parameters
        ----------
        name, shape, finite
            See `call`.
        arguments : iterable of tuple
            The arguments of each call.

        Returns
        -------
        list
            The result of each call.

        Raises
        ------
        SubmissionError, GraderError, TypeError, ValueError
            As in `call`; if one call fails, nothing is returned.
        """
        if check_text("name", name) not in self._task.rules.functions:
            known = ", ".join(self._task.rules.functions) or "none"
            raise ValueError(f"name must be one of the functions {known}, got {quoted(name)}")
        check_bool("finite", finite)
        result = wanted(shape, finite)
        given = [as_arrays("argument", each) for each in _listed(arguments)]
        if name not in self.functions:
            raise SubmissionError(f"{self.name} has no function {name}", slot=name)
        task = self._task.only([name])
        return self._noted(lambda: called(task, name, given, result))

    def runs(
        self,
        scenario: Scenario,
        *,
        runs: int,
        steps: int,
        metrics: Iterable[str | Callable[..., Any]] | Mapping[str, Any] | str | Callable[..., Any],
        seed: Seed = None,
        test: str | None = None,
        executor: int | str | Executor | DaskClient | None = None,
        store: str | PathLike[str] | None = None,
        keep: str = "numbers",
        progress: bool = False,
        callbacks: Mapping[str, Any] | None = None,
    ) -> CampaignResult:
        """Run the submission many times.

        Parameters
        ----------
        scenario, steps, test
            See `run`.
        runs : int
            Number of runs.
        metrics, executor, store, keep, progress
            See `robsim.campaign`.
        seed : int, SeedSequence or Generator, optional
            The seed of all runs, for public tests: run i has
            ``SeedSequence(seed, spawn_key=(i,))``. Default: seeds from the key, `test` and i, or
            secret seeds without a key.
        callbacks : mapping of str to callback, optional
            The callbacks of other slots, as in `run`; other processes need callbacks with a name
            in a module. A callback must not remember earlier runs.

        Returns
        -------
        CampaignResult
            A row for each run; a failed run has the error and its place. The case has the name of
            the submission.

        Raises
        ------
        TypeError, ValueError
            If an argument is wrong; the message names it.
        """
        _checked(scenario, steps)
        test = self._test_of(test, seed)
        if callbacks is not None and not isinstance(callbacks, Mapping):
            raise TypeError(
                f"callbacks must be a mapping of slot to callback, got {quoted(callbacks)}"
            )
        key = self._key or (Key.new() if seed is None else None)
        whole = GradedRuns(
            self._task_with(callbacks or {}, scenario),
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
            seed=0 if seed is None else seed,  # the key determines the seeds
            executor=executor,
            store=store,
            keep=keep,
            progress=progress,
        )

    def _test_of(self, test: str | None, seed: Seed) -> str:
        if test is None:
            test = self._test
        if test is None and self._key is not None and seed is None:
            raise ValueError("with a key, give the name of the test: test='drives a square'")
        return "" if test is None else check_text("test", test)

    def _task_with(self, callbacks: Mapping[str, Any], scenario: Scenario) -> Task:
        slots = self._task.rules.slots
        if not slots:
            raise ValueError("slots must have at least one slot for a run, got only functions")
        if not self.slots:
            raise SubmissionError(f"{self.name} fills no slot: it has no {' or '.join(slots)}")
        check_samples(slots, scenario)
        check_names("the robot half has no slot", callbacks, ROBOT_SLOTS, TypeError)
        for slot, callback in callbacks.items():
            if slot in self._task.rules.slots:
                raise ValueError(f"{slot} belongs to the submission: remove it from slots")
            check_callback(slot, callback)
        return dataclasses.replace(self._task.only(slots), callbacks=dict(callbacks))

    def __repr__(self) -> str:
        has = [("fills", self.slots), ("defines", self.functions)]
        told = "; ".join(f"{verb} {', '.join(names)}" for verb, names in has if names)
        return f"<Submission {quoted(self.name)}: {told}>"


def _listed(arguments: Any) -> list[Sequence[Any]]:
    listed: list[Any] = list(arguments) if isinstance(arguments, Iterable) else [None]
    for each in listed:
        if not isinstance(each, (tuple, list)):
            raise TypeError(f"arguments must be tuples, one for each call, got {quoted(arguments)}")
    return listed


def _check_given(given: Mapping[str, bytes] | None) -> None:
    if given is None:
        return
    if not isinstance(given, Mapping) or not all(
        isinstance(name, str) and isinstance(content, bytes) for name, content in given.items()
    ):
        raise TypeError(f"given must be a mapping of name to bytes, got {quoted(given)}")


def _checked(scenario: Scenario, steps: int) -> int:
    check_kind("scenario", scenario, Scenario)
    return step_count(steps)
