"""`Task`: an exercise for students, and the scores of its runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

from robsim.base.checks import Floats, check_int, check_kind
from robsim.base.files import write_new_files
from robsim.base.seeds import Seed
from robsim.base.text import listed
from robsim.campaigns.choices import Folder
from robsim.simulation import Scenario, Simulation
from robsim.simulation.slots import ONCE, SLOTS, AllCallbacks, RobotSlots
from robsim.teach.tasks.score import Score
from robsim.teach.tasks.solutions import (
    MODULE,
    Solution,
    module_source,
    shipped_solutions,
    starting_files,
)
from robsim.trace import Trace
from robsim.trace.trace import check_trace

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Names that no solution may import: answers, and the functions that compute them.
MASKED = (
    *("robsim.estimation.reference", "robsim.teach.tasks", "robsim.teach.exercises"),
    "robsim.teach.grading",
    # These would measure, estimate and control.
    *("robsim.Simulation", "robsim.Experiment", "robsim.campaign"),
)

MOST_STEPS, MOST_RUNS = 10_000, 1000


@dataclass(frozen=True, kw_only=True)
class Task(ABC):
    """An exercise for students: a world, the slots to fill, and scores for the runs.

    A subclass is a dataclass whose fields are the options, such as a goal or the noise. Tasks can
    be compared, sent to other processes, and written by name in an assignment.

    Attributes
    ----------
    name : str
        Its name in commands and files.
    title : str
        The task in a line.
    slots : tuple of str
        The slots that a solution fills.
    given : str
        The input of a solution at each step, in `try_solution` and in grading: ``"frames"``,
        ``"blobs"`` (no frame), ``"pose"`` (the measurement alone).
    scores : tuple of Score
        The numbers of a run; their shares sum to 1.
    masked : tuple of str
        Modules and names of robsim that a submitted solution cannot use.
    unscored : int
        Number of steps at the start of a run that do not count.
    steps : int
        Number of steps of a run.
    runs : int
        Number of runs of a test.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    slots: ClassVar[tuple[str, ...]]
    given: ClassVar[str]
    scores: ClassVar[tuple[Score, ...]]
    masked: ClassVar[tuple[str, ...]] = MASKED
    unscored: ClassVar[int] = 0

    steps: int = 60
    runs: int = 10

    def __post_init__(self) -> None:
        check_int("steps", self.steps, minimum=1, maximum=MOST_STEPS)
        check_int("runs", self.runs, minimum=1, maximum=MOST_RUNS)

    @property
    @abstractmethod
    def scenario(self) -> Scenario:
        """The world of the task's runs, without a seed."""

    @property
    @abstractmethod
    def values(self) -> Mapping[str, Any]:
        """The values for solutions, as names in the module ``task``: ``from task import GOAL``.

        Numbers, text, None, and tuples of these.
        """

    @abstractmethod
    def score(self, trace: Trace) -> dict[str, float]:
        """Return the numbers of a run by the names of `scores`; NaN = no number.

        Parameters
        ----------
        trace : Trace
            The run, with the truth.

        Raises
        ------
        NotRecordedError
            If the trace has no truth.
        TypeError
            If `trace` is no Trace.
        """

    def broken_rule(self, trace: Trace) -> str | None:
        """Return a sentence about the rule of the task that a run has broken, or else None.

        A run that breaks a rule has no numbers: all are NaN.

        Parameters
        ----------
        trace : Trace
            The run.
        """
        check_trace(trace)
        return None

    @property
    def goals(self) -> Floats | None:
        """The robot's goal: a pose (3,) or waypoints (N, 2); None = no goal."""
        return None

    def begin(self, folder: str | PathLike[str]) -> list[Path]:
        """Write the initial files of a student: the sheet, a file for each slot, and ``task.py``.

        Parameters
        ----------
        folder : path
            The folder; it is created if needed.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        TypeError
            If `folder` is no path.
        FileExistsError
            If one of them exists in the folder; then nothing is written.
        OSError
            If a file cannot be written.
        """
        sheet = {"sheet.md": self.sheet.encode()}
        module = {f"{MODULE}.py": module_source(self)}
        return write_new_files(sheet | starting_files(self) | module, folder)

    def figure(self, trace: Trace, reference: Trace | None = None) -> Figure:
        """Draw a run: its path, and the errors of each step.

        Parameters
        ----------
        trace : Trace
            The run.
        reference : Trace, optional
            The run of another solution in the same world.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. `robsim.plotting.plot_runs` draws several runs.

        Raises
        ------
        TypeError, ValueError
            If an argument is not a Trace, or has no steps.
        """
        from robsim.plotting.beside import draw_run  # matplotlib takes its time
        from robsim.plotting.style import check_optional, check_steps

        check_steps(trace)
        check_optional("reference", reference, Trace)
        figure, _ = draw_run(
            trace, reference, slots=self.slots, goals=self.goals, unscored=self.unscored
        )
        return figure

    @property
    def parameters(self) -> dict[str, Any]:
        """The options by name: ``type(task)(**task.parameters) == task``."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def sheet(self) -> str:
        """The sheet for students in Markdown, with the values of this task."""
        own = (_SHEETS / f"{self.name}.md").read_text(encoding="utf-8")
        return "\n\n".join([own.strip(), *_common(self, own)]) + "\n"

    @property
    def solutions(self) -> tuple[Solution, ...]:
        """The solutions in robsim: first the reference, then other right and wrong solutions."""
        return shipped_solutions(self.name, self.slots)

    def simulation(
        self,
        *,
        seed: Seed = None,
        time_limit: float | None = None,
        **callbacks: Unpack[AllCallbacks],
    ) -> Simulation:
        """Return a simulation of the task's world, for a run of `steps` steps.

        Parameters
        ----------
        seed : int, SeedSequence or Generator, optional
            The seed of the run. Default: an unpredictable one.
        time_limit : float, optional
            Maximum duration of a call of a callback (s).
        **callbacks
            The callbacks for the slots, as for `Simulation`.

        Returns
        -------
        Simulation
            ``task.score(task.simulation(...).run(task.steps))`` gives the numbers of the run.
        """
        return Simulation(self.scenario, seed=seed, time_limit=time_limit, **callbacks)


def check_task(task: Any) -> None:
    check_kind("task", task, Task)


def solution_folder(task: Task, solution: Solution) -> Folder:
    """Return the callback folder of a solution for a campaign: ``vary={"folder": {...}}``.

    Parameters
    ----------
    task : Task
        Its values are the module ``task`` in the folder.
    solution : Solution
        The solution.

    Raises
    ------
    TypeError
        If an argument has the wrong type.

    Examples
    --------
    >>> park = robsim.teach.ParkTask()
    >>> sorted(robsim.teach.solution_folder(park, park.solutions[0]).sources)
    ['control', 'robot', 'task']
    """
    check_task(task)
    check_kind("solution", solution, Solution)
    path = solution.folder or Path(solution.name)
    sources = {**solution.files, MODULE: module_source(task)}
    return Folder(str(path), str(path.absolute()), sources, task.slots)


_SHEETS = Path(__file__).parent / "sheets"

_GIVEN = {
    "frames": "The camera's frame, `step.frame`, and the coloured blobs found in it, `step.blobs`.",
    "blobs": "The coloured blobs in the camera's frame, `step.blobs`, but not the frame.",
    "pose": "The measured pose, `step.measurement`, or None where the robot was not seen.",
}
_SAMPLE = (
    'The newest sample, `step.sample`, of poses from the option `identify_from="{}"`. '
    "`step.measurement` is None, because the measurement follows this stage."
)


def table_of(values: Mapping[str, Any]) -> str:
    """Return the table of a sheet with numbers by name."""
    rows = (f"| `{name}` | `{value!r}` |" for name, value in values.items())
    return "\n".join(["| name | value |", "| --- | --- |", *rows])


def _common(task: Task, own: str) -> Iterator[str]:
    yield "## Your files"
    yield "\n".join(_files(task))
    yield "## Your inputs"
    example = f"`from task import {next(iter(task.values))}`"
    yield f"{' '.join(_given(task))} And from the module `task`, as {example}:"
    yield table_of(task.values)
    yield (
        "Each run has a separate seed, and so differs from others. You may import numpy, Python's "
        f"standard library, files of your own, and robsim without {listed(_masked(task))}. "
        "Grading does not accept a function, object or default stage of robsim in a slot, a file "
        "that is switched off, or an untouched template."
    )
    yield "## How it is scored"
    rows = (f"| {one.title} | {one.unit} | {_share_of(one)} |" for one in task.scores)
    yield "\n".join(["| score | unit | share of the points |", "| --- | --- | --- |", *rows])
    yield (
        "Your code does a number of `runs`, each of `steps` steps, and so does a reference in the "
        "same worlds. A score is the ratio of your number to the reference's, as the geometric "
        "mean over the runs: about as good as the reference gives all points. A typical "
        "mistake, even the smallest, gives no points; the limit for this is at least 1.5 times the "
        "limit of all points. A run that ends with an error has no points."
    )
    if any(one.kind == "lost" for one in task.scores):
        yield (
            "Lost frames multiply all other points: without a pose a controller cannot act, "
            "however exact the poses of other frames are. With half as many right poses as the "
            "reference there are no points."
        )
    yield "The numbers of the runs, which the module `task` does not have:"
    told = ("steps", "runs", *(name for name in task.parameters if f"`{name}`" in own))
    yield table_of({name: task.parameters[name] for name in dict.fromkeys(told)})
    yield "## Try it"
    yield "\n".join(
        [
            "```",
            f"robsim tasks show {task.name} --to mine",
            f"robsim tasks try {task.name} mine",
            f"robsim check mine --task {task.name}  # which score is short, and why",
            "```",
        ]
    )


def _given(task: Task) -> Iterator[str]:
    of_samples = {RobotSlots.init_parameter_estimator.name, RobotSlots.estimate_parameters.name}
    if not of_samples.issuperset(task.slots):
        yield _GIVEN[task.given]
    if RobotSlots.estimate_parameters.name in task.slots:
        yield _SAMPLE.format(task.scenario.identify_from)


def _share_of(score: Score) -> str:
    return f"{100 * score.share:.0f} %" if score.share else "multiplies the others"


def _files(task: Task) -> Iterator[str]:
    for slot in (SLOTS[name] for name in task.slots):
        when = "once, at the start" if slot.when == ONCE else "at each step"
        yield f"- `{slot.name}.py` with `{slot.signature}`, called {when}: {slot.result}."


def _masked(task: Task) -> list[str]:
    """Return the masked names, each once; a top-level name also stands for its module."""
    masked = {"robsim.teach" if name.startswith("robsim.teach.") else name for name in task.masked}
    names = {name.rpartition(".")[2]: name for name in sorted(masked, reverse=True)}
    return [f"`{name}`" for name in sorted(names.values())]
