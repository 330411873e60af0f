"""`FolderReport`: the checks of all callbacks of a folder on one page."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from functools import cache, wraps
from inspect import unwrap
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType
from typing import Any

from robsim._core import RobotModel, Step
from robsim.base.check_report import CheckReport, Problem
from robsim.base.files import as_path, write_whole
from robsim.base.report import Column, Row, Table
from robsim.base.source_line import SourceLine, line_of_error
from robsim.base.spelling import suggestion
from robsim.simulation.callback_folder import CallbackFolder
from robsim.simulation.slots import SLOTS, RobotSlots, WorldSlots, checked_slots
from robsim.teach.doctor._errors import explained
from robsim.teach.doctor._run_checks import fresh_callback, load, telling
from robsim.teach.doctor._trial import TIME_LIMIT, StdoutCapture
from robsim.teach.doctor.callbacks.backgrounds import check_background
from robsim.teach.doctor.callbacks.controllers import controller_report
from robsim.teach.doctor.callbacks.measurements import measurement_report
from robsim.teach.doctor.callbacks.models import check_model, check_motion
from robsim.teach.doctor.callbacks.scenes import Setting
from robsim.teach.doctor.parameter_estimators import check_parameter_estimator
from robsim.teach.doctor.state_estimators import check_estimator
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.at_home import callback_files, is_notebook, read_notebook

Maker = Callable[[], Callable[..., Any]]


@dataclass(frozen=True, kw_only=True)
class FolderReport(CheckReport):
    """The result of a check of callback files. ``bool(report)`` is `ok`.

    Attributes
    ----------
    name : str
        The file or the folder.
    checks : dict of str to CheckReport or str
        By slot: the report on its file; ``"default"`` or ``"off"`` if no callback of yours runs;
        or ``"not used"`` if the task does not use the slot.
    problems : tuple of Problem
        The problems of all files.
    remarks : tuple of str
        The remarks of all files and of the folder.

    Examples
    --------
    >>> import pathlib
    >>> pathlib.Path("mine").mkdir()
    >>> size = pathlib.Path("mine/control.py").write_text("def control(step): return 0.5")
    >>> report = robsim.teach.check_folder("mine")
    >>> bool(report), len(report.problems)
    (False, 1)
    """

    checks: Mapping[str, CheckReport | str] = field(default_factory=dict)

    @property
    def headline(self) -> str:
        """The verdict in one line."""
        checked = [check for check in self.checks.values() if isinstance(check, CheckReport)]
        ill = sum(not check.ok for check in checked)
        if not checked:
            return f"{self.name}: no callback is switched on"
        if len(checked) == 1:
            return f"{self.name}: the callback {'fails' if ill else 'passed all checks'}"
        if not ill:
            return f"{self.name}: all {len(checked)} callbacks passed all checks"
        return f"{self.name}: {ill} of {len(checked)} callbacks {'fails' if ill == 1 else 'fail'}"

    @property
    def verdicts(self) -> dict[str, str]:
        """The verdict by slot: ``"well"``, ``"ill"``, ``"remark"``, or the text in `checks`."""
        return {slot: _verdict(check) for slot, check in self.checks.items()}


def _verdict(check: CheckReport | str) -> str:
    if isinstance(check, str):
        return check
    return "ill" if not check.ok else "remark" if check.remarks else "well"


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """The world in which callbacks of a folder are checked."""

    setting: Setting = field(default_factory=Setting.usual)
    slots: tuple[str, ...] = tuple(SLOTS)  # that the folder may fill
    on: frozenset[str] | None = None  # the slots that are filled; None = as the folder has it
    given: Mapping[str, bytes] = field(default_factory=dict)  # modules that hide its own
    dt: float | None = None  # s; None = any
    notebook: str = ""  # its name, where the files run one
    masked: tuple[str, ...] = ()  # names that advice must not have

    def name_of(self, slot: str) -> str:
        """Return the name of the code for a slot."""
        return f"{slot} of {self.notebook}" if self.notebook else f"{slot}.py"

    def allowed(self, text: str) -> str:
        """Return a text without its advice (after a semicolon) if that has a masked name."""
        first, *others = text.split("; ")
        meant = (f"did you mean '{mask.rpartition('.')[2]}'" for mask in self.masked)
        names = (*self.masked, *meant)
        return "; ".join([first, *(one for one in others if not any(n in one for n in names))])

    def with_allowed(self, problems: Iterable[Problem]) -> tuple[Problem, ...]:
        """Return problems without such advice."""
        return tuple(replace(one, sentence=self.allowed(one.sentence)) for one in problems)


def report_of(
    path: str | PathLike[str], slots: str | Iterable[str] | None, around: Surroundings
) -> FolderReport:
    """Return the report on a folder or a file; `check_folder` documents the other arguments."""
    file = as_path(path)
    if is_notebook(file, around.slots):
        notebook = read_notebook(file, around.slots)
        with TemporaryDirectory() as place:
            for name, source in callback_files(notebook).items():
                write_whole(Path(place, f"{name}.py"), source)
            report = report_of(place, slots, replace(around, notebook=notebook.main))
            return replace(report, name=str(file))
    is_file = file.is_file()
    wanted = tuple(SLOTS) if slots is None else checked_slots(slots, tuple(SLOTS))
    if is_file:
        wanted = (_slot_of(file, wanted),)
    elif not file.exists() and file.suffix == ".py":
        raise FileNotFoundError(f"file {file} is missing")
    folder = _Folder(file.parent if is_file else file, around, is_alone=is_file)
    checks = {slot: folder.check(slot) for slot in SLOTS if slot in wanted}
    reports = {slot: one for slot, one in checks.items() if isinstance(one, CheckReport)}
    rows = [
        Row(slot, (_verdict(check), around.name_of(slot) if slot in reports else ""))
        for slot, check in checks.items()
    ]
    columns = (Column("verdict", "verdict", ""), Column("file", "file", ""))
    return FolderReport(
        name=str(file),
        checks=checks,
        problems=tuple(
            replace(problem, sentence=f"{one.name}: {problem.sentence}")
            for one in reports.values()
            for problem in one.problems
        ),
        remarks=(
            *(f"{one.name}: {remark}" for one in reports.values() for remark in one.remarks),
            *folder.remarks,
        ),
        tables=(
            Table(key="callbacks", columns=columns, rows=rows, row_title="slot"),
            *(
                replace(table, key=f"{slot}_{table.key}")
                for slot, one in reports.items()
                for table in one.tables
            ),
        ),
    )


def _slot_of(file: Path, wanted: tuple[str, ...]) -> str:
    """Return the slot of a file by its name; raise ValueError if no slot has the name."""
    if file.suffix != ".py" or file.stem not in SLOTS:
        names = [f"{slot}.py" for slot in SLOTS]
        raise ValueError(
            f"{file} must be named after its slot, {', '.join(names)}{suggestion(file.name, names)}"
        )
    if file.stem not in wanted:
        raise ValueError(f"slots must include {file.stem}, the slot of {file}")
    return file.stem


class _Folder:
    """A folder of callbacks under test."""

    def __init__(self, path: Path, surroundings: Surroundings, *, is_alone: bool) -> None:
        self._path = path
        self._around = surroundings
        self._files = CallbackFolder(path).files
        self._is_alone = is_alone
        self.check = cache(self._check)
        self._load = cache(self._load_first)
        self.remarks: dict[str, None] = {}  # in their order, each once

    def _check(self, slot: str) -> CheckReport | str:
        """Return the report on the file of a slot, or the name of its replacement."""
        report = self._report(slot)
        if isinstance(report, CheckReport):
            telling.get()(f"{report.name}: {_verdict(report)}")
        return report

    def _report(self, slot: str) -> CheckReport | str:
        if slot not in self._around.slots:
            return "not used" if slot in self._files else "default"
        loaded = self._load(slot)
        if isinstance(loaded, Problem):
            problems = self._around.with_allowed([loaded])
            return CheckReport(name=self._around.name_of(slot), problems=problems)
        if isinstance(loaded, bool):
            return "default" if loaded or not SLOTS[slot].is_optional else "off"
        how: dict[str, Any] = {}
        if slot == RobotSlots.measure.name:
            report = self.check(WorldSlots.adjust_background.name)
            is_well = isinstance(report, CheckReport) and report.ok
            background = self._own(WorldSlots.adjust_background.name)
            how = {"background": background() if is_well and background is not None else None}
        elif slot == RobotSlots.control.name:
            how = {f"has_{name}": self._is_on(*fillers) for name, fillers in _FILLERS.items()}
        makers = {name: self._own(name) for name in (slot, *_ALSO.get(slot, ()))}
        report = check_slot(
            slot,
            lambda: {name: maker() for name, maker in makers.items() if maker},
            self._around.setting,
            self._around.dt,
            **how,
        )
        if slot == RobotSlots.control.name and report.ok:
            names = _names_in(fresh_callback(loaded, slot))
            lacks = [
                f"step.{name} is always None: {fillers[0]} is off"
                for name, fillers in _FILLERS.items()
                if name in names and not how[f"has_{name}"]
            ]
            report = replace(report, remarks=(*lacks, *report.remarks))
        return replace(
            report,
            name=self._around.name_of(slot),
            problems=self._around.with_allowed(report.problems),
            remarks=tuple(map(self._around.allowed, report.remarks)),
        )

    def _load_first(self, slot: str) -> CallbackFolder | Problem | bool:
        """Return the loaded file of a slot, its problem, or whether the default is on."""
        if slot not in self._files or slot not in self._around.slots:
            return False
        folder = CallbackFolder(self._path, (slot,), self._around.given)
        with redirect_stdout(StdoutCapture()), warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", UserWarning)
            try:
                callback = load(folder)[slot]
            except (Exception, SystemExit) as error:
                return _load_problem(error)
            finally:
                found = (str(one.message) for one in told if one.category is UserWarning)
                self.remarks |= dict.fromkeys(found)
        return callback if isinstance(callback, bool) else folder

    def _is_on(self, *slots: str) -> bool:
        """Return whether one of the stages is on; always for a file alone."""
        if (on := self._around.on) is not None:
            return not on.isdisjoint(slots)
        return self._is_alone or any(self._load(slot) is not False for slot in slots)

    def _own(self, slot: str) -> Maker | None:
        """Return the maker of the folder's own callback; None = the default."""
        loaded = self._load(slot)
        if not isinstance(loaded, CallbackFolder):
            return None
        return lambda: fresh_callback(loaded, slot)


