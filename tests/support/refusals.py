"""Bad input, declared: which call refuses which values in the name of which argument.

A test of a table reads ``@refusals(Refusal(call, name, values), options(call, {name: values}))``
over ``def test_...(refusal): refusal()``.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

NAN, INF = np.nan, np.inf
WRONG = (TypeError, ValueError)
IMAGE = np.full((8, 10, 3), 100, np.uint8)
POSE = (1.0, 2.0, 3.0)
SQUARE = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], dtype=float)

# What is refused wherever a ... is asked for.
NOT_FINITE = (NAN, INF, -INF)
NO_PAIR = (None, 5, "ab", (1,), (1, 2, 3), (NAN, 1))
NO_IMAGE = (
    *(None, "image.png", "ä" * 100, b"\0" * 12, Path("image.png"), 3, IMAGE.tolist()),
    *([[["a", "b", "c"]]], np.uint8(3), np.array(3, np.uint8), np.full((8, 10, 3), NAN)),
    *(IMAGE[0, 0], IMAGE[..., 0], IMAGE[None], IMAGE[..., :0], IMAGE[..., :1]),
    *(np.zeros((8, 10, 4), np.uint8), np.zeros((3, 8, 10), np.uint8), IMAGE[:0], IMAGE[:, :0]),
    *(IMAGE[:, ::-1], IMAGE[..., ::-1], IMAGE[:, ::2], IMAGE.transpose(1, 0, 2)),
    *(np.asfortranarray(IMAGE), np.zeros((8, 10, 4), np.uint8)[..., :3]),
    *(np.broadcast_to(np.uint8(0), shape) for shape in ((8, 10, 3), (65536, 2, 3))),
    *(np.broadcast_to(np.uint8(0), shape) for shape in ((2, 65536, 3), (2**32 + 8, 10, 3))),
    *(IMAGE.astype(kind) for kind in (bool, object)),
    *(np.zeros((8, 10, 3), kind) for kind in ([("r", "u1")], "m8[s]")),
)
NO_POSE = (
    *("abc", b"abc", 5.0, (1, 2), (1, 2, 3, 4), [POSE], [], ["a", "b", "c"], [[1], [2, 3], 4]),
    *((NAN, 0, 0), (0, -INF, 0), (None, 0, 0), (1j, 0, 0), (10**400, 0, 0), object()),
    *({0: 1, 1: 2, 2: 3}, {1, 2, 3}, (value for value in POSE)),
)
NO_POLYGON = (
    *(None, 5, "abc", [["a", "b"]] * 3, [], SQUARE[:2], [[0, 0], [1, 1], [2, 2]]),
    *(np.zeros((4, 2)), [[0, 0], [4, 4], [4, 0], [0, 4]], [[1, 2], [3], [4, 5]]),
    *(np.ones((4, 3)), SQUARE[None], SQUARE * NAN, [[0, 0], [INF, 0], [0, 1]]),
    *([[1j, 0], [1, 0], [1, 1]], {1, 2, 3}),
)


def refuses(name, call, /, *arguments, raises=WRONG, says="", **options):
    """The call raises an error of the right type that has the argument's name as a word."""
    with pytest.raises(raises) as caught:
        call(*arguments, **options)
    message = str(caught.value)
    assert re.search(rf"\b{re.escape(name)}(?!\w)", message), message
    assert re.search(says.replace("{name}", name), message), message
    return message


def short(value):
    """A value as part of a test's name: the same in every process."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{value.shape}"
    return re.sub(r" at 0x\w+|\s+", " ", repr(value))[:40]


@dataclass(frozen=True)
class Refusal:
    """``call(value)`` is refused in the name of an argument for each of the values."""

    call: Callable
    name: str
    values: Iterable
    says: str = ""
    raises: type[Exception] | tuple[type[Exception], ...] = WRONG

    def __call__(self):
        for value in self.values:
            try:
                refuses(self.name, self.call, value, raises=self.raises, says=self.says)
            except BaseException as error:
                error.add_note(f"{self.name} = {short(value)}")
                raise

    def param(self):
        of = getattr(self.call, "__name__", "").replace("<lambda>", "")
        return pytest.param(self, id=f"{of}({self.name})")


def options(call, values, /, *given, says="", raises=WRONG, **good):
    """A refusal of ``call(*given, **good)`` for each keyword that has bad values.

    Keywords with the same ones stand in one text: ``{"low high": (None, "x")}``.
    """
    return [
        Refusal(
            lambda value, name=name: call(*given, **good | {name: value}), name, bad, says, raises
        )
        for names, bad in values.items()
        for name in names.split()
    ]


def refusals(*rows):
    """One test case for each row of a table."""
    rows = [row for some in rows for row in (some if isinstance(some, list) else [some])]
    return pytest.mark.parametrize("refusal", [row.param() for row in rows])
