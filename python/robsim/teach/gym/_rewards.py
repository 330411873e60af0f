"""What a controller is rewarded for: coming closer to the goal of its task."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from robsim._core import wrap_angle
from robsim.base.checks import Floats
from robsim.control.path_following import nearest_on_segment
from robsim.teach.tasks.definition import Task
from robsim.teach.tasks.kinds.follow import Follow
from robsim.teach.tasks.kinds.park import Park

_LENGTH = 100.0  # px of the work area that count as 1


class Reward(ABC):
    """What is left to do in a run; its decrease is the reward of a step."""

    def __init__(self, pose: Floats) -> None:
        self._left = self.left(pose)

    @abstractmethod
    def left(self, pose: Floats) -> float:
        """Return what is left to do from a pose on, 0 at the goal."""

    def step(self, pose: Floats) -> float:
        """Return the reward of a step that ends at a pose."""
        before, self._left = self._left, self.left(pose)
        # reward = left(k) - left(k + 1): the sum over a run is what was done of it
        return before - self._left


class ParkReward(Reward):
    """The distance from the goal, and near it the heading error."""

    def __init__(self, task: Park, pose: Floats) -> None:
        self._goal = task.goal
        super().__init__(pose)

    def left(self, pose: Floats) -> float:
        """Return distance / 100 px + |heading error| exp(-distance / 100 px)."""
        x, y, heading = self._goal
        distance = math.hypot(pose[0] - x, pose[1] - y) / _LENGTH
        error: float = abs(wrap_angle(pose[2] - heading))
        return distance + error * math.exp(-distance)


class FollowReward(Reward):
    """The way that is left along the path, and the distance from it."""

    def __init__(self, task: Follow, pose: Floats) -> None:
        self._points = np.vstack((pose[:2], task.waypoints))
        self._radius: float = task.values["WAYPOINT_RADIUS"]
        self._next = 1  # the number of the waypoint that is driven to
        super().__init__(pose)

    def left(self, pose: Floats) -> float:
        """Return (way left along the path + distance from it) / 100 px."""
        points, position = self._points, pose[:2]
        while self._next < len(points) - 1 and self._is_at(position):
            self._next += 1
        start, end = points[self._next - 1 : self._next + 1]
        nearest = nearest_on_segment(position, start, end)
        rest = points[self._next :]
        way = math.dist(nearest, end) + sum(map(math.dist, rest, rest[1:]))
        return (way + math.dist(position, nearest)) / _LENGTH

    def _is_at(self, position: Floats) -> bool:
        return math.dist(position, self._points[self._next]) <= self._radius


#: By the kind of task: what makes the reward of a run from the task and the first pose.
REWARDS: Mapping[type[Task], Callable[[Any, Floats], Reward]] = {
    Park: ParkReward,
    Follow: FollowReward,
}
