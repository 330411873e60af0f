"""Sessions as MCAP files of ROS 2 messages."""

from __future__ import annotations

import importlib
import json
import math
from collections.abc import Iterator
from contextlib import nullcontext
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np

from robsim.base.files import as_path, open_whole
from robsim.base.text import one_line

if TYPE_CHECKING:
    from robsim.trace.sessions.rows import Row
    from robsim.trace.sessions.session import Session

_LONGEST = 2**63 - 1  # ns

_TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
_HEADER = (
    f"MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{80 * '='}\n{_TIME}"
)


def _definition(fields: str, *parts: str) -> str:
    return "".join([fields, *(f"{80 * '='}\n{part}" for part in parts)])


# Topic -> message type and its definition.
_TOPICS = {
    "/camera/image/compressed": (
        "sensor_msgs/msg/CompressedImage",
        _definition("std_msgs/Header header\nstring format\nuint8[] data\n", _HEADER),
    ),
    "/pose_measured": (
        "geometry_msgs/msg/PoseStamped",
        _definition(
            "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
            _HEADER,
            "MSG: geometry_msgs/Pose\n"
            "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
            "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n",
            "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
        ),
    ),
    "/u": (
        "std_msgs/msg/Float64MultiArray",
        _definition(
            "std_msgs/MultiArrayLayout layout\nfloat64[] data\n",
            "MSG: std_msgs/MultiArrayLayout\n"
            "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n",
            "MSG: std_msgs/MultiArrayDimension\nstring label\nuint32 size\nuint32 stride\n",
        ),
    ),
    "/missed": ("std_msgs/msg/String", "string data\n"),
}


def write_mcap(path: str | PathLike[str], session: Session) -> None:
    """Write a session as `Session.export_mcap` says."""
    file = as_path(path)
    try:
        writers = importlib.import_module("mcap_ros2.writer")
        records = importlib.import_module("mcap.writer")
    except ImportError as error:
        raise ImportError(
            'writing an MCAP file needs two packages: pip install "robsim[mcap]"'
        ) from error
    origin = _origin(session)
    with open_whole(file) as stream:
        # The pictures are packed already.
        writer = writers.Writer(stream, compression=records.CompressionType.NONE)
        schemas = {
            topic: writer.register_msgdef(kind, text) for topic, (kind, text) in _TOPICS.items()
        }
        for number, (topic, t, message) in enumerate(_messages(session, origin)):
            stamp = _nanoseconds(origin, t)
            writer.write_message(topic, schemas[topic], message, stamp, stamp, number % 2**32)
        setup = one_line(json.dumps(session.setup, default=str))
        writer.add_metadata("robsim", {"session": session.folder.name, "setup": setup})
        writer.finish()


def _origin(session: Session) -> int:
    """Return the time of the clock of `t` at 0, as ns since 1970: the first step began the run."""
    started = session._parsed.started
    start = 0 if started is None else round(started.timestamp() * 1000) * 1_000_000
    return start - round(1e9 * (session._rows[0].t if session._rows else 0.0))


def _nanoseconds(origin: int, t: float) -> int:
    return min(max(0, origin + round(1e9 * t)), _LONGEST)


def _messages(session: Session, origin: int) -> Iterator[tuple[str, float, dict[str, Any]]]:
    """Give the messages in the order of their steps: topic, time (s), content."""
    pictures = session._pictures
    with nullcontext(0) if pictures is None else pictures.opened() as descriptor:
        for row in session._rows:
            if pictures is not None and session._has_picture(row):
                assert row.video_frame is not None
                yield _image(row, origin, pictures.encoded(descriptor, row.video_frame))
            if not np.isnan(row.pose_measured).any():
                yield _pose(row, origin)
            elif row.reason:
                yield "/missed", row.t, {"data": row.reason}
            if not np.isnan(row.u).any():
                sent = row.t if math.isnan(row.t_sent) else row.t_sent
                layout = {"dim": [], "data_offset": 0}
                yield "/u", sent, {"layout": layout, "data": list(row.u)}


def _header(row: Row, origin: int, frame: str) -> dict[str, Any]:
    seconds, rest = divmod(_nanoseconds(origin, row.t), 1_000_000_000)
    # ROS 2 counts seconds in 32 bits.
    return {"stamp": {"sec": min(seconds, 2**31 - 1), "nanosec": rest}, "frame_id": frame}


def _image(row: Row, origin: int, picture: bytes) -> tuple[str, float, dict[str, Any]]:
    kind = "png" if picture.startswith(b"\x89PNG") else "jpeg"
    header = _header(row, origin, "camera")
    return "/camera/image/compressed", row.t, {"header": header, "format": kind, "data": picture}


def _pose(row: Row, origin: int) -> tuple[str, float, dict[str, Any]]:
    x, y, heading = row.pose_measured
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}
    pose = {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}
    return "/pose_measured", row.t, {"header": _header(row, origin, "area"), "pose": pose}
