"""What an attack is, and the file that it becomes."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

#: What an attack may come to. NOTHING: no points, or an error that is the submission's.
#: ITS_OWN: the points of its honest answers, as the harm is beside them.
NOTHING, ITS_OWN = "nothing", "its own"

#: Limits that only what hangs comes to, on a busy machine, too; and those of what hangs.
PATIENT = {"call": 300.0, "first_call": 300.0, "run": 600.0, "cpu": 300.0}
SHORT = {"call": 0.4, "first_call": 5.0, "run": 8.0, "cpu": 8.0}

#: Where it is held: by the process alone, by the layers that shut it in, by nothing here.
PROCESS, LAYERS = "process", "layers"


@dataclass(frozen=True)
class Attack:
    """A submission that tries something: its module, or what the module does in `cheat(step)`."""

    name: str
    about: str  # what it tries, in a line
    code: str  # ``cheat(step)`` returns a pose that it says, or None; or the slot itself
    comes_to: str = NOTHING
    why: str = ""  # the process alone does not hold it
    runs_bare: bool = True  # it is tried with the process alone; not what could stop others
    says: str = ""  # a pattern that its error, if any, must match
    limits: dict[str, Any] = field(default_factory=dict)  # other than those of all

    @property
    def held_by(self) -> str:
        """LAYERS: it gets nowhere only where the layers of Linux hold."""
        return LAYERS if self.why else PROCESS


def kind(module: Callable[[str], str]) -> Callable[..., Callable[[str], Attack]]:
    """Return a kind of attack, ``kind(name, about, comes_to, ...)(lines)``, by its module."""

    def begun(name: str, about: str, comes_to: str = NOTHING, **options: Any) -> Any:
        """Return what makes the attack of its lines; who has points answers as well."""

        def of(lines: str) -> Attack:
            code = module(textwrap.dedent(lines).strip("\n"))
            if module is in_step_2 and comes_to == ITS_OWN:
                code += "\n    return honest(step)"
            return Attack(name, about, f"\n{code}\n", comes_to, **options)

        return of

    return begun


def in_step_2(lines: str) -> str:
    return f"def cheat(step):\n    if once(step):\n{textwrap.indent(lines, ' ' * 8)}"


attack = kind(str)
at_once = kind(in_step_2)


# A submission says "REACHED" when it got what it wanted; what it wanted is the rest of the line.
# An honest answer: predicted by the model, corrected by what was measured.
_BEGINNING = '''
import ctypes, gc, os, socket, struct, sys, threading, time
import numpy as np
import robsim

libc = ctypes.CDLL(None, use_errno=True)

def reached(what):
    print("REACHED", what, flush=True)

def tries(what, act):
    try:
        result = act()
    except BaseException as error:
        print("refused", what, type(error).__name__, getattr(error, "errno", ""), flush=True)
        return None
    reached(what)
    return result

def called(result):
    if result < 0:
        raise OSError(ctypes.get_errno(), "refused")
    return result

def once(step):
    return step.k == 2

poses = []

def honest(step):
    model, u = robsim.RobotModel(), step.last_u
    if not poses:
        if step.measurement is None:
            return np.array([600.0, 600.0, 0.0])
        poses.extend([np.asarray(step.measurement.pose, float)] * 2)
    now = np.asarray(model.predict(poses[-1], poses[-2], u), float)
    if step.measurement is not None:
        off = np.asarray(step.measurement.pose, float) - now
        off[2] = (off[2] + np.pi) % (2 * np.pi) - np.pi
        now = now + 0.6 * off
    poses.append(now)
    return now

def wire():
    from robsim.teach.grading._wire import Channel
    return next(x for x in gc.get_objects() if type(x) is Channel)._socket

def ring():
    """The descriptor of the frames: one that can be mapped."""
    import mmap
    for number in range(3, 65536):
        try:
            mmap.mmap(number, 4096, mmap.MAP_SHARED, mmap.PROT_READ)
        except (OSError, ValueError):
            continue
        return number
    raise OSError("no ring")

'''

_END = """

if "estimate_state" not in globals():
    def estimate_state(step):
        pose = cheat(step)
        return robsim.Estimate((0.0, 0.0, 0.0) if pose is None else pose, np.eye(3))
"""


def file_of(attack: Attack, places: dict[str, str], end: str = _END) -> str:
    """Return the submission of an attack; `places`: paths for the names in braces of its code."""
    code = textwrap.dedent(attack.code)
    for name, path in places.items():
        code = code.replace("{" + name + "}", path)
    return _BEGINNING + code + end


HONEST = Attack(
    "honest",
    "answers as well as it can, also where the machine is slow",
    "cheat = honest",
    ITS_OWN,
)
