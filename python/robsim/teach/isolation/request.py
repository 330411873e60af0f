"""What a worker is asked to be, as plain values that go from process to process."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from robsim.teach.isolation.limits import Limits

Isolation = Literal["auto", "none", "process", "strict"]
LEVELS: tuple[Isolation, ...] = ("auto", "none", "process", "strict")


@dataclass(frozen=True, kw_only=True)
class Request:
    """A worker that is asked for.

    Attributes
    ----------
    entry : str
        ``"module:function"``: trusted code, called as ``function(channel, memory)``.
    limits : Limits
        What it may take.
    isolation : str
        One of `LEVELS`.
    hidden : tuple of str
        Folders and files that it must not read.
    user : int or None
        The number of the user that it is to become.
    without : tuple of str
        Names of layers to leave out.
    """

    entry: str
    limits: Limits
    isolation: Isolation
    hidden: tuple[str, ...] = ()
    user: int | None = None
    without: tuple[str, ...] = ()

    @property
    def shut(self) -> bool:
        """Whether it is to be shut in as far as the system can."""
        return self.isolation in ("auto", "strict")

    def to_message(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_message(cls, message: dict[str, Any]) -> Request:
        return cls(
            **{
                **message,
                "limits": Limits(**message["limits"]),
                "hidden": tuple(message["hidden"]),
                "without": tuple(message["without"]),
            }
        )
