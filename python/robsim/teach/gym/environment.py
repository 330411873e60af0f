"""`TaskEnv`: a task as an environment of gymnasium."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from robsim._core import Step, wrap_angle
from robsim.base.checks import Floats, as_float_array, check_choice, check_int
from robsim.base.text import quoted
from robsim.control.path_following import nearest_on_segment
from robsim.simulation import Simulation
from robsim.simulation.world.world_of_scenario import frame_size
from robsim.teach.tasks.by_name import TASKS
from robsim.teach.tasks.by_name import task as task_by_name
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.kinds.follow import FollowTask
from robsim.teach.tasks.kinds.park import ParkTask

_LENGTH = 100.0  # px of the work area that count as 1


#: The remaining cost of a run from a pose on, 0 at the goal; its decrease is a step's reward.
Left = Callable[[Floats], float]


def _left_to_park(task: ParkTask, start: Floats) -> Left:
    """Return d + sin(|heading error| / 2) exp(-d), of a pose; d is the distance / 100 px.

    The sine is at most 1, so that d left / d d = 1 - sin(...) exp(-d) >= 0: each way straight to
    the goal is rewarded, with any heading. A factor above 1, as |heading error|, has a dip.
    """
    x, y, heading = task.goal

    def left(pose: Floats) -> float:
        d = math.hypot(pose[0] - x, pose[1] - y) / _LENGTH
        error: float = abs(wrap_angle(pose[2] - heading))
        return d + math.sin(error / 2) * math.exp(-d)

    return left


def _left_to_follow(task: FollowTask, start: Floats) -> Left:
    """Return (way left along the path + distance from it) / 100 px, of a pose."""
    points = np.vstack((start[:2], task.waypoints))
    radius: float = task.values["WAYPOINT_RADIUS"]
    number = 1  # of the next waypoint

    def left(pose: Floats) -> float:
        nonlocal number
        position = pose[:2]
        while number < len(points) - 1 and math.dist(position, points[number]) <= radius:
            number += 1
        nearest = nearest_on_segment(position, points[number - 1], points[number])
        rest = points[number:]
        way = math.dist(nearest, rest[0]) + sum(map(math.dist, rest, rest[1:]))
        return (way + math.dist(position, nearest)) / _LENGTH

    return left


#: By the kind of task: its maker, from the task and the first pose.
REWARDS: Mapping[type[Task], Callable[[Any, Floats], Left]] = {
    ParkTask: _left_to_park,
    FollowTask: _left_to_follow,
}


OBSERVATIONS = ("pose", "frame")
_RENDER_MODE = "rgb_array"


class TaskEnv(gymnasium.Env[NDArray[Any], NDArray[Any]]):
    """A task for a controller as an environment of gymnasium.

    An episode is a run of the task, truncated after its steps. An action is the voltages of both
    motors (V), float32 (2,), up to the largest of the task.

    Parameters
    ----------
    task : str or Task
        The name of a task that a controller solves, ``"park"`` or ``"follow"``, or the task.
    observation : {"pose", "frame"}
        ``"pose"``: float32 (4,): x, y (px of the work area), heading (rad) of the last sighting of
        the robot, and 1 if it is seen now, else 0. ``"frame"``: the image, uint8 (H, W, 3).
    render_mode : {"rgb_array"}, optional
        The result of `render`: the frame.
    **parameters
        The parameters that differ from the defaults, of a task by name.

    Raises
    ------
    TypeError, ValueError
        If an argument is wrong; the message names it.

    Notes
    -----
    The reward of a step is the decrease of the remaining cost, from the true poses: the way in
    100 px, and for parking near the goal the sine of half the heading error. The last step of an
    episode has the scores of the task in its ``info["scores"]``. Each ``info`` has the true pose,
    ``info["pose_true"]``, which the controller must not use.

    Examples
    --------
    >>> import gymnasium, robsim.teach.gym
    >>> env = gymnasium.make("robsim/Park-v0", observation="pose")
    >>> observation, info = env.reset(seed=1)
    >>> observation.shape, sorted(info)
    ((4,), ['pose_true'])
    """

    metadata = {"render_modes": [_RENDER_MODE], "render_fps": 5}  # noqa: RUF012

    def __init__(
        self,
        task: str | Task = "park",
        *,
        observation: str = "pose",
        render_mode: str | None = None,
        **parameters: Any,
    ) -> None:
        self.task = _task(task, parameters)
        check_choice("observation", observation, OBSERVATIONS)
        if render_mode is not None:
            check_choice("render_mode", render_mode, (_RENDER_MODE,))
        self.render_mode = render_mode
        self._shows_pose = observation == "pose"
        self._voltage = self.task.values["MAXIMUM_VOLTAGE"]
        self.action_space = spaces.Box(-self._voltage, self._voltage, (2,), np.float32)
        scenario = self.task.scenario
        width, height = scenario.area
        self._limits = np.array([[0, 0, -np.pi, 0], [width, height, np.pi, 1]], np.float32)
        columns, rows = frame_size(scenario)
        self.observation_space = (
            spaces.Box(*self._limits, dtype=np.float32)
            if self._shows_pose
            else spaces.Box(0, 255, (rows, columns, 3), np.uint8)
        )
        self._input = (0.0, 0.0)
        self._simulation: Simulation | None = None
        self._pose = np.zeros(4)
        self._left_of: Left
        self._left = 0.0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begin a run; the same seed gives the same run. `options` must be empty."""
        if seed is not None:
            check_int("seed", seed, minimum=0, maximum=2**63 - 1)
        if options is not None and (not isinstance(options, dict) or options):
            raise TypeError(f"options must be None or empty, got {quoted(options)}")
        super().reset(seed=seed, options=options)
        run = int(self.np_random.integers(2**63))
        if self._simulation is None:
            self._simulation = self.task.simulation(seed=run, control=self._control)
        else:
            self._simulation.reset(seed=run)
        area = self.task.scenario.area
        self._pose = np.array([area[0] / 2, area[1] / 2, 0, 0])
        step = self._next_step()
        pose = self._simulation._world.pose
        self._left_of = REWARDS[type(self.task)](self.task, pose)
        self._left = self._left_of(pose)
        return self._observed(step), {"pose_true": pose}

    def step(self, action: NDArray[Any]) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Drive a step with these voltages (V)."""
        voltages = as_float_array("action", action)
        if voltages.shape != (2,) or not np.isfinite(voltages).all():
            raise ValueError(f"action must be two finite voltages (V), got {quoted(action)}")
        left, right = np.clip(voltages, -self._voltage, self._voltage).tolist()
        self._input = (left, right)
        simulation = self._running()
        simulation.step_stage()  # the controller
        is_over = simulation.n_steps >= self.task.steps
        step = self._next_step()
        pose = simulation._world.pose
        info: dict[str, Any] = {"pose_true": pose}
        if is_over:
            info["scores"] = self.task.score(simulation.trace)
        before, self._left = self._left, self._left_of(pose)
        # reward = left(k) - left(k + 1): the sum over a run is its progress
        return self._observed(step), before - self._left, False, is_over, info

    def render(self) -> NDArray[Any] | None:
        """Return the frame, uint8 (H, W, 3), if `render_mode` is set."""
        if self.render_mode is None:
            return None
        return self._image()

    def _image(self) -> NDArray[Any]:
        frame = self._running().frame
        assert frame is not None
        return np.array(frame.image)

    def _control(self, step: Step) -> tuple[float, float]:
        return self._input

    def _next_step(self) -> Step:
        simulation = self._running()
        simulation.step_stage()
        while simulation.stage != "control":
            simulation.step_stage()
        return simulation.last_step

    def _observed(self, step: Step) -> NDArray[Any]:
        if not self._shows_pose:
            return self._image()
        self._pose[3] = step.measurement is not None
        if step.measurement is not None:
            self._pose[:3] = step.measurement.pose
        return np.clip(self._pose, *self._limits).astype(np.float32)

    def _running(self) -> Simulation:
        if self._simulation is None:
            raise gymnasium.error.ResetNeeded("no run yet: call reset() first")
        return self._simulation


def _task(task: str | Task, parameters: dict[str, Any]) -> Task:
    if isinstance(task, str):
        task = task_by_name(task, **parameters)
    elif not isinstance(task, Task):
        raise TypeError(f"task must be a name or a Task, got {quoted(task)}")
    elif parameters:
        raise TypeError(f"a Task already has its parameters: leave out {', '.join(parameters)}")
    if type(task) not in REWARDS:
        known = ", ".join(name for name, kind in TASKS.items() if kind in REWARDS)
        raise ValueError(f"task must be a controller's task, {known}, got {quoted(task.name)}")
    return task
