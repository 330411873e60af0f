"""The table of what a live camera's frames take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from robsim.base.report import Column, Quantity, Report, Row, Table, percent

RATE = 30  # frames/s
LIVE_REMARKS = (
    "live: another process renders the frames, and serves them by GigE Vision on loopback or on "
    "the virtual FireWire bus, where a camera of 1280 x 960 px sends 15 a second",
    "to measurement: from the arrival of a frame's last bytes to the pose; median and 95 %",
    "core: the reading process' share of one processor core, with the system's part",
)
STREAM_REMARKS = (
    "network camera: gst-rtsp-server shows the time in its pictures, H.264 with sound; the line "
    "stalls for 1.5 s, and later breaks, so that the camera is opened again",
    "age: from the camera's clock in the picture to the reader, with the encoder's time; median",
    "untold: the spread of the age that frame.t hides; its constant part is the encoder's time",
)


@dataclass(frozen=True, kw_only=True)
class Path:
    """What the frames of a camera take that sends pixels in one way.

    Attributes
    ----------
    format : str
        How it sends pixels, such as ``"yuv422"``.
    size : (int, int)
        Width and height of the frames (px).
    to_rgb : dict of str to float
        From the bytes to RGB (s), by ``"ours"`` and ``"opencv"``.
    to_pose : dict of str to float or None
        From the bytes to the robot's pose (s); OpenCV's ends with the blobs. None if the pixels
        have no colours.
    """

    format: str
    size: tuple[int, int]
    to_rgb: Mapping[str, float]
    to_pose: Mapping[str, float] | None = None

    @property
    def row(self) -> Row:
        """Its row in the table."""
        values: list[float | None] = []
        for times in (self.to_rgb, self.to_pose):
            if times is None:
                values += [None, None, None]
            else:
                ours, theirs = times["ours"], times["opencv"]
                values += [1e3 * ours, 1e3 * theirs, theirs / ours]
        share = None if self.to_pose is None else RATE * self.to_pose["ours"]
        return Row(f"{self.format}_{self.size[0]}x{self.size[1]}", [*values, share], unit="ms")


@dataclass(frozen=True, kw_only=True)
class Live:
    """What it took to read a live camera and to find the robot in each frame.

    Attributes
    ----------
    transport, coding : str
        How the frames came, such as ``"gige"``, and how they were sent, such as ``"raw8"``.
    size : (int, int)
        Width and height of the frames (px).
    rate : float
        Frames that were measured a second.
    lost : int
        Frames that did not come, or were not taken.
    latency, latency_p95 : float
        From the bytes in memory to the measurement: median and 95th percentile (ms).
    core : float
        Share of a processor core of the process that reads.
    """

    transport: str
    coding: str
    size: tuple[int, int]
    rate: float
    lost: int
    latency: float
    latency_p95: float
    core: float

    @property
    def row(self) -> Row:
        """Its row in the table."""
        name = f"{self.transport}_{self.coding}_{self.size[0]}x{self.size[1]}"
        return Row(name, [self.rate, self.lost, self.latency, self.latency_p95, self.core])


@dataclass(frozen=True, kw_only=True)
class Stream:
    """Ages of the pictures of a network camera, as `streams.read_stream` measures them.

    Attributes
    ----------
    coding : str
        The coding of the stream.
    frames, dropped : int
        Numbers of frames that a reader got, and of dropped ones.
    age, oldest : float
        Age of the pictures that a reader got: median and maximum (ms).
    untold : float
        Spread of the age that `Frame.t` hides (ms).
    """

    coding: str
    frames: int
    dropped: int
    age: float
    oldest: float
    untold: float

    @property
    def row(self) -> Row:
        """Its row in the table."""
        values = [self.frames, self.dropped, self.age, self.oldest, self.untold]
        return Row(f"rtsp_{self.coding}", values)


def _three_digits(milliseconds: float) -> str:
    return f"{milliseconds:.3g}"


@dataclass(frozen=True, kw_only=True)
class CameraBench(Report):
    """How fast a live camera's frames become poses on this machine.

    Attributes
    ----------
    cpu_path : str
        The instruction set that the inner loops used.
    paths : tuple of Path
        A way to send pixels and a size each.
    live : tuple of Live
        A camera that was read live each.
    streams : tuple of Stream
        A network camera that was read each.
    left_out : tuple of str
        Live cameras that could not be read, and why.
    """

    cpu_path: str
    paths: tuple[Path, ...]
    live: tuple[Live, ...] = ()
    streams: tuple[Stream, ...] = ()
    left_out: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """What was measured."""
        return "A camera's frame, from its bytes to RGB and to the robot's pose: median times"

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The instruction set."""
        return (Quantity("cpu_path", "vector instructions", self.cpu_path),)

    @property
    def tables(self) -> tuple[Table, ...]:
        """A row for each way to send pixels and each size, and one for each live camera."""
        columns = []
        for key, title in (("to_rgb", "to RGB"), ("to_pose", "to pose")):
            columns += [
                Column(key, title, None, _three_digits, missing=""),
                Column(f"{key}_opencv", "OpenCV", None, _three_digits, missing=""),
                Column(f"{key}_ratio", "x", "", ".1f", missing=""),
            ]
        columns.append(Column("core", f"core at {RATE}/s", "", percent, missing=""))
        rows = [path.row for path in self.paths]
        paths = Table(key="paths", columns=columns, rows=rows, row_title="pixels")
        more = [self._live_table] * bool(self.live) + [self._stream_table] * bool(self.streams)
        return (paths, *more)

    @property
    def _live_table(self) -> Table:
        columns = (
            Column("rate", "frames", "1/s", ".1f"),
            Column("lost", "lost", "", ".0f"),
            Column("latency", "to measurement", "ms", _three_digits),
            Column("latency_p95", "95 %", "ms", _three_digits),
            Column("core", "core", "", percent),
        )
        rows = [camera.row for camera in self.live]
        return Table(key="live", columns=columns, rows=rows, row_title="live camera")

    @property
    def _stream_table(self) -> Table:
        columns = (
            Column("frames", "frames", "", ".0f"),
            Column("dropped", "dropped", "", ".0f"),
            Column("age", "age", "ms", _three_digits),
            Column("oldest", "oldest", "ms", _three_digits),
            Column("untold", "untold", "ms", _three_digits),
        )
        rows = [stream.row for stream in self.streams]
        return Table(key="streams", columns=columns, rows=rows, row_title="network camera")

    @property
    def remarks(self) -> tuple[str, ...]:
        """How to read the columns."""
        return (
            "x: how many times as long as robsim; OpenCV in one thread, and to the blobs alone",
            f"core at {RATE}/s: robsim's share of one processor core at {RATE} frames a second",
            "yuv411: OpenCV does not know a camera's order, so numpy sorts the bytes first",
            "mono8 shows no colours, so there are no markers to find",
            *(LIVE_REMARKS if self.live else ()),
            *(STREAM_REMARKS if self.streams else ()),
            *self.left_out,
        )
