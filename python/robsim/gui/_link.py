"""A connection from Python to one browser: messages and their checks, and frames."""

from __future__ import annotations

import io
import math
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:  # loaded with the first picture, so that the start page opens sooner
    from PIL import Image

    from robsim._core import Blob, Frame, PlaneMap
    from robsim.vision.imaging import images

Buffers = Sequence[bytes]
_FORGET = 10.0  # s after which a view, silent unlike others, counts as gone
_MOST_VIEWS = 20
_WIDEST = 1 << 14  # px of a picture
_SAID_LATE = ("grant", "size", "bye", "columns")  # messages without an answer
_MOST_REFUSALS = 10  # answered per second
SLOW = 0.3  # s between frames without grants


class Link(ABC):
    """A link to a browser page, or to a widget with several views; only for a `View`'s thread.

    Its views grant room for frames in advance: a slow view misses frames without blocking others.
    """

    is_in_notebook: ClassVar[bool] = False
    keeps_still: ClassVar[bool] = False  # whether it can store a still picture

    def __init__(self) -> None:
        self.sent = 0  # frames
        self.rows: dict[str, int] = {}  # group of columns -> next row
        self.n_resets = 0  # of the record, when rows were last sent.
        self.width = 600  # px of the picture on the screen
        self.shown: object = None  # the newest sent frame
        self.frame: Frame | None = None  # the displayed frame, also of a past step
        self.looking: int | None = None  # the displayed past step; None = the newest
        self._grants: dict[str, int] = {}  # view -> the last frame with room
        self._heard: dict[str, float] = {}
        self._last_frame = 0.0
        self._n_late = 0  # consecutive grants of a view that waits for sent frames.
        self._arrived = 0  # frames sent when the view last received one or did not wait.
        self._upto: int | None = None  # the newest grant, which grows with each received frame
        self._refused: deque[float] = deque(maxlen=_MOST_REFUSALS)  # times
        self.n_waiting = 0  # messages of its views; with the lock of the `View` held
        self.bytes_waiting = 0  # of their buffers, with the same lock
        self.is_gone = False  # whether sending has failed
        self._last: LastWords | None = None
        self.said = 0.0  # when the last message was sent, by the monotonic clock

    @abstractmethod
    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        """Send a message to the other end without waiting; OSError, RuntimeError: it is gone."""

    def send(self, head: Mapping[str, Any], buffers: Buffers = ()) -> None:
        """Send a message; without a receiver, the message is lost."""
        if self.is_gone:
            return
        self.said = time.monotonic()
        try:
            self.transmit(head, buffers)
        except (OSError, RuntimeError):
            self.is_gone = True

    def refuse(self, why: str) -> None:
        """Send the reason for a refusal, unless there are too many."""
        now = time.monotonic()
        if len(self._refused) < _MOST_REFUSALS or now - self._refused[0] > 1.0:
            self._refused.append(now)
            self.send({"type": "note", "level": "error", "text": why})

    def keep(self, picture: bytes) -> None:
        """Store a picture (PNG) for the time after Python ends, instead of the previous one."""
        raise NotImplementedError  # if `keeps_still` is false

    def end(self, last: LastWords) -> None:
        """Send the last words to views without a message; store them for later views."""
        self._last = last
        if not (self.is_watched or self.is_in_notebook):  # a widget requests them
            self._say_last(last)

    def late(self, message: Any) -> None:
        """Answer a message after the end of the panel."""
        kind = message.get("type") if isinstance(message, dict) else None
        if kind == "hello" and self._last is not None:
            self._say_last(self._last)
        elif self._last is not None and kind not in _SAID_LATE:
            self.refuse("This panel is closed")

    def _say_last(self, last: LastWords) -> None:
        for head, buffers in last.messages:
            self.send(head, buffers)

    @property
    def is_watched(self) -> bool:
        """Whether a view has said hello and not bye."""
        return bool(self._grants)

    def greet(self, view: str) -> None:
        """Note a new view with room for a frame; forget the longest silent view of too many."""
        if len(self._heard) >= _MOST_VIEWS and view not in self._heard:
            self.part(min(self._heard, key=self._heard.__getitem__))
        self.forget_rows()
        self.grant(view, self.sent + 1)
        self._upto = None

    def forget_rows(self) -> None:
        """Note that a view may lack sent rows, so that they are sent again."""
        self.rows = dict.fromkeys(self.rows, 0)

    def grant(self, view: str, upto: int, *, late: bool = False) -> None:
        """Note that a view has room for frames up to a number; `late`: it waits for a frame."""
        now = time.monotonic()
        has_got_one = self._upto is not None and upto > self._upto
        if not late or has_got_one:
            self._n_late, self._arrived = 0, self.sent
        elif self.sent > self._arrived:
            self._n_late += 1
        self._upto = upto
        self._grants[view], self._heard[view] = upto, now
        for other in [v for v, heard in self._heard.items() if now - heard > _FORGET]:
            self.part(other)  # such as after closing a page without a bye

    def resize(self, width: int) -> None:
        """Note the width of the picture on the screen (px)."""
        self.width = min(max(1, width), _WIDEST)

    def part(self, view: str) -> None:
        """Note that a view has disconnected."""
        self._grants.pop(view, None)
        self._heard.pop(view, None)

    @property
    def is_behind(self) -> bool:
        """Whether much data is in transit: large messages wait; any thread may read this."""
        return False  # unknown

    def lacks(self, newest: object) -> bool:
        return self.is_watched and self.shown is not newest

    def has_room(self, now: float) -> bool:
        """Return whether a frame may be sent; seldom without answers, as in a running cell."""
        if not self._grants:
            return False
        return min(self._grants.values()) > self.sent or now - self._last_frame > SLOW

    def send_frame(self, head: Mapping[str, Any], buffers: Buffers, now: float) -> None:
        """Send a frame with its number and the time, by which a view detects a slow link."""
        self.sent += 1
        self._last_frame = now
        self.send({**head, "n": self.sent, "sent": 1000 * time.time()}, buffers)


