"""Simulated drives, with inputs and measurements, that the doctor tries estimators in."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from robsim._core import (
    Frame,
    Measurement,
    RobotModel,
    RobotParameters,
    Sample,
    Step,
    regression,
    wrap_angle,
)
from robsim.base.checks import Floats
from robsim.base.values import frozen

DT = 0.2
START = (300.0, 700.0)  # px; x and y differ by far, so that swapping them shows
MEASUREMENT_SIGMA = (0.5, 0.5, 0.01)  # px, px, rad
PROCESS_SIGMA = (0.1, 0.1, 0.005)  # px, px, rad
UNSEEN = range(80, 100)  # steps
STANDS = range(400, 1400)  # steps

_NOISE_AT_REST = 0.1
_STEPS = 140
_SPEED = 3.0  # px per step
WAY = 10 * _SPEED  # px
_SEED = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class Situation:
    """A drive of the robot: its true poses, inputs and measurements."""

    name: str  # the robot's drive, for reports
    dt: float  # s
    poses: Floats  # (N, 3), true: px, px, rad. The estimators do not get them
    u: Floats  # (N, 2), V
    measurements: tuple[Measurement | None, ...] = ()  # N; None = not seen, () = not tracked

    @cached_property
    def steps(self) -> tuple[Step, ...]:
        """The steps that an estimator gets: with measurements, or with samples of the poses."""
        last_u = np.vstack((np.zeros(2), self.u[:-1]))
        given: list[dict[str, Any]]
        if self.measurements:
            given = [{"measurement": one} for one in self.measurements]
        else:
            phi, y = (frozen(part) for part in regression(self.poses, self.u))
            samples = (Sample(*one, k) for k, one in enumerate(zip(phi, y, strict=True), 2))
            given = [{"sample": one} for one in (None, None, *samples)]
        frame = Frame(np.zeros((1, 1, 3), np.uint8))
        return tuple(
            Step(k=k, dt=self.dt, last_u=last_u[k], frame=frame, **one)
            for k, one in enumerate(given)
        )

    def first(self, steps: int) -> Situation:
        seen = self.measurements[:steps]
        part = replace(self, poses=self.poses[:steps], u=self.u[:steps], measurements=seen)
        if "steps" in self.__dict__:
            part.__dict__["steps"] = self.steps[:steps]
        return part

    def unseen(self, name: str, steps: Collection[int]) -> Situation:
        seen = (None if k in steps else m for k, m in enumerate(self.measurements))
        return replace(self, name=name, measurements=tuple(seen))

    def displaced(self, offset: Floats, start: int) -> Situation:
        """Return the situation with an offset of the measurements (px, px, rad) from a step on."""
        shifted = (
            Measurement(m.pose + offset, covariance=m.covariance) if m and k >= start else m
            for k, m in enumerate(self.measurements)
        )
        return replace(self, measurements=tuple(shifted))

    def pushed(self, steps: range, volts: float) -> Situation:
        """Return the same drive with additional voltage on the left motor in some steps."""
        u = self.u.copy()
        u[steps, 0] += volts
        model = RobotModel(RobotParameters(dt=self.dt))
        poses = _driven(model, u, self.poses[:2, 2], np.zeros((len(u), 3)))
        return replace(self, u=u, poses=poses)

    def with_noise(self, factor: float) -> Situation:
        def scaled(m: Measurement, pose: Floats) -> Measurement:
            P = None if m.covariance is None else factor**2 * m.covariance
            return Measurement(pose + factor * pose_difference(m.pose, pose), covariance=P)

        pairs = zip(self.measurements, self.poses, strict=True)
        return replace(self, measurements=tuple(m and scaled(m, pose) for m, pose in pairs))


def pose_difference(poses: Floats, others: Floats) -> Floats:
    """Return poses minus others, (3,) or (N, 3), with wrapped headings."""
    difference = np.array(poses - others)
    difference[..., 2] = wrap_angle(difference[..., 2])
    return difference


@cache
def weaving(dt: float) -> Situation:
    """Return a drive in gentle curves, in which the heading stays far from +-pi."""
    heading: Floats = np.sin(2 * np.pi * (np.arange(_STEPS) + 20) / 60)
    return _measured("robot weaves", heading, dt)


def blinking(dt: float) -> Situation:
    """Return the drive in gentle curves, out of sight for three of every 20 steps."""
    hidden = [k for k in range(10, _STEPS) if k % 20 in (10, 11, 12)]
    return weaving(dt).unseen("robot weaves and is hidden now and then", hidden).first(120)


@cache
def turning(dt: float) -> Situation:
    """Return a drive in circles, out of sight after the first step beyond each turn of +-pi."""
    situation = _measured("robot turns round and round", np.linspace(0.0, 10.9, 100), dt)
    headings = [m.pose[2] for m in situation.measurements if m is not None]
    crossings = np.flatnonzero(np.diff(headings) < -np.pi) + 1
    return situation.unseen(situation.name, {int(k) + i for k in crossings for i in (1, 2, 3)})


def _measured(name: str, heading: Floats, dt: float) -> Situation:
    model = RobotModel(RobotParameters(dt=dt))
    a1, a2, b1, b2, d1 = model.theta[2]
    # heading(k) = a1 heading(k-1) + a2 heading(k-2) + b1 u1(k-1) + b2 u2(k-1) + d1, solved for
    # u = (forward + turn, forward - turn)
    turn = np.zeros(len(heading))
    turn[1:-1] = (heading[2:] - a1 * heading[1:-1] - a2 * heading[:-2] - d1) / (b1 - b2)
    a1, _, b1, b2, _ = model.theta[0]
    # in steady state: speed = (a1 - 1) speed + (b1 + b2) forward
    forward = _SPEED * (2 - a1) / (b1 + b2)
    u = np.column_stack((forward + turn, forward - turn))
    poses = _driven(model, u, heading[:2], np.zeros((len(u), 3)))
    noise = np.random.default_rng(_SEED).normal(0.0, MEASUREMENT_SIGMA, poses.shape)
    covariance = np.diag(np.square(MEASUREMENT_SIGMA))
    seen = tuple(Measurement(pose, covariance=covariance) for pose in poses + noise)
    return Situation(name=name, dt=dt, poses=poses, u=u, measurements=seen)


@cache
def excited(dt: float, steps: int, noise: float = 1.0) -> Situation:
    """Return a drive with random voltages, each held for ten steps; noise: share of the usual."""
    u = _held_voltages(steps)
    return _disturbed("robot drives around", u, dt, np.full(len(u), noise))


@cache
def resting(dt: float) -> Situation:
    """Return a drive in which the robot stands still for 1000 steps, then drives on."""
    u = _held_voltages(STANDS.stop + 400)
    u[STANDS.start : STANDS.stop] = 0.0
    # Standing, it is at rest, but not exactly: an exact 0 hides windup.
    noise = np.where(u.any(axis=1), 1.0, _NOISE_AT_REST)
    return _disturbed("robot stands, then drives on", u, dt, noise)


def _held_voltages(steps: int) -> Floats:
    random = np.random.default_rng(_SEED)
    return np.repeat(random.uniform(-0.5, 1.0, (-(-steps // 10), 2)), 10, axis=0)[:steps]


def _disturbed(name: str, u: Floats, dt: float, share: Floats) -> Situation:
    noise = np.random.default_rng(_SEED + 1).normal(0.0, PROCESS_SIGMA, (len(u), 3))
    noise *= share[:, np.newaxis]
    poses = _driven(RobotModel(RobotParameters(dt=dt)), u, np.zeros(2), noise)
    return Situation(name=name, dt=dt, poses=poses, u=u)


def _driven(model: RobotModel, u: Floats, heading: Floats, noise: Floats) -> Floats:
    """Return the poses (N, 3) that the model drives from two initial headings."""
    poses = np.empty((len(u), 3))
    poses[:2, :2], poses[:2, 2] = START, heading
    for k in range(2, len(u)):
        poses[k] = model.predict(poses[k - 1], poses[k - 2], u[k - 1]) + noise[k]
    return poses
