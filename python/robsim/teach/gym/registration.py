"""The names by which ``gymnasium.make`` finds the tasks."""

from __future__ import annotations

import gymnasium

from robsim.teach.gym.environment import REWARDS


def register() -> None:
    for kind in REWARDS:
        name = f"robsim/{kind.name.capitalize()}-v0"
        if name not in gymnasium.registry:
            gymnasium.register(
                name, entry_point="robsim.teach.gym:TaskEnv", kwargs={"task": kind.name}
            )
