"""The robot model in state-space form, which the filters predict with."""

from __future__ import annotations

import numpy as np

from robsim._base.checks import Floats
from robsim._core import RobotModel


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
            raise TypeError(f"model must be a RobotModel, got {model!r}")
        model = RobotModel() if model is None else model
        self.T = model.dt
        self.a1, self.a2, *self._b1_b2_d1 = model.theta.T

    def drive(self, u: Floats) -> Floats:
        """Return the driving term of each axis along the heading, (3,), for an input u (V)."""
        b1, b2, d1 = self._b1_b2_d1
        # drive = b1 u1 + b2 u2 + d1
        return np.asarray(b1 * u[0] + b2 * u[1] + d1)

    def move(self, states: Floats, u: Floats) -> Floats:
        """Return the states of the next step.

        Parameters
        ----------
        states : array (6,) or (N, 6)
            States of step k-1.
        u : array (2,)
            Input of step k-1 (V).
        """
        pose_1, velocity = states[..., :3], states[..., 3:]
        heading = pose_1[..., 2]
        direction = np.stack((np.cos(heading), np.sin(heading), np.ones_like(heading)), axis=-1)
        # pose(k-2) = pose(k-1) - T v(k-1)
        pose_2 = pose_1 - self.T * velocity
        # pose(k) = a1 pose(k-1) + a2 pose(k-2) + drive (cos heading(k-1), sin heading(k-1), 1)
        pose = self.a1 * pose_1 + self.a2 * pose_2 + self.drive(u) * direction
        # v(k) = (pose(k) - pose(k-1)) / T
        return np.concatenate((pose, (pose - pose_1) / self.T), axis=-1)

    def jacobian(self, state: Floats, u: Floats) -> Floats:
        """Return F, (6, 6): the derivative of the next state by a state, (6,)."""
        heading, drive = state[2], self.drive(u)
        # d pose(k) / d pose(k-1) = a1 + a2, and by the heading
        #   d x(k) = -drive sin heading,  d y(k) = drive cos heading
        by_pose = np.diag(self.a1 + self.a2)
        by_pose[0, 2] = -drive[0] * np.sin(heading)
        by_pose[1, 2] = drive[1] * np.cos(heading)
        # d pose(k) / d v(k-1) = -T a2
        by_velocity = np.diag(-self.T * self.a2)
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
        n_steps = round(dt / self.T)
        if n_steps < 1 or abs(dt - n_steps * self.T) > self.T / 4:
            raise ValueError(
                f"step.dt must be a multiple of the model's dt, {self.T:g} s, got {dt:g}: give the "
                "filter the model of the run, sim.model"
            )
        return n_steps
