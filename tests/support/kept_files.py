"""One file of each kind that robsim writes, and what is read from it.

``PYTHONPATH=tests/support python -m kept_files FOLDER`` writes the files of this version, and with
them ``expected.json``: names and digests of all numbers that are read from each.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import shutil
import sys
import tempfile
import tomllib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import robsim
from robsim.campaigns import campaign
from robsim.teach import EstimateTask, Key, SubmissionResult, grade_submission, load_assignment
from robsim.trace import Session
from robsim.trace.sessions._file import session_file
from robsim.vision import (
    Calibration,
    Intrinsics,
    PlaneMap,
    load_calibration,
    save_calibration,
    save_colors,
    save_robot,
)

EXPECTED = "expected.json"

SCENARIO = robsim.Scenario(
    area=(300, 300),
    seed=5,
    boundary="bounce",
    noise=robsim.GaussianNoise(8),
    dropout=robsim.Dropout(0.1, 3),
    headings=360,
    process_noise=robsim.simulation.WheelNoise(0.05),
    control=robsim.DriveAround(),
    motor_delay=1.5,
    estimate_parameters=True,
    measure=True,
)

LIMITS = {
    "position": {"full": 2.0, "zero": 20.0},
    "heading": {"full": 2.0, "zero": 20.0},
    "consistency": {"full": 3.0, "zero": 100.0, "low": 0.3, "low_zero": 0.01},
}
ASSIGNMENT = """\
name = "hw3"
title = "Through dropouts"