# The other slots that a check of a slot loads.
_ALSO = {RobotSlots.estimate_parameters.name: (RobotSlots.init_parameter_estimator.name,)}
# The slots that fill a part of a step, the one that a remark names first.
_FILLERS = {
    "estimate": (RobotSlots.estimate_state.name,),
    "parameters": (RobotSlots.estimate_parameters.name, RobotSlots.init_parameter_estimator.name),
}


def check_slot(
    slot: str,
    load: Callable[[], Mapping[str, Any]],
    setting: Setting,
    dt: float | None = None,
    *,
    background: Callable[..., Any] | None = None,
    has_estimate: bool = True,
    has_parameters: bool = True,
) -> CheckReport:
    """Check the callback of a slot; `load` returns it fresh, with others if needed."""

    def make() -> Any:
        return load()[slot]

    match slot:
        case RobotSlots.define_model.name:
            return check_model(make)
        case RobotSlots.init_parameter_estimator.name:
            return check_parameter_estimator(lambda: make()(RobotModel()))
        case RobotSlots.estimate_parameters.name:
            return check_parameter_estimator(lambda: _with_own_estimator(load()))
        case RobotSlots.measure.name:
            return measurement_report(make, setting, background=background)
        case RobotSlots.estimate_state.name:
            return check_estimator(make, dt=dt)
        case RobotSlots.control.name:
            has = {"has_estimate": has_estimate, "has_parameters": has_parameters}
            return controller_report(make, setting, **has)
        case WorldSlots.adjust_background.name:
            return check_background(make)
        case _:
            return check_motion(make)


