"""Dropouts as a value: `Simulation(dropout=Dropout(0.2))` hides the robot from the camera."""

from __future__ import annotations

from dataclasses import dataclass

from robsim.base.checks import check_float, check_int
from robsim.base.text import quoted


@dataclass(frozen=True)
class Dropout:
    """Random occlusion: something hides the robot from the camera.

    The run is divided into segments of `steps` steps; in each segment, independently, the robot is
    hidden throughout with this probability.

    Parameters
    ----------
    probability : float
        Probability that the robot is hidden in a segment, 0..1.
    steps : int
        Length of a segment (steps), at least 1.

    Raises
    ------
    TypeError, ValueError
        If an argument has the wrong type or is out of range; the message names it.

    Examples
    --------
    >>> sim = robsim.Simulation(measure=True, dropout=robsim.Dropout(0.2, steps=5), seed=1)
    """

    probability: float
    steps: int = 1

    def __post_init__(self) -> None:
        check_float("probability", self.probability, minimum=0, maximum=1)
        check_int("steps", self.steps, minimum=1, maximum=2**31 - 1)


def as_dropout(dropout: Dropout | None) -> Dropout:
    """Return the value of the option ``dropout`` as a Dropout; None = probability 0."""
    if dropout is None:
        return Dropout(0.0)
    if not isinstance(dropout, Dropout):
        raise TypeError(
            f"dropout must be a Dropout or None, got {quoted(dropout)}: write, for example, "
            "dropout=robsim.Dropout(0.2)"
        )
    return dropout
