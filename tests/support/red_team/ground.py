"""The task that attackers are given, and what may not be left of them."""

from __future__ import annotations

import dataclasses
import os
import re
import socket
import textwrap
import threading
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import robsim
from graded import assert_same_trace, zygotes
from red_team.attack import HONEST, ITS_OWN, PATIENT, PROCESS, SHORT, Attack, file_of
from red_team.calls import CALLS, HONEST_FIT
from robsim.teach import Key, Submission, SubmissionError, WorkerLimits
from robsim.trace import Trace
from waiting import wait_for

STEPS = 30
STEPS_AFTER = 8  # of the honest run that comes after an attack
LIMIT = 4.0  # px, rms: an honest answer has 2.2, dead reckoning 8.2
KEY = Key(bytes(range(32)))
SCENARIO = robsim.Scenario(
    resolution=(240, 240),
    measure=True,
    noise=robsim.GaussianNoise(8),
    dropout=robsim.Dropout(0.2, 3),
    start="random",
    process_noise=robsim.WheelNoise((0.3, 0.3)),
    mismatch=robsim.ParameterMismatch(0.2),
    control=robsim.DriveAround(),
)
#: What any error may be where the machine is busy.
_SLOW = "took longer than|closed its connection"


def points(trace: Trace) -> float:
    """Return 1 if the estimate follows the truth, else 0; what is not estimated is wrong."""
    off = np.hypot(*(trace.pose_estimated - trace.pose_true)[:, :2].T)
    return float(len(off) == STEPS and np.isfinite(off).all() and np.sqrt(np.mean(off**2)) < LIMIT)


@dataclass(frozen=True)
class Outcome:
    """What came of a submission: points of 1, and what the grader says if the run had no end."""

    points: float
    error: str
    output: str  # what it printed
    trace: Trace | None = None

    @property
    def reached(self) -> list[str]:
        """What it says that it got."""
        lines = self.output.splitlines()
        return [line.partition("REACHED ")[2] for line in lines if "REACHED " in line]


@dataclass
class Ground:
    """A folder with submissions and a file of the teacher's, and a server on loopback."""

    folder: Path
    port: int
    token: str = field(default_factory=lambda: f"red-team-{os.getpid()}")

    def __post_init__(self) -> None:
        self.secret = self.folder / "key"
        places = {"folder": self.folder, "secret": self.secret, "token": self.token}
        places |= {"grader": os.getpid(), "port": self.port}
        self.places = {name: str(value) for name, value in places.items()}  # what attacks know

    def submission(self, attack: Attack, **options: Any) -> Submission:
        """Return an attack as somebody hands it in."""
        file = self.folder / "submission.py"
        if attack in CALLS:
            begun = dataclasses.replace(attack, code=HONEST_FIT + textwrap.dedent(attack.code))
            file.write_text(file_of(begun, self.places, end=""))
            options = {"slots": (), "functions": "fit"} | options
        else:
            file.write_text(file_of(attack, self.places))
        limits = SHORT if "took longer" in attack.says else PATIENT
        settings = {
            "slots": "estimate_state",
            "masked": ["robsim.estimation.reference"],
            "frames": True,
            "limits": WorkerLimits(output=1 << 14, **limits | attack.limits),
            "key": KEY,
            "student": "one of a class",
        }
        return Submission(file, **settings | options)

    def outcome(self, attack: Attack, scenario: robsim.Scenario = SCENARIO, **run: Any) -> Outcome:
        """Run an attack; `run`: a seed, a number of steps, or options of the submission."""
        given = {"steps": STEPS} | {
            name: run.pop(name) for name in ("seed", "steps") if name in run
        }
        submission = self.submission(attack, **run)
        if attack in CALLS:
            return _called(submission)
        try:
            trace = submission.run(scenario, test="x", **given)
        except SubmissionError as error:
            return Outcome(0.0, str(error), submission.output)
        return Outcome(points(trace), "", submission.output, trace)

    def left(self) -> dict[str, Any]:
        """Return what there is of processes, files, threads and descriptors of the grader's."""
        return {
            "files": [str(path) for path in self._marked()],
            "secret": self.secret.read_text(),
            "processes": len(descendants()),
            "scratch": [n for zygote in _zygotes() for n in os.listdir(zygote.base)],
            "threads": threading.active_count(),
            "descriptors": len(os.listdir("/proc/self/fd")),
            "of zygotes": [len(os.listdir(f"/proc/{z.process}/fd")) for z in _zygotes()],
        }

    def clear(self) -> None:
        """Remove the files that an attack could leave, as nothing held it."""
        for path in self._marked():
            path.unlink()

    def _marked(self) -> list[Path]:
        folders = ["/tmp", "/var/tmp", "/dev/shm", "/dev/mqueue", "/root", str(self.folder)]
        folders += [zygote.base for zygote in _zygotes()]
        found = []
        for folder in folders:
            with suppress(OSError):
                found += [Path(folder, n) for n in os.listdir(folder) if self.token in n]
        return found