def _with_own_estimator(callbacks: Mapping[str, Any]) -> Callable[[Step], Any]:
    """Return an estimate_parameters whose steps have the folder's own estimator, if any."""
    callback: Callable[..., Any] = callbacks[RobotSlots.estimate_parameters.name]
    make = callbacks.get(RobotSlots.init_parameter_estimator.name)
    if not callable(make):
        return callback
    estimator = make(RobotModel())

    @wraps(callback)
    def estimate(step: Step) -> Any:
        return callback(_StepWithEstimator(step, estimator))

    return estimate


class _StepWithEstimator:
    """A step with another estimator."""

    def __init__(self, step: Step, estimator: object) -> None:
        self._step = step
        self.estimator = estimator

    def __getattr__(self, name: str) -> Any:
        return getattr(self._step, name)


def _load_problem(error: BaseException) -> Problem:
    line = None if isinstance(error, SubmissionError) else line_of_error(error)
    sentence = str(error)
    if isinstance(error, SyntaxError) and error.filename:
        line = SourceLine(error.filename, error.lineno or 1, "<module>")
        sentence = f"it is not valid Python: {error.msg}"
    elif isinstance(error, TimeoutError):
        sentence = f"loading it takes longer than {TIME_LIMIT:g} s, or never ends"
    elif line is not None:
        sentence = f"it cannot be loaded: {explained(error)[1]}"
    return Problem(kind="not loaded", sentence=sentence, line=line)


def _names_in(callback: Callable[..., Any]) -> set[str]:
    function = unwrap(callback)
    code = getattr(function, "__code__", None) or getattr(type(function).__call__, "__code__", None)
    codes, names = [code], set()
    while codes:
        code = codes.pop()
        if isinstance(code, CodeType):
            names |= {*code.co_names}
            codes += code.co_consts
    return names