class LastWords(Link):
    """A link that stores the last messages of a panel, for views that connect after its end."""

    def __init__(self) -> None:
        super().__init__()
        self.messages: list[tuple[Mapping[str, Any], Buffers]] = []
        self.greet("last")
        self.grant("last", 1 << 30)

    def transmit(self, head: Mapping[str, Any], buffers: Buffers) -> None:
        self.messages.append((head, buffers))


Check = Callable[[Any], Any]
#: Type of message -> field -> check; `id` is in all messages. The field `buffers` is not JSON.
Messages = Mapping[str, Mapping[str, Check]]
_MOST_TEXT = 200  # characters


class Refused(Exception):
    """An unusable message; the browser receives the text."""


def text(value: Any) -> str:
    """Return a short text."""
    if not isinstance(value, str) or len(value) > _MOST_TEXT:
        raise Refused(f"a text of up to {_MOST_TEXT} characters")
    return value


def number(value: Any) -> float:
    """Return a finite number."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        with suppress(OverflowError):
            if math.isfinite(found := float(value)):
                return found
    raise Refused("a finite number")


def whole(value: Any) -> int:
    """Return a whole number from 0."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**53:
        raise Refused("a whole number from 0")
    return value


def switch(value: Any) -> bool:
    if not isinstance(value, bool):
        raise Refused("true or false")
    return value


def setting(value: Any) -> bool | float | str:
    """Return the value of a control."""
    if isinstance(value, bool):
        return value
    return text(value) if isinstance(value, str) else number(value)


def message(value: Any) -> dict[str, Any]:
    """Return a message for a check by its final receiver."""
    if not isinstance(value, dict):
        raise Refused("a message")
    return value


def maybe(check: Check) -> Check:
    return lambda value: None if value is None else check(value)


def list_of(check: Check, most: int) -> Check:
    """Return a check of lists up to a length."""

    def checked(value: Any) -> list[Any]:
        if not isinstance(value, list) or len(value) > most:
            raise Refused(f"a list of up to {most}")
        return [check(item) for item in value]

    return checked


def point(value: Any) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise Refused("x and y")
    return number(value[0]), number(value[1])


def buffers_of_message(value: Any) -> list[bytes]:
    """Return the buffers of a relayed message for a check by the final receiver."""
    if len(value) > 1:
        raise Refused("at most one")
    return [bytes(one) for one in value]


