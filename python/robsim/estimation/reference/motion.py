"""The robot model in state-space form, which the filters predict with."""

from __future__ import annotations

import numpy as np

from robsim._core import RobotModel
from robsim.base.checks import Floats, as_float_array
from robsim.base.text import quoted


class RobotMotion:
    """The state transition of the robot model, for the state (pose, velocity).

    The model needs the last two poses. The state has the last one and the velocity
    v(k) = (pose(k) - pose(k-1)) / T, so pose(k-2) = pose(k-1) - T v(k-1). Headings are not
    wrapped, so that they do not jump.

    Parameters
    ----------
    model : RobotModel, optional
        The model. Default: that of the default robot.

    Raises
    ------
    TypeError
        If `model` is not a RobotModel.
    """

    def __init__(self, model: RobotModel | None = None) -> None:
        if model is not None and not isinstance(model, RobotModel):
            raise TypeError(f"model must be a RobotModel, got {quoted(model)}")
        self.model = RobotModel() if model is None else model
        self.T = self.model.dt

    def _poses(self, name: str, states: Floats) -> tuple[Floats, Floats]:
        """Return the last pose of each state and the one before; the errors name the argument."""
        states = as_float_array(name, states)
        if states.shape[-1:] != (6,):
            raise ValueError(f"{name} must be of shape (..., 6), got {states.shape}")
        pose_1, velocity = states[..., :3], states[..., 3:]
        # pose(k-2) = pose(k-1) - T v(k-1)
        return pose_1, pose_1 - self.T * velocity

    def move(self, states: Floats, u: Floats) -> Floats:
        """Return the states of the next step.

        Parameters
        ----------
        states : array (6,) or (N, 6)
            States of step k-1.
        u : array (2,)
            Input of step k-1 (V).
        """
        pose_1, pose_2 = self._poses("states", states)
        pose = self.model.predict(pose_1, pose_2, u, unwrapped=True)
        # v(k) = (pose(k) - pose(k-1)) / T
        return np.concatenate((pose, (pose - pose_1) / self.T), axis=-1)

    def jacobian(self, state: Floats, u: Floats) -> Floats:
        """Return F, (6, 6): the derivative of the next state by a state, (6,)."""
        J = self.model.jacobian(*self._poses("state", state), u)
        # d pose(k) = (J_1 + J_2) d pose(k-1) - T J_2 d v(k-1)
        by_pose, by_velocity = J[:, :3] + J[:, 3:], -self.T * J[:, 3:]
        # d v(k) = (d pose(k) - d pose(k-1)) / T
        return np.block(
            [[by_pose, by_velocity], [(by_pose - np.eye(3)) / self.T, by_velocity / self.T]]
        )

    @property
    def G(self) -> Floats:
        """The gain of the process noise, (6, 3): noise w of the pose also changes the velocity."""
        # pose(k) = ... + w,  v(k) = ... + w / T
        return np.vstack((np.eye(3), np.eye(3) / self.T))

    def steps_in(self, dt: float) -> int:
        """Return the number of model steps in a time (s): several if frames were lost."""
        return self.model.steps_in(dt)
