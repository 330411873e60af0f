"""`FolderReport`: the checks of all callbacks of a folder on one page."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from functools import wraps
from inspect import unwrap
from os import PathLike
from pathlib import Path
from types import CodeType
from typing import Any

from robsim._core import RobotModel, Step
from robsim.base.check_report import CheckReport, Problem
from robsim.base.files import as_path
from robsim.base.report import Column, Row, Table
from robsim.base.source_line import SourceLine, line_of_error
from robsim.base.spelling import suggestion
from robsim.simulation.callback_folder import CallbackFolder
from robsim.simulation.slots import SLOTS, RobotSlots, WorldSlots, checked_slots
from robsim.teach.doctor._errors import explained
from robsim.teach.doctor._run_checks import fresh_callback, load
from robsim.teach.doctor._trial import TIME_LIMIT, StdoutCapture
from robsim.teach.doctor.callbacks.backgrounds import check_background
from robsim.teach.doctor.callbacks.controllers import controller_report
from robsim.teach.doctor.callbacks.measurements import measurement_report
from robsim.teach.doctor.callbacks.models import check_model, check_motion
from robsim.teach.doctor.callbacks.scenes import Setting
from robsim.teach.doctor.parameter_estimators import check_parameter_estimator
from robsim.teach.doctor.state_estimators import check_estimator

Maker = Callable[[], Callable[..., Any]]


@dataclass(frozen=True, kw_only=True)
class FolderReport(CheckReport):
    """The result of a check of callback files. ``bool(report)`` is `ok`.

    Attributes
    ----------
    name : str
        The file or the folder.
    checks : dict of str to CheckReport or str
        By slot: the report on its file, or ``"default"`` or ``"off"`` where nothing of yours runs,
        or ``"not used"`` where the task does not ask for it.
    problems : tuple of Problem
        Those of all files.
    remarks : tuple of str
        Those of all files, and of the folder.
    """

    checks: Mapping[str, CheckReport | str] = field(default_factory=dict)

    @property
    def heading(self) -> str:
        """The verdict in one line."""
        checked = [check for check in self.checks.values() if isinstance(check, CheckReport)]
        ill = sum(not check.ok for check in checked)
        if not checked:
            return f"{self.name}: no callback is switched on"
        if len(checked) == 1:
            return f"{self.name}: the callback {'is ill' if ill else 'passed all checks'}"
        if not ill:
            return f"{self.name}: all {len(checked)} callbacks passed all checks"
        return f"{self.name}: {ill} of {len(checked)} callbacks {'is' if ill == 1 else 'are'} ill"

    @property
    def verdicts(self) -> dict[str, str]:
        """By slot: ``"well"``, ``"ill"``, ``"remark"``, or what stands in `checks`."""
        return {slot: _verdict(check) for slot, check in self.checks.items()}


def _verdict(check: CheckReport | str) -> str:
    if isinstance(check, str):
        return check
    return "ill" if not check.ok else "remark" if check.remarks else "well"


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """What callbacks of a folder are checked in.

    Attributes
    ----------
    setting : Setting or None
        The robot, the area and the camera; None = the usual ones.
    slots : tuple of str
        What the folder may fill.
    on : frozenset of str or None
        The slots that are filled; None = as the folder has it.
    given : mapping of str to bytes
        Modules that they can import, by name, before those of the folder.
    dt : float or None
        The time between two steps (s); None = any.
    """

    setting: Setting | None = None
    slots: tuple[str, ...] = tuple(SLOTS)
    on: frozenset[str] | None = None
    given: Mapping[str, bytes] = field(default_factory=dict)
    dt: float | None = None


def report_of(
    path: str | PathLike[str],
    slots: str | Iterable[str] | None,
    surroundings: Surroundings | None = None,
) -> FolderReport:
    """Return the report on a folder or a file; other arguments are those of `check_folder`."""
    around = surroundings or Surroundings()
    file = as_path(path)
    is_file = file.is_file()
    wanted = tuple(SLOTS) if slots is None else checked_slots(slots, tuple(SLOTS))
    if is_file:
        wanted = (_slot_of(file, wanted),)
    elif not file.exists() and file.suffix == ".py":
        raise FileNotFoundError(f"no file {file}")
    folder = _Folder(file.parent if is_file else file, around, is_alone=is_file)
    checks = {slot: folder.check(slot) for slot in SLOTS if slot in wanted}
    reports = {slot: one for slot, one in checks.items() if isinstance(one, CheckReport)}
    report = FolderReport(
        name=str(file),
        checks=checks,
        problems=tuple(
            replace(problem, sentence=f"{slot}.py: {problem.sentence}")
            for slot, one in reports.items()
            for problem in one.problems
        ),
        remarks=(
            *(f"{slot}.py: {remark}" for slot, one in reports.items() for remark in one.remarks),
            *folder.remarks,
        ),
    )
    rows = [Row(slot, (_verdict(check), _shown(slot, check))) for slot, check in checks.items()]
    columns = (Column("verdict", "verdict", ""), Column("file", "file", ""))
    table = Table(key="callbacks", columns=columns, rows=rows, row_title="slot")
    return replace(report, tables=(table, *_named_tables(reports)))


def _shown(slot: str, check: CheckReport | str) -> str:
    return "" if isinstance(check, str) else f"{slot}.py"


def _named_tables(reports: Mapping[str, CheckReport]) -> list[Table]:
    return [
        replace(table, key=f"{slot}_{table.key}")
        for slot, one in reports.items()
        for table in one.tables
    ]


def _slot_of(file: Path, wanted: tuple[str, ...]) -> str:
    """Return the slot that a file is named after; raises ValueError."""
    if file.suffix != ".py" or file.stem not in SLOTS:
        names = [f"{slot}.py" for slot in SLOTS]
        raise ValueError(
            f"{file} must be named after its slot, {', '.join(names)}{suggestion(file.name, names)}"
        )
    if file.stem not in wanted:
        raise ValueError(f"slots must include {file.stem}, which {file} is for")
    return file.stem


class _Folder:
    """A folder of callbacks under test: a method of the name of each slot checks its file."""

    def __init__(self, path: Path, surroundings: Surroundings, *, is_alone: bool) -> None:
        self._path = path
        self._around = surroundings
        self._setting = surroundings.setting or Setting.usual()
        self._files = CallbackFolder(path).files
        self._is_alone = is_alone
        self._checked: dict[str, CheckReport | str] = {}
        self._loaded: dict[str, CallbackFolder | Problem | bool] = {}
        self.remarks: dict[str, None] = {}  # in their order, each once

    def check(self, slot: str) -> CheckReport | str:
        """Return the report on the file of a slot, or what runs in its place."""
        if slot not in self._checked:
            self._checked[slot] = self._check(slot)
        return self._checked[slot]

    def _check(self, slot: str) -> CheckReport | str:
        if slot not in self._around.slots:
            return "not used" if slot in self._files else "default"
        loaded = self._load(slot)
        if isinstance(loaded, Problem):
            return CheckReport(name=f"{slot}.py", problems=(loaded,))
        if isinstance(loaded, bool):
            return "default" if loaded or not SLOTS[slot].is_optional else "off"
        report: CheckReport = getattr(self, slot)(self._maker(slot))
        return replace(report, name=f"{slot}.py")

    def _load(self, slot: str) -> CallbackFolder | Problem | bool:
        """Return the loaded file of a slot, why it fails, or whether the default is on."""
        if slot not in self._files or slot not in self._around.slots:
            return False
        if slot not in self._loaded:
            self._loaded[slot] = self._load_first(slot)
        return self._loaded[slot]

    def _load_first(self, slot: str) -> CallbackFolder | Problem | bool:
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

    def _maker(self, slot: str) -> Maker:
        loaded = self._load(slot)
        assert isinstance(loaded, CallbackFolder)
        return lambda: fresh_callback(loaded, slot)

    def _is_on(self, slot: str) -> bool:
        """Return whether a stage is on; a file alone is not judged by what it lacks."""
        if self._around.on is not None:
            return slot in self._around.on
        return self._is_alone or self._load(slot) is not False

    def _own(self, slot: str) -> Maker | None:
        """Return what makes the folder's own callback; None = the default."""
        return self._maker(slot) if isinstance(self._load(slot), CallbackFolder) else None

    def define_model(self, make: Maker) -> CheckReport:
        return check_model(make)

    def init_parameter_estimator(self, make: Maker) -> CheckReport:
        return check_parameter_estimator(lambda: make()(RobotModel()))

    def estimate_parameters(self, make: Maker) -> CheckReport:
        make_estimator = self._own(RobotSlots.init_parameter_estimator.name)
        if make_estimator is None:
            return check_parameter_estimator(make)
        return check_parameter_estimator(lambda: with_estimator(make(), make_estimator))

    def measure(self, make: Maker) -> CheckReport:
        background = WorldSlots.adjust_background.name
        report = self.check(background)
        is_well = isinstance(report, CheckReport) and report.ok
        own = self._maker(background)() if is_well else None
        return measurement_report(make, self._setting, background=own)

    def estimate_state(self, make: Maker) -> CheckReport:
        return check_estimator(make, dt=self._around.dt)

    def control(self, make: Maker) -> CheckReport:
        estimator, update = (
            RobotSlots.estimate_state.name,
            RobotSlots.estimate_parameters.name,
        )
        is_updated = self._is_on(update) or self._is_on(RobotSlots.init_parameter_estimator.name)
        gets = {"estimate": (estimator, self._is_on(estimator)), "parameters": (update, is_updated)}
        report = controller_report(
            make,
            self._setting,
            has_estimate=gets["estimate"][1],
            has_parameters=gets["parameters"][1],
        )
        if not report.ok:
            return report
        lacks = [
            f"step.{name} is always None: {slot} is off"
            for name, (slot, is_there) in gets.items()
            if not is_there and name in _names_in(make())
        ]
        return replace(report, remarks=(*lacks, *report.remarks))

    def adjust_background(self, make: Maker) -> CheckReport:
        return check_background(make)

    def evaluate_model(self, make: Maker) -> CheckReport:
        return check_motion(make)


def with_estimator(callback: Callable[..., Any], make: Maker) -> Callable[[Step], Any]:
    """Return an estimate_parameters whose steps have the folder's own estimator."""
    estimator = make()(RobotModel())

    @wraps(callback)
    def estimate(step: Step) -> Any:
        return callback(_StepWithEstimator(step, estimator))

    return estimate


class _StepWithEstimator:
    """A step whose estimator is another one."""

    def __init__(self, step: Step, estimator: object) -> None:
        self._step = step
        self.estimator = estimator

    def __getattr__(self, name: str) -> Any:
        return getattr(self._step, name)


def _load_problem(error: BaseException) -> Problem:
    """Return why a file cannot be loaded."""
    line = line_of_error(error)
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
    """Return the names of attributes and globals that the code of a callback uses."""
    function = unwrap(callback)
    code = getattr(function, "__code__", None) or getattr(type(function).__call__, "__code__", None)
    codes, names = [code], set()
    while codes:
        code = codes.pop()
        if isinstance(code, CodeType):
            names |= {*code.co_names}
            codes += code.co_consts
    return names
