"""The runs behind the cards of the start page, and films of these runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robsim._core import Step
from robsim.base.checks import Floats
from robsim.control import DriveAround, GoToPoint
from robsim.gui._link import jpeg
from robsim.gui.hosted import answers_to
from robsim.gui.panels.view import PanelView
from robsim.lab.cameras.camera import Camera
from robsim.lab.motors import Limits, UdpMotors
from robsim.lab.rehearsal.lab import SimulatedLab
from robsim.simulation import Dropout, Experiment, Scenario, Simulation
from robsim.teach.tasks import ParkTask, Task
from robsim.vision.imaging.images import resized
from robsim.vision.imaging.noise import GaussianNoise

_AREA = (800, 800)  # px: the robot is visible in a small picture
_SEED = 4
_STEPS, _EVERY, _SIDE = 144, 3, 280  # of a film: steps, steps for each picture, px
_DRIVING: Any = {"area": _AREA, "seed": _SEED, "measure": True, "control": DriveAround()}


@dataclass(frozen=True)
class Scene:
    """A run with the initial messages to its panel, its task, and its resources."""

    what: Simulation | Experiment
    told: tuple[tuple[str, dict[str, Any]], ...] = ()
    task: Task | None = None
    held: ExitStack = field(default_factory=ExitStack)

    def begin(self, view: PanelView) -> None:
        """Send the messages to the panel."""
        for kind, fields in self.told:
            answers_to(view, kind, fields)


def _drive() -> Scene:
    angle = np.linspace(0, 4 * np.pi, 96)
    eight = np.column_stack([400 + 250 * np.sin(angle), 400 + 200 * np.sin(2 * angle)])
    sim = Simulation(area=_AREA, seed=_SEED, measure=True)
    return Scene(sim, (("path", {"points": eight.tolist()}),))


def _noise() -> Scene:
    return Scene(Simulation(**_DRIVING, noise=GaussianNoise(40), dropout=Dropout(0.1, 3)))


def _identify() -> Scene:
    sim = Simulation(
        **_DRIVING, headings=None, estimate_parameters=True, identify_from="measurement"
    )
    return Scene(sim)


def _estimate() -> Scene:
    sim = Simulation(**_DRIVING, noise=GaussianNoise(20), dropout=Dropout(0.4, 8))
    return Scene(sim, (("set", {"name": "state", "value": "default"}),))


def _task() -> Scene:
    task = ParkTask()
    sim = task.simulation(seed=_SEED)
    x, y, _ = task.goal
    return Scene(sim, (("go_to", {"x": x, "y": y}),), task)


def _world_of_laboratory() -> Scene:
    return Scene(Simulation(area=_AREA, seed=_SEED, measure=True, control=GoToPoint(620, 250)))


def _laboratory() -> Scene:
    with ExitStack() as held:
        lab = held.enter_context(SimulatedLab(Scenario(area=_AREA, seed=_SEED), fps=20))
        camera = held.enter_context(Camera(lab))
        motors = held.enter_context(UdpMotors(lab.address))
        limits = Limits(voltage=1.5, slew_rate=10)
        experiment = Experiment(camera, send=motors, limits=limits, frame_timeout=2, measure=True)
        held.push(experiment)
        experiment.control = GoToPoint(620, 250)
        kept = held.pop_all()
    return Scene(experiment, held=kept)


_SCENES: Mapping[str, Callable[[], Scene]] = {
    "drive": _drive,
    "noise": _noise,
    "identify": _identify,
    "estimate": _estimate,
    "task": _task,
    "laboratory": _laboratory,
}


def scene_of(card: str) -> Scene:
    return _SCENES[card]()


def film_of(card: str) -> tuple[dict[str, Any], list[bytes]]:
    """Return the message ``film`` of a card, and its pictures."""
    scene = _world_of_laboratory() if card == "laboratory" else scene_of(card)
    view = PanelView(scene.what)
    try:
        scene.begin(view)
        steps: list[Step] = []
        pictures: list[bytes] = []

        def shoot() -> None:
            step = scene.what.step()
            steps.append(step)
            if step.k % _EVERY == 0 and step.frame is not None:
                pictures.append(jpeg(resized(step.frame.image, _SIDE, _SIDE)))

        for _ in range(_STEPS):
            view.driver.ask(shoot)
    finally:
        view.close()
    trace = view.record.trace
    head = {"type": "film", "card": card, "area": scene.what.area, "every": _EVERY}
    trails = {"measured": trace.pose_measured, "estimated": trace.pose_estimated}
    head |= {name: _places(poses) for name, poses in trails.items()}
    errors = np.abs(trace.parameters - np.asarray(trace.info.theta_true)).reshape(len(trace), -1)
    return head | {"errors": _shares(errors)}, pictures


def _places(poses: Any) -> list[list[float] | None]:
    return [None if np.isnan(x) else [round(x), round(y)] for x, y, _ in poses.tolist()]


def _shares(errors: Floats) -> list[float]:
    """Return the mean error of parameters (N, 15) at each step, relative to the largest."""
    largest = np.nanmax(errors, axis=0, initial=0)
    shares = np.nan_to_num(errors[:, largest > 0] / largest[largest > 0], nan=1)
    return [] if not shares.size else [float(share) for share in shares.mean(axis=1).round(3)]
