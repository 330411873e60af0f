"""Small runs of all that a result depends on: what is the same bytes everywhere, what to digits."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from robsim import _core
from robsim._core import DriveAround, Unicycle
from robsim.base.checks import Floats
from robsim.control import Chirp, FollowPath, GoToPoint, MultiSine, PseudoRandomBinary
from robsim.estimation import batch_estimate
from robsim.simulation import Dropout, ParameterMismatch, PoseNoise, Simulation, WheelNoise
from robsim.trace import Trace
from robsim.vision import GaussianNoise, PlaneMap, UniformNoise

Arrays = Iterable[Any]

_SEED = 14
_STEPS = 200
_CORNERS = ((400, 400), (800, 400), (800, 800), (400, 800))
_POSE_NOISE = PoseNoise(((0.3, 0.1, 0.0), (0.1, 0.4, 0.001), (0.0, 0.001, 1e-4)))


def _simulation(**options: Any) -> Simulation:
    given: dict[str, Any] = {"boundary": "unlimited", "control": DriveAround(), "seed": _SEED}
    return Simulation(**(given | options))


def _run(steps: int = _STEPS, **options: Any) -> Trace:
    return _simulation(**options).run(steps)


def _path(**options: Any) -> Callable[[], Arrays]:
    def path() -> Arrays:
        trace = _run(**options)
        return trace.pose_true, trace.u

    return path


def _seen(**options: Any) -> Callable[[], Arrays]:
    def seen() -> Arrays:
        trace = _run(measure=True, steps=40, **options)
        return trace.pose_true, trace.u, trace.pose_measured

    return seen


with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # 0.7 % is meant
    _WEAK = GaussianNoise(0.7)


def _frames(**options: Any) -> Callable[[], Arrays]:
    def frames() -> Arrays:
        sim = _simulation(**options)
        for _ in range(3):
            sim.run(20)
            yield sim.frame.image

    return frames


def _elementary() -> Arrays:
    angles = np.linspace(-20, 20, 2001)
    large = np.ldexp(angles, np.arange(2001) % 900)
    positive = np.ldexp(1 + angles**2, np.arange(2001) % 900)
    pairs = zip(angles.tolist(), angles[::-1].tolist(), strict=True)
    return (
        *(function(x) for function in (_core.sin, _core.cos) for x in (angles, large)),
        _core.exp(angles),
        _core.log(positive),
        [(_core.atan2(a, b * b - 7), _core.hypot(a, b)) for a, b in pairs],
    )


def _random() -> Arrays:
    counters = range(500)
    return (
        [_core.random_uniform(_SEED, i) for i in counters],
        [_core.random_normal(_SEED, i) for i in counters],
    )


def _recursive() -> Arrays:
    trace = _run(estimate_parameters=True, measure=True, steps=60, identify_from="measurement")
    exact = _run(estimate_parameters=True)
    return trace.parameters, exact.parameters, exact.standard_errors_unscaled


def _true_model() -> Arrays:
    sim = Simulation(mismatch=ParameterMismatch(0.1), seed=_SEED)
    return (sim.true_model.theta,)


def _map_of_four_points() -> Arrays:
    pixels = [(10, 12), (390, 20), (380, 395), (15, 380)]
    positions = [(0, 0), (1200, 0), (1200, 1200), (0, 1200)]
    plane_map = PlaneMap.from_points(pixels, positions)
    return plane_map.matrix, plane_map.to_world(pixels), plane_map.to_pixel(positions)


#: The same bytes on every machine, from every compiler.
BYTES: dict[str, Callable[[], Arrays]] = {
    "sines, logarithms, angles": _elementary,
    "random numbers": _random,
    "path: DriveAround": _path(),
    "path: PseudoRandomBinary": _path(control=PseudoRandomBinary(seed=3)),
    "path: MultiSine": _path(control=MultiSine(seed=3)),
    "path: MultiSine, 200 sines": _path(
        control=MultiSine(minimum_frequency=0.002, maximum_frequency=0.4, seed=4)
    ),
    "path: Chirp": _path(control=Chirp()),
    "path: Chirp of one octave": _path(
        control=Chirp(minimum_frequency=0.1, maximum_frequency=0.2, duration=13)
    ),
    "path: Unicycle": _path(evaluate_model=Unicycle()),
    "path: bounces, random start": _path(start="random", boundary="bounce", area=(300, 300)),
    "path: delayed motors": _path(motor_delay=3),
    "path: PoseNoise": _path(process_noise=_POSE_NOISE),
    "path: WheelNoise": _path(process_noise=WheelNoise((0.1, 0.2))),
    "path: ParameterMismatch": _path(mismatch=ParameterMismatch(0.1)),
    "world of ParameterMismatch": _true_model,
    "path seen: GoToPoint": _seen(control=GoToPoint(900, 300)),
    "path seen: FollowPath": _seen(control=FollowPath(_CORNERS)),
    "measured: smoothed": _seen(smoothing=5, resolution=(480, 480)),
    "measured: GaussianNoise": _seen(noise=GaussianNoise(20)),
    "measured: UniformNoise": _seen(noise=UniformNoise(20)),
    "measured: Dropout, delayed camera": _seen(dropout=Dropout(0.3, steps=2), camera_delay=2),
    "measured: robot2": _seen(robot="robot2"),
    "frames: 36 headings": _frames(),
    "frames: any heading": _frames(headings=None),
    "frames: lab, 480 x 360": _frames(robot="lab", resolution=(480, 360)),
    "frames: sheep, enlarged": _frames(robot="sheep", area=(500, 400), resolution=(1000, 800)),
    "frames: GaussianNoise": _frames(noise=GaussianNoise(40), resolution=(300, 200)),
    "frames: GaussianNoise, weak": _frames(noise=_WEAK, resolution=(300, 200)),
    "frames: UniformNoise": _frames(noise=UniformNoise(40), resolution=(300, 200)),
    "recursive least squares": _recursive,
    "map of four points": _map_of_four_points,
}


def _batch(method: str) -> Callable[[], Floats]:
    def parameters() -> Floats:
        noisy = GaussianNoise(20)
        trace = _run(measure=True, noise=noisy, smoothing=3, resolution=(400, 400))
        return batch_estimate(trace, method=method, identify_from="measurement").batch

    return parameters


def _filtered(name: str) -> Callable[[], Floats]:
    def poses() -> Floats:
        estimator = getattr(import_module("robsim.estimation.reference"), name)()
        trace = _run(measure=True, estimate_state=estimator, steps=40)
        return trace.pose_estimated[20:, :2]

    return poses


def _map_of_six_points() -> Floats:
    pixels = [(10, 12), (390, 20), (380, 395), (15, 380), (200, 201), (100, 300)]
    positions = [(0, 0), (1200, 0), (1200, 1200), (0, 1200), (600, 602), (290, 900)]
    return PlaneMap.from_points(pixels, positions).matrix


#: To so many digits, where linear algebra, or numpy's random numbers, are on the way.
DIGITS: dict[str, tuple[int, Callable[[], Floats]]] = {
    "map of six points": (9, _map_of_six_points),
    "batch: least squares": (9, _batch("least_squares")),
    "batch: instrumental variables": (9, _batch("instrumental_variables")),
    "batch: output error": (9, _batch("output_error")),
}
if find_spec("robsim.estimation.reference"):  # a course may have deleted it
    DIGITS |= {
        "extended Kalman filter": (9, _filtered("ExtendedKalmanFilter")),
        "unscented Kalman filter": (9, _filtered("UnscentedKalmanFilter")),
        "particle filter": (9, _filtered("ParticleFilter")),
    }