def _called(submission: Submission) -> Outcome:
    """Call a function some times; a point for numbers that are right each time."""
    rng = np.random.default_rng(5)
    calls = [(rng.normal(size=(9, 3)), rng.normal(size=9)) for _ in range(8)]
    right = [np.linalg.lstsq(phi, y, rcond=None)[0] for phi, y in calls]
    try:
        results = submission.calls("fit", calls, shape=(3,))
    except SubmissionError as error:
        return Outcome(0.0, str(error), submission.output)
    return Outcome(float(np.allclose(results, right)), "", submission.output)


def _zygotes() -> list[Any]:
    return [zygote for zygote in zygotes._zygotes.values() if zygote.alive]


def descendants(*, with_zombies: bool = True) -> set[int]:
    """The processes that this one has started, and those that they have or adopt."""
    parents = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        with suppress(OSError):
            fields = Path(f"/proc/{name}/stat").read_text().rpartition(")")[2].split()
            if with_zombies or fields[0] != "Z":
                parents[int(name)] = int(fields[1])
    found = {os.getpid()}
    while more := {process for process, parent in parents.items() if parent in found} - found:
        found |= more
    return found - {os.getpid()}


@contextmanager
def ground(folder: Path) -> Any:
    """Give a ground in an empty folder that others may write to, too."""
    folder.chmod(0o777)
    with socket.create_server(("127.0.0.1", 0)) as server:
        place = Ground(folder, server.getsockname()[1])
        place.secret.write_text("the key")
        place.secret.chmod(0o666)
        yield place


def check_after(place: Ground, before: dict[str, Any], first: Trace, **options: Any) -> None:
    """Check that nothing is left, and that the next honest submission gets what it would have."""
    trace = place.outcome(HONEST, steps=STEPS_AFTER, **options).trace
    assert trace is not None
    assert_same_trace(trace, first)
    # A zygote closes what it had of the last worker.
    wait_for(lambda: more_left(before, place.left()) == {})


def more_left(before: dict[str, Any], after: dict[str, Any]) -> dict[str, Any]:
    """Return what there is more, or is changed; processes of others may have ended meanwhile."""
    of_zygotes = "of zygotes"
    before, after = ({**left, of_zygotes: sum(left[of_zygotes])} for left in (before, after))
    counted = {"processes", "threads", "descriptors", of_zygotes}
    return {
        name: (before[name], value)
        for name, value in after.items()
        if (value > before[name] if name in counted else value != before[name])
    }


def check_outcome(attack: Attack, outcome: Outcome, *, shut_in: bool) -> None:
    """Check that an attack came to no more than it may."""
    assert outcome.points == 0 or attack.comes_to == ITS_OWN, "it has points"
    if shut_in or attack.held_by == PROCESS:
        assert outcome.reached == [], f"it has reached {outcome.reached}"
    if outcome.error:
        assert re.search(f"{attack.says}|{_SLOW}", outcome.error), outcome.error
        assert outcome.error.replace("\n", "").replace("\t", "").isprintable()
        assert len(outcome.error) < 4200
    assert outcome.output.replace("\n", "").replace("\t", "").isprintable()
