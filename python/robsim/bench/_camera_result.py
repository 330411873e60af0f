"""The table of what a live camera's frames take."""

from __future__ import annotations

from dataclasses import dataclass

from robsim._base.report import Column, Quantity, Report, Row, Table, percent
from robsim.bench._cases import Case

RATE = 30  # frames/s


@dataclass(frozen=True, kw_only=True)
class Path:
    """What the frames of a camera take that sends pixels in one way.

    Attributes
    ----------
    format : str
        How it sends pixels, such as ``"yuv422"``.
    size : (int, int)
        Width and height of the frames (px).
    to_rgb : Case
        From the bytes to RGB (ms).
    to_pose : Case or None
        From the bytes to the robot's pose (ms); OpenCV's ends with the blobs. None if the pixels
        have no colours.
    """

    format: str
    size: tuple[int, int]
    to_rgb: Case
    to_pose: Case | None = None

    @property
    def row(self) -> Row:
        """Its row in the table."""
        values: list[float | None] = []
        for case in (self.to_rgb, self.to_pose):
            theirs = None if case is None else case.others["opencv"]
            ours = None if case is None else case.ours
            values += [ours, theirs, theirs / ours if ours and theirs else None]
        share = None if self.to_pose is None else RATE * self.to_pose.ours / 1e3
        return Row(f"{self.format}_{self.size[0]}x{self.size[1]}", [*values, share], unit="ms")


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
    """

    cpu_path: str
    paths: tuple[Path, ...]

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
        """A row for each way to send pixels and each size."""
        columns = []
        for key, title in (("to_rgb", "to RGB"), ("to_pose", "to pose")):
            columns += [
                Column(key, title, None, _three_digits, missing=""),
                Column(f"{key}_opencv", "OpenCV", None, _three_digits, missing=""),
                Column(f"{key}_ratio", "x", "", ".1f", missing=""),
            ]
        columns.append(Column("core", f"core at {RATE}/s", "", percent, missing=""))
        rows = [path.row for path in self.paths]
        return (Table(key="paths", columns=columns, rows=rows, row_title="pixels"),)

    @property
    def remarks(self) -> tuple[str, ...]:
        """How to read the columns."""
        return (
            "x: how many times as long as robsim; OpenCV in one thread, and to the blobs alone",
            f"core at {RATE}/s: robsim's share of one processor core at {RATE} frames a second",
            "yuv411: OpenCV does not know a camera's order, so numpy sorts the bytes first",
            "mono8 shows no colours, so there are no markers to find",
        )
