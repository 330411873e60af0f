"""The robot model in state space."""

from __future__ import annotations

import numpy as np

from robsim._base.checks import Floats
from robsim._core import RobotModel


class RobotMotion:
    """How the state (pose, velocity) moves on by one step of the robot model.

    The model wants the last two poses. The state has the last one and the velocity
    v(k) = (pose(k) - pose(k-1)) / T, so pose(k-2) = pose(k-1) - T v(k-1). Headings are not
    wrapped: no regressor sees a jump.

    Parameters
    ----------
    model : RobotModel, optional
        Default: that of the default robot.
    """

    def __init__(self, model: RobotModel | None = None) -> None:
        if model is not None and not isinstance(model, RobotModel):
            raise TypeError(f"model must be a RobotModel, got {model!r}")
        model = RobotModel() if model is None else model
        self.T = model.dt
        self.a1, self.a2, *self._b1_b2_d1 = model.theta.T

    def drive(self, u: Floats) -> Floats:
        """Return what the input adds to each axis ahead of the robot, (3,)."""
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
        last, velocity = states[..., :3], states[..., 3:]
        heading = last[..., 2]
        ahead = np.stack((np.cos(heading), np.sin(heading), np.ones_like(heading)), axis=-1)
        # pose(k-2) = pose(k-1) - T v(k-1)
        before = last - self.T * velocity
        # pose(k) = a1 pose(k-1) + a2 pose(k-2) + drive (cos heading(k-1), sin heading(k-1), 1)
        pose = self.a1 * last + self.a2 * before + self.drive(u) * ahead
        # v(k) = (pose(k) - pose(k-1)) / T
        return np.concatenate((pose, (pose - last) / self.T), axis=-1)

    def jacobian(self, state: Floats, u: Floats) -> Floats:
        """Return F, (6, 6): how the next state depends on a state, (6,)."""
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
        """How noise of the pose gets into the state, (6, 3): into pose and velocity."""
        # pose(k) = ... + w,  v(k) = ... + w / T
        return np.vstack((np.eye(3), np.eye(3) / self.T))

    def steps_in(self, dt: float) -> int:
        """Return the number of steps of the model in a time (s): several if frames were lost."""
        count = round(dt / self.T)
        if count < 1 or abs(dt - count * self.T) > self.T / 4:
            raise ValueError(
                f"step.dt must be the model's dt, {self.T:g} s, or some times that, got {dt:g}: "
                "give the filter the model of the run, sim.model"
            )
        return count