def one_buffer(most: int) -> Check:
    """Return a check of buffers that returns the only one, up to a size in bytes."""

    def checked(value: Any) -> bytes:
        if len(value) != 1 or len(value[0]) > most:
            raise Refused(f"one, of up to {most} bytes")
        return bytes(value[0])

    return checked


#: The messages that every panel accepts.
MAGNIFY = {"at": point, "half": whole, "glass": whole}
COMMON: Messages = {
    "hello": {"width": whole},
    "size": {"width": whole},
    "bye": {},
    "grant": {"upto": whole, "late": switch},
}


def checked_message(
    message: Any, messages: Messages, buffers: Sequence[bytes] = ()
) -> dict[str, Any]:
    """Return a message with exactly the fields of its type; otherwise raise `Refused`."""
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str) or kind not in messages:
        raise Refused("not a message of this panel")
    fields = {"id": text, **messages[kind]}
    given = {**message, "buffers": buffers}  # overrides a field of the browser
    return {"type": kind} | {
        name: _checked(kind, name, check, given) for name, check in fields.items()
    }


def _checked(kind: str, name: str, check: Check, message: dict[str, Any]) -> Any:
    try:
        return check(message[name])
    except KeyError:
        raise Refused(f"the message {kind} lacks {name}") from None
    except Refused as expected:
        raise Refused(f"{name} of the message {kind} must be {expected}") from None


_GAP = 1 / 30  # s between two frames
_QUALITY = 80  # of the JPEG; 25 kB for 600 x 600
_MOST_HALF = 100  # px of the picture to each side under a magnifying glass
_MOST_BYTES = 140_000  # of a still picture in a notebook.
_COLORS = (128, 64, 32, 16)  # with few colours, a photograph of a noisy floor shrinks to a fifth


class FrameClock:
    """The due time of the next frame: "30 ms after the last" would beat against the steps."""

    def __init__(self) -> None:
        self.due = 0.0  # by the monotonic clock

    def sent(self, now: float) -> None:
        self.due = max(self.due + _GAP, now + 0.5 * _GAP)


def jpeg(pixels: images.Pixels) -> bytes:
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(pixels).save(out, "JPEG", quality=_QUALITY)
    return out.getvalue()


def small_png(picture: Image.Image) -> bytes:
    """Return an image as a small PNG with few colours, for a saved notebook."""
    from PIL import Image

    for colors in _COLORS:
        out = io.BytesIO()
        kind = Image.Quantize.FASTOCTREE  # keeps rare colours, such as the markers'
        few = picture.quantize(colors, kind, dither=Image.Dither.NONE)
        few.save(out, "PNG", optimize=True)
        if out.tell() <= _MOST_BYTES:
            break
    return out.getvalue()


def numbers(values: Any) -> list[float] | None:
    """Return an array as a list for JSON; None if a value is not finite."""
    import numpy as np

    array = np.asarray(values, float).ravel()
    return array.tolist() if np.isfinite(array).all() else None


def magnified(image: images.Pixels, message: Mapping[str, Any]) -> tuple[list[int], images.Pixels]:
    """Return the box [left, top, width, height] of a message `magnify`, and its pixels."""
    height, width = image.shape[:2]
    u, v = (round(min(max(one, -1e6), 1e6)) for one in message["at"])
    half = min(message["half"], _MOST_HALF)
    left, right = (min(max(u + side, 0), width) for side in (-half, half + 1))
    top, bottom = (min(max(v + side, 0), height) for side in (-half, half + 1))
    return [left, top, right - left, bottom - top], image[top:bottom, left:right]


def boxes_of(blobs: Mapping[str, Sequence[Blob]]) -> list[list[Any]]:
    """Return ``[colour, left, top, right, bottom]`` of each blob."""
    return [
        [color, *(int(side) for side in blob.bounding_box)]
        for color, found in blobs.items()
        for blob in found
    ]


def lens_of(plane_map: PlaneMap) -> list[float] | None:
    """Return fx, fy, cx, cy and the distortion; None for a camera with an unknown lens."""
    lens = plane_map.intrinsics
    if lens is None:
        return None
    (fx, _, cx), (_, fy, cy), _ = lens.matrix.tolist()
    return [fx, fy, cx, cy, *lens.distortion.tolist()]
