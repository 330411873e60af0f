"""The native world of a scenario."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robsim import _core
from robsim._core import RobotModel
from robsim.base import seeds
from robsim.simulation.options import OPTIONS
from robsim.simulation.world.disturbances import Dropout, PoseNoise, WheelNoise
from robsim.simulation.world.scene import draw_red_square, make_scene, scaled_floor
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import as_native_noise

if TYPE_CHECKING:
    from robsim.simulation.scenario import Scenario


def frame_size(options: Scenario) -> tuple[int, int]:
    return options.resolution or options.area


def world_of(
    scenario: Scenario, seed: np.random.SeedSequence, *, makes_scene_at_start: bool = False
) -> _core.SimulatedWorld:
    """Return the world of a scenario, which makes its scene on first use, or at the start."""
    world = _core.SimulatedWorld(
        area=scenario.area, resolution=frame_size(scenario), boundary=scenario.boundary
    )
    apply_options(world, scenario, OPTIONS)
    seed_world(world, scenario, seed)
    set_scene(world, scenario, makes_at_start=makes_scene_at_start)
    world.set_evaluate_model(scenario.evaluate_model)
    return world


def apply_options(world: _core.SimulatedWorld, scenario: Scenario, names: Iterable[str]) -> None:
    """Give a world the values of these options, if it has them; between two steps, too."""
    plain = world.option_names()
    for name in names:
        value = getattr(scenario, name)
        if name in _SETTERS:
            _SETTERS[name](world, value)
        elif name in plain:
            world.set_option(name, value)


def _set_process_noise(
    world: _core.SimulatedWorld, process_noise: PoseNoise | WheelNoise | None
) -> None:
    factor = process_noise.factor if isinstance(process_noise, PoseNoise) else np.zeros((3, 3))
    sigma = process_noise.sigma if isinstance(process_noise, WheelNoise) else 0.0
    world.set_disturbance(factor, np.broadcast_to(sigma, 2).tolist())


def _set_dropout(world: _core.SimulatedWorld, dropout: Dropout | None) -> None:
    dropout = dropout or Dropout(0.0)
    world.set_dropout(dropout.probability, dropout.steps)


#: Setters of the options whose value a world does not take as it is.
_SETTERS: dict[str, Callable[[_core.SimulatedWorld, Any], None]] = {
    "robot": lambda world, robot: world.set_option("robot_radius", robot.radius),
    "noise": lambda world, noise: world.set_option("noise", as_native_noise(noise)),
    "dropout": _set_dropout,
    "process_noise": _set_process_noise,
}


def seed_world(
    world: _core.SimulatedWorld, scenario: Scenario, seed: np.random.SeedSequence
) -> None:
    """Give a world its random streams, and its values from the seed: its start and its model."""
    world.set_seeds(
        noise=seeds.stream_number(seed, "noise"),
        dropout=seeds.stream_number(seed, "dropout"),
        disturbance=seeds.stream_number(seed, "disturbance"),
    )
    world.set_start(_start_pose(scenario, seed))
    world.set_true_model(partial(_true_model, scenario, seed))


def set_scene(
    world: _core.SimulatedWorld,
    scenario: Scenario,
    adjust_background: Callable[[Pixels], Pixels] | None = None,
    *,
    makes_at_start: bool,
) -> None:
    """Let a world make its scene on first use, or at the start."""
    make = partial(_scene_of, scenario, adjust_background or draw_red_square)
    world.set_make_scene(make, makes_at_start=makes_at_start)


def check_bounces(scenario: Scenario) -> None:
    """Raise ValueError if the robot has no room to bounce in."""
    radius = scenario._robot_definition.radius
    if scenario.boundary == "bounce" and min(scenario.area) <= 2 * radius + 1:
        raise ValueError(
            f"area must be wider than the robot ({2 * radius:.0f} px) for boundary='bounce', got "
            f"{scenario.area}"
        )


def _start_pose(scenario: Scenario, seed: np.random.SeedSequence) -> ArrayLike:
    width, height = scenario.area
    start = scenario.start
    if start is None:
        return (width / 2, height / 2, 0.0)
    if not isinstance(start, str):
        return start
    margin = min(scenario._robot_definition.radius, width / 2, height / 2)
    lows, highs = (margin, margin, -np.pi), (width - 1 - margin, height - 1 - margin, np.pi)
    bits = seeds.random_bits(seeds.stream(seed, "start"))
    return [
        low + (high - low) * ((next(bits) >> 11) * 2.0**-53)
        for low, high in zip(lows, highs, strict=True)
    ]


def _scene_of(scenario: Scenario, adjust: Callable[[Pixels], Pixels]) -> _core.Scene:
    return make_scene(
        robot=scenario._robot_definition,
        area=scenario.area,
        resolution=frame_size(scenario),
        headings=scenario.headings or 0,
        background=scaled_floor(scenario._floor, scenario.area),
        adjust_background=adjust,
    )


def _true_model(options: Scenario, seed: np.random.SeedSequence, belief: RobotModel) -> RobotModel:
    """Return the model of the world: the options' model, or else the robot half's belief."""
    model = options._model or belief
    if model.dt != belief.dt:
        raise ValueError(
            f"define_model must return a model with the world's dt = {model.dt:g} s, got "
            f"dt = {belief.dt:g} s"
        )
    if options.mismatch is None:
        return model
    return options.mismatch.draw(model, np.random.default_rng(seeds.stream(seed, "mismatch")))
