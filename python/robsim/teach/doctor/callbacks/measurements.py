"""`check_measurement`: the checks of a measurement in frames of a simulated camera."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from os import PathLike
from typing import Any

import numpy as np

from robsim._core import Measurement, PlaneMap, Step, locate
from robsim.base.check_report import CheckReport, Problem
from robsim.base.checks import Floats
from robsim.base.report import Column, Row, Table
from robsim.base.text import quoted
from robsim.simulation import Simulation
from robsim.simulation.slots import RobotSlots
from robsim.simulation.world.scene import leave_floor
from robsim.teach.doctor._errors import problem_of
from robsim.teach.doctor._run_checks import Done, replay_problem, run_checks, together_problem
from robsim.teach.doctor._situations import DT, Situation
from robsim.teach.doctor._trial import EstimatorUnderTest, Trial, finite_numbers
from robsim.teach.doctor.callbacks.own_covariance import covariance_findings
from robsim.teach.doctor.callbacks.pose_mistakes import are_right, errors, mistakes
from robsim.teach.doctor.callbacks.scenes import Scene, Setting, simulate
from robsim.teach.doctor.callbacks.single_calls import under_test
from robsim.trace.trace import Bools
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot

_SLOT = RobotSlots.measure.name
_PLACES = {  # px
    "robot turns in the middle": (600.0, 600.0),
    "robot turns at the top left": (90.0, 90.0),
    "robot turns at the top right": (1110.0, 95.0),
    "robot turns at the bottom left": (95.0, 1105.0),
    "robot turns at the bottom right": (1105.0, 1110.0),
}
_TURN = np.radians(np.arange(-180, 180, 15))  # both +-pi and the axes, and all between
_HIDDEN = (20, 21, 22, 23, 24, 40, 41)
_SMALL_CAMERA = 2 / 3  # of the pixels of each side

# Shares of the frames.
_FALSE = 0.03
_FALSE_IN_NOISE = 0.2
_SEEN = 0.5
_MOSTLY_SEEN = 0.95

_IMPRECISE = (3.0, 1.0)  # times the error of robsim's own, px: worth a remark

Background = Callable[[Pixels], Pixels]
OwnPoses = dict[Situation, list[Floats]]  # by scene: (3,), NaN = robsim does not see the robot


def check_measurement(
    make: Callable[[], Any] | str | PathLike[str],
    *,
    robot: str | PathLike[str] | RobotDefinition | None = None,
    background: Callable[[Pixels], Pixels] | None = None,
    budget: float = DT,
) -> CheckReport:
    """Check a measurement of the pose in frames of a simulated camera, and report its problems.

    The robot turns in the middle and in the corners, drives through the area, is hidden, and is
    absent. Some frames have camera noise, a red square on the floor, or fewer pixels than the work
    area. The report has a table of the errors next to robsim's own measurement in the same frames.
    If the measurements have covariances, a second table has the mean NEES with camera noise
    (expected: 3), and the verdict ``"optimistic"``, ``"consistent"`` or ``"conservative"``.

    Parameters
    ----------
    make : callable or path
        ``make() -> measure``: returns a new measurement, ``measure(step) -> Measurement or None``;
        for a plain function, ``lambda: measure``. The path of a file ``measure.py``, or of its
        callback folder, is also accepted.
    robot : str, path or RobotDefinition, optional
        The robot. Default: the robot chosen with ``robsim robots use``.
    background : callable, optional
        ``adjust_background`` of the world. Default: a plain floor, and a floor with a red square.
    budget : float
        Maximum of the median time per call (s). Default: the time between two steps.

    Returns
    -------
    CheckReport
        True if all checks pass; `tables` contains the errors. In a test, call the report's
        ``raise_for_problems()``, which lists every problem.

    Raises
    ------
    TypeError, ValueError
        If `make` is not callable, or another argument is wrong.

    Examples
    --------
    >>> report = robsim.teach.check_measurement(lambda: lambda step: None)
    >>> bool(report), len(report.problems)
    (False, 1)
    """
    if background is not None and not callable(background):
        raise TypeError(f"background must be a function of the image, got {quoted(background)}")
    usual = Setting.usual() if robot is None else Setting(robot=as_robot(robot))
    return measurement_report(make, usual, background=background, budget=budget)


def measurement_report(
    make: Callable[[], Any] | str | PathLike[str],
    setting: Setting,
    *,
    background: Background | None,
    budget: float = DT,
) -> CheckReport:
    """Check a measurement in a setting; `check_measurement` documents the other arguments."""
    own: OwnPoses = {}
    slot = under_test(
        RobotSlots.measure, "measurement", read_pose, partial(_simulate_beside, own=own)
    )
    checks = partial(_checks, setting=setting, background=background, own=own)
    return run_checks(make, slot, budget, checks)


def _simulate_beside(scene: Any, callback: Callable[[Step], Any], own: OwnPoses) -> Simulation:
    """Return a simulation in which robsim's own measurement sees the same frames once."""
    if scene in own:
        return simulate(scene, callback, _SLOT)
    poses = own[scene] = []

    def measure(step: Step) -> Any:
        found = locate(step.blobs, step.markers, image=step.frame)
        poses.append(np.full(3, np.nan) if found is None else found.pose)
        return callback(step)

    return simulate(scene, measure, _SLOT)