[[tests]]
name = "shown"
task = "estimate"
points = 2
public = true
parameters = { runs = 2, steps = 20 }
"""


def digest(value: Any) -> Any:
    """Return numbers and texts as they are, arrays by shape, type and checksum of their bytes."""
    if isinstance(value, np.ndarray):
        little = np.ascontiguousarray(value).astype(value.dtype.newbyteorder("<"))
        return [*value.shape, str(value.dtype), hashlib.sha256(little.tobytes()).hexdigest()]
    if isinstance(value, (float, np.floating)):
        return float(value).hex()
    if isinstance(value, Mapping):
        return {str(key): digest(one) for key, one in value.items()}
    if isinstance(value, (tuple, list)):
        return [digest(one) for one in value]
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, np.generic):
        return digest(value.item())
    return repr(value)


def _trace(folder: Path) -> Any:
    path = folder / "trace.npz"
    if not path.exists():
        robsim.Simulation(SCENARIO).run(30).save(path)
    trace = robsim.Trace.load(path)
    columns = {name: np.asarray(getattr(trace, name)) for name in _columns(trace)}
    return {"steps": len(trace), "scenario": tomllib.loads(str(trace.info.scenario)), **columns}


def _columns(trace: robsim.Trace) -> list[str]:
    names = [name for name in dir(trace) if not name.startswith("_")]
    return [name for name in names if isinstance(getattr(trace, name, None), np.ndarray)]


def _scenario(folder: Path) -> Any:
    path = folder / "scenario.toml"
    if not path.exists():
        SCENARIO.save(path)
    return tomllib.loads(robsim.Scenario.load(path).to_toml())


def _robot(folder: Path) -> Any:
    path = folder / "robot"
    lab = robsim.load_robot("lab")
    if not path.exists():
        save_robot(path, lab)
    robot = robsim.load_robot(path)
    return {
        "image": np.asarray(robot.image),
        "outline": np.asarray(robot.outline),
        "alignment": robot.alignment,
        "centre": np.asarray(robot.centre),
        "markers": {role: np.asarray(one.polygon) for role, one in robot.markers.items()},
    }


def _colors(folder: Path) -> Any:
    path = folder / "colors.toml"
    if not path.exists():
        save_colors(path, robsim.load_colors())
    return {one.name: [one.y, one.u, one.v] for one in robsim.load_colors(path)}


def _calibration(folder: Path) -> Any:
    path = folder / "calibration.toml"
    if not path.exists():
        lens = Intrinsics(
            [[500.0, 0.0, 320.5], [0.0, 505.0, 239.0], [0.0, 0.0, 1.0]],
            (-0.21, 0.07, 0.001, -0.002, 0.0),
        )
        floor = PlaneMap([[1.9, 0.04, -3.0], [0.02, 2.1, 5.0], [1e-5, 2e-5, 1.0]])
        made = Calibration(
            size=(640, 480), intrinsics=lens, floor=floor, area=(1200, 1000), mm_per_px=2.0
        )
        save_calibration(path, made)
    found = load_calibration(path)
    return {
        "size": found.size,
        "area": found.area,
        "mm_per_px": found.mm_per_px,
        "floor": np.asarray(found.floor.matrix),
        "lens": [np.asarray(found.intrinsics.matrix), np.asarray(found.intrinsics.distortion)],
    }


def _session(folder: Path, name: str = "session") -> Any:  # a folder in version 0.1.0
    path = folder / name
    if not path.exists() and not session_file(path).exists():
        robot = robsim.Simulation(seed=4, area=(300, 300), control=robsim.DriveAround())
        frames = [robsim.Frame(robot.step().frame.image.copy(), t=k / 5) for k in range(6)]
        robsim.Experiment(
            frames, area=(300, 300), control=robsim.Spin(), record=path, lossless=True
        ).run()
    session = Session(path)
    trace = session.trace
    return {
        "steps": len(trace),
        "pose_measured": trace.pose_measured,
        "u": trace.u,
        "frames": [np.asarray(one.frame.image) for one in session],
    }


def last_pose(trace):  # its text is noted in the store of each version: it must stay as it is
    x, y, heading = trace.pose_true[-1].tolist()
    seen = int((trace.pose_measured[:, 0] > 0).sum())
    return {"x": x, "y": y, "heading": heading, "seen": seen}


def _campaign(folder: Path) -> Any:
    result = campaign(
        SCENARIO,
        vary={"motor_delay": [0, 1.5]},
        metrics=last_pose,
        runs=2,
        steps=6,
        seed=3,
        store=folder / "campaign.sqlite",
        progress=False,
    )
    # with the seconds that each run took: those of runs that are read, not done again
    return {name: np.asarray(result[name]).tolist() for name in sorted(result.columns)}


def _assignment(folder: Path) -> Any:
    path = folder / "assignment"
    if not path.exists():
        path.mkdir()
        (path / "assignment.toml").write_text(ASSIGNMENT)
        limits = json.dumps({"format": 1, "tests": {"shown": {"limits": LIMITS}}}, indent=1)
        (path / "limits.json").write_text(limits)
    found = load_assignment(path)
    (test,) = found.tests
    return {
        "name": found.name,
        "points": test.points,
        "task": [test.task.name, dict(test.task.parameters)],
        "limits": {name: dataclasses.astuple(limit) for name, limit in test.limits.items()},
    }


def _graded(assignment: Path) -> str:
    """Return the result of the reference solution, without times and names of this machine."""
    reference = EstimateTask().solutions[0]
    with tempfile.TemporaryDirectory() as name:
        submission, own = Path(name, "ada"), Path(name, "hw3")
        shutil.copytree(assignment, own)
        Key.new().save(own / "key")
        submission.mkdir()
        for module, source in reference.files.items():
            (submission / f"{module}.py").write_bytes(source)
        return grade_submission(load_assignment(own), submission).to_json()


def _result(folder: Path) -> Any:
    path = folder / "result.json"
    if not path.exists():
        path.write_text(_graded(folder / "assignment"))
    found = SubmissionResult.from_json(path.read_text())
    return {
        "points": [found.points, found.most],
        "tests": {
            test.name: {score.name: [score.statistic, score.fraction] for score in test.scores}
            for test in found.tests
        },
        "again": _is_in(json.loads(path.read_text()), json.loads(found.to_json())),
    }


def _is_in(earlier: Any, later: Any) -> bool:
    """Whether all of an earlier file is in a later one, which may have more keys."""
    if isinstance(earlier, dict):
        return all(key in later and _is_in(one, later[key]) for key, one in earlier.items())
    if isinstance(earlier, list):
        return len(earlier) == len(later) and all(map(_is_in, earlier, later))
    return bool(earlier == later)


#: By its name: what writes it if it is not there, and reads it.
KINDS: dict[str, Callable[[Path], Any]] = {
    "trace": _trace,
    "scenario": _scenario,
    "robot": _robot,
    "colors": _colors,
    "calibration": _calibration,
    "session": _session,
    "session_file": partial(_session, name="session.mcap"),
    "campaign": _campaign,
    "assignment": _assignment,
    "result": _result,
}


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    found = {name: digest(read(folder)) for name, read in KINDS.items()}
    (folder / EXPECTED).write_text(json.dumps(found, indent=1, sort_keys=True) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
