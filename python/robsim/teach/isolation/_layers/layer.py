"""A layer of the isolation, for the report."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Layer:
    """A layer: its name, whether it holds, and its method or the reason of its failure."""

    name: str
    holds: bool
    text: str

    @classmethod
    def left_out(cls, name: str) -> Layer:
        return cls(name, False, "left out")

    @property
    def phrase(self) -> str:
        """The layer in the line of the report: ``"files (Landlock 7)"``."""
        if self.name == USER and self.holds:  # without its number: workers have different users
            return "own user"
        return f"{self.name} ({self.text})" if self.holds and self.text else self.name


PROCESS, LIMITS, MOUNTS, USER, MEMORY = "process", "limits", "own mounts", "user", "memory"
FILES, CALLS, PIDS, NETWORK = "files", "system calls", "own process numbers", "own network"


def attempt(name: str, act: Callable[[], str]) -> Layer:
    """Return the layer of an action; the action returns its method, or raises the reason."""
    try:
        return Layer(name, True, act())
    except OSError as error:
        return Layer(name, False, error.strerror or str(error))


def missing_layers(system: str) -> list[Layer]:
    reason = f"not supported by robsim on {system}"
    return [Layer(n, False, reason) for n in (MOUNTS, USER, MEMORY, FILES, CALLS, PIDS, NETWORK)]


@dataclass(frozen=True)
class Layers:
    """All layers of a worker, in the order of their creation."""

    layers: tuple[Layer, ...]

    def __getitem__(self, name: str) -> Layer:
        for layer in self.layers:
            if layer.name == name:
                return layer
        return Layer.left_out(name)

    def holds(self, *names: str) -> bool:
        return all(self[name].holds for name in names)

    @property
    def closed(self) -> Mapping[str, bool]:
        """Whether the worker has no access to files, processes, network, the grader's memory."""
        calls, user = self.holds(CALLS), self.holds(USER)
        return {
            "files": self.holds(FILES) and (calls or user),
            "processes": calls or (user and self.holds(PIDS)),
            "network": calls or self.holds(NETWORK),
            "the grader's memory": self.holds(MEMORY) and (calls or user),
        }

    @property
    def certain_end(self) -> bool:
        """Whether no process can outlive the worker."""
        return self.holds(CALLS) or self.holds(PIDS) or self.holds(USER)

    @property
    def line(self) -> str:
        """The layers that hold and the layers that fail, in one line."""
        shown = [layer for layer in self.layers if layer.name not in (LIMITS, MEMORY)]
        held = [layer.phrase for layer in shown if layer.holds]
        missing = [layer.name for layer in shown if not layer.holds]
        text = f"isolation: {', '.join(held) or 'none'}"
        return f"{text}; not: {', '.join(missing)}" if missing else text

    def to_message(self) -> list[list[Any]]:
        return [[layer.name, layer.holds, layer.text] for layer in self.layers]

    @classmethod
    def from_message(cls, message: list[list[Any]]) -> Layers:
        return cls(tuple(Layer(*values) for values in message))