def read_pose(result: Any, before: Floats | None) -> Floats:
    """Return the pose of a measurement's result; NaN = None."""
    if result is None:
        return np.full(3, np.nan)
    if isinstance(result, Measurement):
        return np.array(result.pose)
    expected = (
        "a pose: end with return robsim.Measurement((x, y, heading)), or None where the robot is "
        "not seen"
    )
    hint = "return None where the robot is not seen"
    return np.array(Measurement(finite_numbers(result, (3,), expected, hint)).pose)


def _checks(
    measurement: EstimatorUnderTest,
    setting: Setting,
    background: Background | None,
    own: OwnPoses,
) -> Iterator[Problem | str | Table | Done]:
    floor: dict[str, Any] = {"background": background or leave_floor}
    tour = []
    for name, place in _PLACES.items():
        tour.append(measurement.try_in(setting.turned(name, place, _TURN, **floor)))
        if tour[-1].error is not None:
            yield problem_of(tour[-1])
            return
        yield Done(name)
    drive = setting.scripted("robot drives through the area", _through(setting), **floor)
    alone = measurement.try_in(drive)
    if alone.error is None:
        if (cause := replay_problem(alone)) is not None:
            yield cause
            return
        yield from filter(None, (together_problem(alone, tour[0].situation),))
    yield Done("the same frames again, two at the same time")
    wrong = list(_pose_problems([*tour, alone], setting))
    yield from wrong
    yield from _hidden_problems(measurement, drive, is_square=background is None)
    yield Done("robot hidden, or not there")
    before_noise = _part(drive, "robot drives before a noisy camera", noise=setting.noise)
    noisy = measurement.try_in(before_noise)
    trials = {"turned": tour, "driven": [alone], "noise": [noisy]}
    if background is None:
        red = _part(drive, "robot drives on a floor with a red square", background=None)
        trials["red square"] = [measurement.try_in(red)]
        if not wrong:
            yield from _unless_failed(_square_problems, trials["red square"][0])
            yield Done("red square")
    width, height = (round(_SMALL_CAMERA * side) for side in setting.resolution)
    small = _part(tour[0].situation, "camera has fewer pixels", resolution=(width, height))
    if not wrong:
        yield from _unless_failed(_noise_problems, noisy, setting.noise)
        yield from _unless_failed(_camera_problems, measurement.try_in(small), small)
        yield from _precision(tour, own)
        if noisy.error is None:
            yield from covariance_findings(noisy)
        yield Done("noise and covariance, fewer pixels")
    yield _table(trials, own)


def _unless_failed(
    look: Callable[..., Iterator[Problem | str]], trial: Trial, *given: Any
) -> Iterator[Problem | str]:
    return iter([problem_of(trial)]) if trial.error is not None else look(trial, *given)


def _through(setting: Setting) -> Floats:
    """Return a drive from the bottom left to the top right, in a gentle curve."""
    t = np.linspace(0.0, 1.0, 60)
    path = np.column_stack((150 + 900 * t, 1000 - 850 * t + 80 * np.sin(2 * np.pi * t)))
    x, y = setting.places(path).T
    return np.column_stack((x, y, np.arctan2(np.gradient(y), np.gradient(x))))


