"""Ghosts: other runs, shown in the picture and in the charts of this run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim.base.checks import Floats
from robsim.control import FollowPath, GoToPoint
from robsim.estimation.evaluation.errors import wrapped_error
from robsim.gui._link import Link, Refused
from robsim.gui.panels.part import Handlers, Part
from robsim.gui.panels.settings.estimator import default_estimator, why_no_default
from robsim.gui.tools.uploads import Uploads
from robsim.simulation import Scenario, Simulation
from robsim.trace import Trace

if TYPE_CHECKING:
    from robsim.gui.panels.view import PanelView
_MOST = 3
_MOST_STEPS = 20_000  # of each
_REFERENCE_STEPS = (300, 3000)  # fewest, most: a step takes about 2 ms


@dataclass(frozen=True, eq=False)
class Ghost:
    """Another run, shown in this one: its poses and the error of its estimate or measurement."""

    name: str
    rows: Floats  # (N, 6): px, px, rad, twice
    world: tuple[tuple[int, int], float]  # area (px), sample time (s)

    @staticmethod
    def of(name: str, trace: Trace) -> Ghost:
        """Return a trace as a ghost; ValueError if it does not begin with step 0."""
        if not len(trace):
            raise ValueError("nothing has run yet")
        if first := int(trace.k[0]):
            raise ValueError(f"it begins with step {first}, not 0")
        part = trace.in_unit("px")[:_MOST_STEPS]
        true, measured, estimated = part.pose_true, part.pose_measured, part.pose_estimated
        found = estimated if np.isfinite(estimated).any() else measured
        poses = np.where(np.isfinite(true), true, found)
        return Ghost(name, np.hstack([poses, wrapped_error(found, true)]), _world_of(trace))


class Ghosts(Part):
    """Keeps up to three other runs, and sends their poses and errors to the browsers."""

    def __init__(self, panel: PanelView) -> None:
        super().__init__(panel)
        self._ghosts: list[Ghost] = []
        self._kept = 0  # runs kept so far, for their names
        self._reference = panel.beside("robsim reference")
        self._uploads = Uploads(panel.beside("robsim upload"), self._read)

    def handlers(self) -> Handlers:
        return {
            "keep": self._keep,
            "reference": self._drive,
            "drop_ghost": self._drop,
            "upload": self._uploads.take,
            "give_up": self._uploads.give_up,
        }

    def greet(self, link: Link) -> None:
        if self._ghosts:
            head, *buffers = self._told()
            link.send(head, buffers)

    def changed(self) -> None:
        record = self.panel.record
        kept = [ghost for ghost in self._ghosts if ghost.world == _world_of(record.trace)]
        if len(kept) < len(self._ghosts):
            self._ghosts = kept
            self.panel.send(*self._told())

    def look(self, now: float) -> float:
        self._uploads.drop(lambda one: one.link not in self.panel.links)
        return self._uploads.look(now)

    def _keep(self, link: Link, message: dict[str, Any]) -> None:
        self._check_room()
        try:
            ghost = Ghost.of(f"run {self._kept + 1}", self.panel.record.trace)
        except ValueError as error:
            raise Refused(f"there is no run to keep: {error}") from None
        self._kept += 1
        self._add(ghost)

    def _drop(self, link: Link, message: dict[str, Any]) -> None:
        self._ghosts = [ghost for ghost in self._ghosts if ghost.name != message["name"]]
        self.panel.send(*self._told())

    def _drive(self, link: Link, message: dict[str, Any]) -> None:
        """Run the reference in the same world with the same seed, with robsim's stages only."""
        runner = self.panel.runner
        if not isinstance(runner, Simulation):
            raise Refused("the reference requires a simulated world")
        if self._reference.is_busy:
            raise Refused("the reference is already running")
        self._check_room()
        scenario = runner.scenario.to_toml()
        code = self.panel.record.trace.info.callbacks  # slots that the scenario lacks
        steps = int(np.clip(self.panel.record.n_steps, *_REFERENCE_STEPS))

        def drive() -> Ghost:
            reference = Simulation(Scenario.from_toml(scenario))
            if "control" in code and self.panel.goals is not None:
                reference.control = controller_to(self.panel.goals)
            if "measure" in code:
                reference.measure = True
            if "estimate_state" in code and why_no_default() is None:
                reference.estimate_state = default_estimator(reference)
            return Ghost.of("reference", reference.run(steps))

        self._reference.begin(drive, self._add)
        self.panel.note("The reference is running and will appear shortly", "info")

    def _read(self, content: bytes, name: str) -> Callable[[], object]:
        ghost = Ghost.of(Path(name).stem, Trace._unpacked(content, name))

        def take() -> None:
            self._check_room()
            if ghost.world != (own := _world_of(self.panel.record.trace)):
                (area, dt), (own_area, own_dt) = ghost.world, own
                raise Refused(
                    f"{name} has the area {area} px and dt = {dt:g} s; "
                    f"this run has {own_area} px and {own_dt:g} s"
                )
            self._add(ghost)

        return take

    def _check_room(self) -> None:
        if len(self._ghosts) >= _MOST:
            raise Refused(f"at most {_MOST} runs are kept; remove one first")

    def _add(self, ghost: Ghost | None) -> None:
        """Add a ghost; replace one with the same name, and remove the oldest of too many."""
        if ghost is None or ghost.world != _world_of(self.panel.record.trace):
            return
        others = [other for other in self._ghosts if other.name != ghost.name]
        self._ghosts = [*others, ghost][-_MOST:]
        self.panel.send(*self._told())

    def _told(self) -> tuple[dict[str, Any], *tuple[bytes, ...]]:
        message = {"type": "ghosts", "names": [ghost.name for ghost in self._ghosts]}
        return message, *(ghost.rows.astype("<f4").tobytes() for ghost in self._ghosts)


def _world_of(trace: Trace) -> tuple[tuple[int, int], float]:
    return trace.info.area, trace.info.dt


def controller_to(goals: Floats) -> GoToPoint | FollowPath:
    """Return robsim's own controller to a point, to a pose or along waypoints."""
    return GoToPoint(*goals[:2]) if goals.ndim == 1 else FollowPath(goals)
