"""The steps of a session as messages of ROS 2, for other programs."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from robsim._core import Frame, PlaneMap
from robsim.trace.sessions.rows import Row, json_of

#: The topics that robsim itself reads.
STEPS, PICTURES = "/robsim/steps", "/camera/image/compressed"

# Message types and their fields, as ROS 2 has them.
_TYPES = dict(
    line.split(": ")
    for line in """\
builtin_interfaces/Time: int32 sec, uint32 nanosec
std_msgs/String: string data
std_msgs/Header: builtin_interfaces/Time stamp, string frame_id
std_msgs/MultiArrayDimension: string label, uint32 size, uint32 stride
std_msgs/MultiArrayLayout: std_msgs/MultiArrayDimension[] dim, uint32 data_offset
std_msgs/Float64MultiArray: std_msgs/MultiArrayLayout layout, float64[] data
geometry_msgs/Point: float64 x, float64 y, float64 z
geometry_msgs/Vector3: float64 x, float64 y, float64 z
geometry_msgs/Quaternion: float64 x, float64 y, float64 z, float64 w
geometry_msgs/Pose: geometry_msgs/Point position, geometry_msgs/Quaternion orientation
geometry_msgs/PoseWithCovariance: geometry_msgs/Pose pose, float64[36] covariance
geometry_msgs/PoseWithCovarianceStamped: std_msgs/Header header, \
geometry_msgs/PoseWithCovariance pose
geometry_msgs/Transform: geometry_msgs/Vector3 translation, geometry_msgs/Quaternion rotation
geometry_msgs/TransformStamped: std_msgs/Header header, string child_frame_id, \
geometry_msgs/Transform transform
tf2_msgs/TFMessage: geometry_msgs/TransformStamped[] transforms
sensor_msgs/CompressedImage: std_msgs/Header header, string format, uint8[] data
sensor_msgs/RegionOfInterest: uint32 x_offset, uint32 y_offset, uint32 height, uint32 width, \
bool do_rectify
sensor_msgs/CameraInfo: std_msgs/Header header, uint32 height, uint32 width, \
string distortion_model, float64[] d, float64[9] k, float64[9] r, float64[12] p, \
uint32 binning_x, uint32 binning_y, sensor_msgs/RegionOfInterest roi
diagnostic_msgs/KeyValue: string key, string value
diagnostic_msgs/DiagnosticStatus: byte level, string name, string message, \
string hardware_id, diagnostic_msgs/KeyValue[] values
diagnostic_msgs/DiagnosticArray: std_msgs/Header header, diagnostic_msgs/DiagnosticStatus[] status
""".splitlines()
)
_CODES = {"int32": "i", "uint32": "I", "float64": "d", "uint8": "B", "byte": "B", "bool": "?"}
_POSE, _TF = "geometry_msgs/PoseWithCovarianceStamped", "tf2_msgs/TFMessage"
_TOPICS = {
    STEPS: "std_msgs/String",  # JSON
    PICTURES: "sensor_msgs/CompressedImage",
    "/camera/camera_info": "sensor_msgs/CameraInfo",
    "/pose_measured": _POSE,
    "/pose_estimated": _POSE,
    "/u": "std_msgs/Float64MultiArray",
    "/diagnostics": "diagnostic_msgs/DiagnosticArray",
    "/tf": _TF,
    "/tf_static": _TF,
}
_WARN = 1  # level of a DiagnosticStatus
_FLIPPED = (0, 0, 0), (1, 0, 0, 0)  # x stays, y and z turn round
_LATEST = 2**63 - 1  # ns

#: A message: its topic, its time (ns since 1970), its bytes.
Message = tuple[str, int, bytes]


def channels() -> Iterator[tuple[str, str, str]]:
    """Give topics, the names of their types, and the definitions of these."""
    for topic, kind in _TOPICS.items():
        yield topic, kind.replace("/", "/msg/"), _definition(kind)


@cache
def _fields(kind: str) -> list[list[str]]:
    return [one.split(" ") for one in _TYPES[kind].split(", ")]


def _definition(kind: str) -> str:
    """Return a message type with all that are in it, as a bag of ROS 2 has them."""
    kinds = [kind]
    for one in kinds:  # which grows
        named = (name.partition("[")[0] for name, _ in _fields(one))
        kinds += [name for name in named if name in _TYPES and name not in kinds]
    texts = [_TYPES[one].replace(", ", "\n") + "\n" for one in kinds]
    rest = [f"{80 * '='}\nMSG: {one}\n{text}" for one, text in zip(kinds, texts, strict=True)]
    return texts[0] + "".join(rest[1:])


def _packed(kind: str, *values: Any) -> bytes:
    """Return a message in CDR, little endian, of the values of its fields."""
    out = bytearray(b"\0\1\0\0")
    _put(out, kind, values)
    return bytes(out)


def _put(out: bytearray, kind: str, value: Any) -> None:
    base, is_array, size = kind.partition("[")
    if is_array:
        if size == "]":
            _put(out, "uint32", len(value))
        if isinstance(value, bytes):
            out += value
            return
        for one in value:
            _put(out, base, one)
    elif code := _CODES.get(kind):
        out += bytes((4 - len(out)) % struct.calcsize(code))  # the head of 4 bytes does not count
        out += struct.pack(f"<{code}", value)
    elif kind == "string":
        text = (value if isinstance(value, bytes) else value.encode(errors="replace")) + b"\0"
        _put(out, "uint32", len(text))
        out += text
    else:
        for (part, _), one in zip(_fields(kind), value, strict=True):
            _put(out, part, one)


def text_in(message: bytes) -> bytes:
    """Return the text of a `String`; struct.error: it is another message."""
    return message[8 : 7 + struct.unpack_from("<I", message, 4)[0]]


def picture_in(message: bytes) -> bytes:
    """Return the picture of a `CompressedImage`; struct.error: it is another message."""
    place = 12  # after the stamp
    for _ in range(2):  # frame_id, format
        place += 4 + struct.unpack_from("<I", message, place)[0]
        place += -place % 4
    (size,) = struct.unpack_from("<I", message, place)
    return message[place + 4 : place + 4 + size]


class Messages:
    """Makes the messages of steps; `robsim.trace.Session` describes their units and frames."""

    def __init__(self, floor: PlaneMap, mm_per_px: float | None, epoch: int) -> None:
        self._unit = 1.0 if mm_per_px is None else mm_per_px / 1000
        self._end = "_px" if mm_per_px is None else ""
        self._floor = floor
        self._epoch = epoch  # the time t = 0 (ns since 1970)

    def at(self, t: float) -> int:
        """Return a time t (s) as ns since 1970."""
        return min(max(0, self._epoch + round(1e9 * t)), _LATEST)

    def _head(self, t: float, frame: str) -> tuple[tuple[int, int], str]:
        seconds, rest = divmod(self.at(t), 10**9)
        return (min(seconds, 2**31 - 1), rest), frame  # ROS 2 counts in 32 bits

    def _area(self, name: str = "area") -> str:
        return name + self._end

    def first(self, t: float) -> Iterator[Message]:
        """Give the messages about the whole run."""
        fixed: list[Any] = [("map", "area", *_FLIPPED), ("robot", "base_link", *_FLIPPED)]
        if self._floor.intrinsics is not None:
            fixed.append(("area", "camera", *self._camera()))
        yield self._transforms("/tf_static", t, fixed)

    def of(self, row: Row) -> Iterator[Message]:
        """Give the messages of a step, except for its picture."""
        yield STEPS, self.at(row.t), _packed(_TOPICS[STEPS], json_of(row))
        if np.isfinite(row.pose_measured).all():
            yield self._pose("/pose_measured", row.t, row.pose_measured, row.covariance)
            tree = [("area", "robot", *self._place(row.pose_measured))]
            yield self._transforms("/tf", row.t, tree)
        if row.estimate is not None:
            yield self._pose("/pose_estimated", row.t, row.estimate.pose, row.estimate.covariance)
        if np.isfinite(row.u).all():
            sent = row.t if math.isnan(row.t_sent) else row.t_sent
            layout = [("voltages of the left and the right motor (V)", 2, 2)], 0
            yield "/u", self.at(sent), _packed(_TOPICS["/u"], layout, tuple(row.u))
        faults = {
            "robsim: detection": row.reason,
            "robsim: motors": "the robot was stopped before this step" if row.interrupted else "",
            "robsim: recording": row.left_out and f"the frame was omitted: {row.left_out}",
        }
        said = [(_WARN, name, text, "", ()) for name, text in faults.items() if text]
        if said:
            message = _packed(_TOPICS["/diagnostics"], self._head(row.t, ""), said)
            yield "/diagnostics", self.at(row.t), message

    def picture(self, row: Row, frame: Frame, data: bytes) -> Iterator[Message]:
        """Give the messages of a step's picture."""
        camera, lens = self._head(row.t, self._area("camera")), frame.plane_map.intrinsics
        if lens is not None:
            p = np.hstack((lens.matrix, np.zeros((3, 1))))
            matrices = (one.ravel().tolist() for one in (lens.matrix, np.eye(3), p))
            model = "plumb_bob", lens.distortion.tolist(), *matrices, 0, 0, (0, 0, 0, 0, False)
            info = _packed("sensor_msgs/CameraInfo", camera, *frame.image.shape[:2], *model)
            yield "/camera/camera_info", self.at(row.t), info
        kind = "png" if data.startswith(b"\x89PNG") else "jpeg"
        yield PICTURES, self.at(row.t), _packed(_TOPICS[PICTURES], camera, kind, data)

    def _pose(self, topic: str, t: float, pose: Any, covariance: Any) -> Message:
        spread = np.zeros((6, 6))  # ROS 2: all 0 = not known
        if covariance is not None:
            scale = np.array([self._unit, self._unit, 1.0])
            spread[np.ix_([0, 1, 5], [0, 1, 5])] = covariance * np.outer(scale, scale)
        values = self._head(t, self._area()), (self._place(pose), spread.ravel().tolist())
        return topic, self.at(t), _packed(_POSE, *values)

    def _place(self, pose: Any) -> tuple[tuple[float, float, float], tuple[float, ...]]:
        """Return the place and the quaternion of a pose."""
        x, y, heading = pose
        turn = 0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2)
        return (x * self._unit, y * self._unit, 0.0), turn

    def _transforms(self, topic: str, t: float, tree: list[tuple[str, str, Any, Any]]) -> Message:
        values = [
            (self._head(t, self._area(parent)), self._area(child), (place, turn))
            for parent, child, place, turn in tree
        ]
        return topic, self.at(t), _packed(_TF, values)

    def _camera(self) -> tuple[list[float], list[float]]:
        """Return the place of the camera in the area, and its rotation.

        The floor's homography to ideal pixels is K [r1 r2 t], times a number: see
        `PlaneMap.at_height`.
        """
        from scipy.spatial.transform import Rotation  # takes 0.1 s

        assert self._floor.intrinsics is not None
        lens = self._floor.intrinsics.matrix
        pose = np.linalg.inv(self._floor.matrix @ lens)
        pose *= 2 / (np.linalg.norm(pose[:, 0]) + np.linalg.norm(pose[:, 1]))
        pose *= np.sign((self._floor.matrix @ lens)[2, 2])  # the floor lies before the camera
        turn = np.column_stack((pose[:, 0], pose[:, 1], np.cross(pose[:, 0], pose[:, 1])))
        to_area = Rotation.from_matrix(turn).inv()
        return (-self._unit * to_area.apply(pose[:, 2])).tolist(), to_area.as_quat().tolist()