def _part(scene: Any, name: str, **changes: Any) -> Scene:
    return replace(scene.first(30), name=name, **changes)  # type: ignore[no-any-return]


def _poses(trials: list[Trial]) -> tuple[Floats, Floats]:
    """Return the measured poses of trials, NaN = not seen, and the true ones."""
    measured = np.concatenate([trial.outputs.reshape(-1, 3) for trial in trials])
    true = np.concatenate([trial.situation.poses[: len(trial.outputs)] for trial in trials])
    return measured, true


def _pose_problems(trials: list[Trial], setting: Setting) -> Iterator[Problem | str]:
    if trials[-1].error is not None:
        yield problem_of(trials[-1])
    measured, true = _poses(trials)
    is_seen = np.isfinite(measured[:, 0])
    if is_seen.mean() < _MOSTLY_SEEN:
        yield _not_seen(trials, float(is_seen.mean()))
    is_false = is_seen & ~are_right(measured, true)
    if is_false.sum() <= _FALSE * is_seen.sum():
        return
    markers = setting.robot.marker_layout()
    found = list(mistakes(measured[is_seen], true[is_seen], markers, setting.area))
    worst = max(trials, key=lambda trial: _are_false(trial).sum())
    for kind, sentence in found or [("false poses", _how_wrong(measured, true))]:
        yield worst.problem(kind, sentence, int(_are_false(worst).argmax()))


def _not_seen(trials: list[Trial], share: float) -> Problem | str:
    missed = [int(np.isnan(trial.outputs[:, 0]).sum()) for trial in trials]
    most = trials[int(np.argmax(missed))]
    sentence = (
        f"it returns None in {1 - share:.0%} of the clean frames that show the robot: "
        f"in {max(missed)} of {len(most.outputs)} where the {most.situation.name}"
    )
    if share >= _SEEN:
        return sentence
    return most.problem("not seen", sentence, int(np.isnan(most.outputs[:, 0]).argmax()))


def _are_false(trial: Trial) -> Bools:
    measured, true = _poses([trial])
    return np.isfinite(measured[:, 0]) & ~are_right(measured, true)


def _how_wrong(measured: Floats, true: Floats) -> str:
    measured, true = measured[np.isfinite(measured[:, 0])], true[np.isfinite(measured[:, 0])]
    distance, angle = errors(measured, true)
    count = int((~are_right(measured, true)).sum())
    return (
        f"{count} of {len(measured)} poses are false, up to {distance.max():.0f} px and "
        f"{np.degrees(angle.max()):.0f} degrees off"
    )


def _hidden_problems(
    measurement: EstimatorUnderTest, drive: Scene, *, is_square: bool
) -> Iterator[Problem]:
    scenes: list[Any] = [
        drive.unseen("robot drives and is hidden now and then", _HIDDEN),
        drive.first(6).unseen("robot is not there", range(6)),
    ]
    if is_square:
        empty = replace(scenes[-1], name="only a red square is there", background=None)
        scenes.append(empty)
    found = (_hidden_problem(measurement.try_in(scene), scene) for scene in scenes)
    yield from islice(filter(None, found), 1)


def _hidden_problem(trial: Trial, scene: Any) -> Problem | None:
    if trial.error is not None:
        problem = problem_of(trial)
        if not scene.is_hidden[trial.failed_at]:
            return problem
        # The message for controllers is wrong here: a measurement returned this.
        sentence = problem.sentence.partition(": then ")[2] or problem.sentence
        return replace(
            problem,
            kind="fails unseen",
            sentence=f"where the robot is not in the frame {sentence}; return None there",
        )
    is_invented = np.isfinite(trial.outputs[:, 0]) & np.array(scene.is_hidden)
    if not is_invented.any():
        return None
    k = int(is_invented.argmax())
    pose = trial.outputs[k]
    is_last = k > 0 and bool((pose == trial.outputs[k - 1]).all())
    sentence = f"it returns ({pose[0]:.0f}, {pose[1]:.0f}) where the robot is not in the frame"
    if is_last:
        sentence = "it returns the last pose again where the robot is not in the frame"
    return trial.problem(
        kind="last pose" if is_last else "false detection",
        sentence=f"{sentence}: return None there; the state estimator bridges the gap",
        k=k,
    )


def _seen_in(trial: Trial, where: str) -> Iterator[str]:
    seen = int(np.isfinite(trial.outputs[:, 0]).sum())
    if seen < _SEEN * len(trial.outputs):
        yield f"{where} it sees the robot in {seen} of {len(trial.outputs)} frames"


def _noise_problems(trial: Trial, noise: GaussianNoise) -> Iterator[Problem | str]:
    camera = f"with a camera noise of {noise.percent:g} %"
    yield from _seen_in(trial, camera)
    seen, false = np.isfinite(trial.outputs[:, 0]).sum(), _are_false(trial).sum()
    if false > _FALSE_IN_NOISE * seen:
        yield f"{camera} {false} of its {seen} poses are false"


def _square_problems(trial: Trial) -> Iterator[Problem | str]:
    yield from _seen_in(trial, "on the default floor, with a red square,")
    if (is_false := _are_false(trial)).sum() > _FALSE * len(trial.outputs):
        yield trial.problem(
            "red square",
            "it takes the red square on the default floor for the red marker: of all pairs of "
            "blobs, take the pair at the distance step.markers.distance",
            int(is_false.argmax()),
        )


def _camera_problems(trial: Trial, scene: Scene) -> Iterator[Problem | str]:
    width, height = scene.resolution
    measured, true = _poses([trial])
    is_seen = np.isfinite(measured[:, 0])
    if is_seen.mean() < _SEEN:
        hint = (
            "its sizes and distances may be in pixels of the frame; robsim.locate without "
            "image=step.frame needs plane_map=step.frame.plane_map"
        )
        for seldom in _seen_in(trial, f"before a camera of {width} x {height} px"):
            yield f"{seldom}: {hint}"
        return
    pixels = PlaneMap.scaled(scene.resolution, scene.area).to_pixel(true[:, :2])
    distance = np.linalg.norm(measured[:, :2] - pixels, axis=1)[is_seen]
    if np.median(distance) < 25 and np.median(errors(measured, true)[0][is_seen]) > 50:
        yield trial.problem(
            "pixels of the frame",
            f"before a camera of {width} x {height} px it returns pixels of the frame, not px of "
            "the work area: convert them, step.frame.plane_map.to_world((u, v))",
            int(is_seen.argmax()),
        )


def _table(trials: dict[str, list[Trial]], own: OwnPoses) -> Table:
    columns = (
        Column("frames", "frames", ""),
        Column("seen", "seen", ""),
        Column("distance", "rms", "px", ".2f"),
        Column("angle", "rms", "rad", ".2f"),
        Column("own_distance", "robsim", "px", ".2f"),
        Column("own_angle", "robsim", "rad", ".2f"),
    )
    rows = []
    for title, group in trials.items():
        counts = [len(trial.outputs) for trial in group]
        if all(counts):
            rows.append(Row(title, (sum(counts), *_row(group), *_row(_own(group, own))[1:])))
    return Table(key="errors", columns=columns, rows=rows, row_title="robot")


def _row(trials: list[Trial]) -> tuple[int, float, float]:
    measured, true = _poses(trials)
    is_seen = np.isfinite(measured[:, 0])
    if not is_seen.any():
        return 0, np.nan, np.nan
    distance, angle = errors(measured[is_seen], true[is_seen])
    rms = (float(np.sqrt(np.mean(values**2))) for values in (distance, angle))
    return (int(is_seen.sum()), *rms)  # type: ignore[return-value]


def _own(trials: list[Trial], own: OwnPoses) -> list[Trial]:
    return [
        replace(one, outputs=np.array(own[one.situation][: len(one.outputs)])) for one in trials
    ]


def _precision(tour: list[Trial], own_poses: OwnPoses) -> Iterator[str]:
    _, distance, _ = _row(tour)
    _, own, _ = _row(_own(tour, own_poses))
    factor, least = _IMPRECISE
    if np.isfinite(distance) and least + factor * own < distance:
        yield (
            f"its position has an error of {distance:.1f} px, root mean square, in clean frames; "
            f"robsim's own measurement has {own:.2f} px"
        )
