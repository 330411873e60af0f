"""`check_camera`: a check of a camera for driving a robot."""

from __future__ import annotations

import time
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

from robsim._core import Blob, ColorClass, Frame, Measurement, MotorLink
from robsim.base.checks import check_float
from robsim.base.report import Column, Problem, Report, Row, Table
from robsim.base.text import quoted
from robsim.lab.cameras.camera import Camera
from robsim.lab.cameras.errors import EndOfStream, FrameTimeoutError
from robsim.lab.rehearsal._camera_look import CameraLook
from robsim.lab.rehearsal.camera_findings import (
    NOT_KNOWN,
    VERDICTS,
    CameraFinding,
    findings_of,
    rank,
    three_digits,
)
from robsim.simulation.options import OPTIONS, check_marker_colors, colors_value
from robsim.vision.robots.definition import RobotDefinition
from robsim.vision.robots.lookup import as_robot


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraCheck(Report):
    """The quality of a camera: the result of `check_camera`.

    Attributes
    ----------
    findings : tuple of CameraFinding
        The findings: ``check["frame rate"].value``.
    frames, seen : int
        Number of received frames, and of frames with a detected robot.
    frame : Frame
        The last frame, or the last frame with a detected robot.
    blobs : dict of str to list of Blob
        Its blobs.
    measurement : Measurement or None
        The measured pose in it.
    robot : RobotDefinition
        The robot to detect.
    remarks : tuple of str
        Findings that could not be judged, with reasons.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     check = robsim.lab.check_camera(camera, robot="lab", seconds=0.5)
    >>> check.seen > 0, check.robot.name
    (True, 'lab')
    """

    findings: tuple[CameraFinding, ...]
    frames: int
    seen: int
    frame: Frame = field(repr=False)
    blobs: Mapping[str, Sequence[Blob]] = field(repr=False)
    measurement: Measurement | None
    robot: RobotDefinition = field(repr=False)
    remarks: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> CameraFinding:
        for finding in self.findings:
            if finding.name == name:
                return finding
        known = ", ".join(finding.name for finding in self.findings)
        raise KeyError(f"unknown finding {quoted(name)}; available: {known}")

    @property
    def title(self) -> str:
        """Name of the check."""
        return "Check of the camera"

    @property
    def verdict(self) -> str:
        """The worst verdict of all findings: ``"good"``, ``"poor"`` or ``"bad"``."""
        return VERDICTS[max(rank(finding) for finding in self.findings)]

    @property
    def ok(self) -> bool:
        """Whether nothing is bad."""
        return self.verdict != "bad"

    @property
    def tables(self) -> tuple[Table, ...]:
        """All findings."""
        rows = [Row(one.name, (one.value, one.verdict), one.unit) for one in self.findings]
        columns = (
            Column("value", "value", format=three_digits),
            Column("verdict", "verdict", unit=""),
        )
        return (Table(key="findings", columns=columns, rows=rows, row_title="of the frames"),)

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Poor and bad findings, worst first, with remedies."""
        ranked = sorted(self.findings, key=rank, reverse=True)
        return tuple(
            Problem(kind=one.name, sentence=f"{one}: {one.remedy}") for one in ranked if rank(one)
        )


def check_camera(
    camera: Camera,
    *,
    robot: str | PathLike[str] | RobotDefinition | None = None,
    colors: str | PathLike[str] | Iterable[ColorClass] | None = None,
    smoothing: int | None = None,
    motors: MotorLink | None = None,
    seconds: float = 3.0,
) -> CameraCheck:
    """Observe a camera for some seconds, and judge whether it can guide a robot.

    The robot may stand anywhere in the picture, and does not move: `motors` receive only a stop.

    Parameters
    ----------
    camera : Camera
        The camera, or a file under playback.
    robot, colors, smoothing
        As in `robsim.Experiment`.
    motors : UdpMotors or SerialMotors, optional
        The link to the robot, for its response time.
    seconds : float
        Duration (s).

    Returns
    -------
    CameraCheck
        The report covers the rate, jitter, losses, exposure and latency of the frames, and the
        size, contrast and colours of the markers. It gives the markers' signal-to-noise ratio (see
        `Measurement`), and the noise as the standard deviation of a channel in grey levels. The
        noise is missing if compression smooths it. The report also gives the share of frames with a
        detected robot, and the scatter of its pose. The calibration is checked against the robot
        and its floor sheets. Each finding has a verdict and a remedy.

    Raises
    ------
    robsim.lab.CaptureError
        If the camera fails, or sends no frame in this time.
    robsim.lab.LineError
        If the line to the robot fails.
    TypeError, ValueError
        If an argument has the wrong type or is out of range, or `colors` lack a marker's colour.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     check = robsim.lab.check_camera(camera, robot="lab", seconds=0.5)
    >>> print(check)
    Check of the camera: ...
      of the frames                      value   verdict
      ----------------------------------------------------
      frame rate (1/s) ...
    """
    if not isinstance(camera, Camera):
        raise TypeError(f"camera must be a robsim.Camera, got {quoted(camera)}")
    if not (motors is None or isinstance(motors, MotorLink)):
        raise TypeError(f"motors must be UdpMotors or SerialMotors, got {quoted(motors)}")
    seconds = check_float("seconds", seconds, "s", exclusive_minimum=0, maximum=3600)
    smoothing = OPTIONS["smoothing"].checked(smoothing)
    definition = as_robot(robot)
    classes = colors_value(colors)
    check_marker_colors(definition.marker_layout(), classes, "the check")
    look = CameraLook(definition, classes, smoothing)
    before = camera.counts
    if motors is not None:
        motors.stop()
    for frame in _frames_of(camera, seconds):
        look.at(frame)
    if not look.detections:
        raise FrameTimeoutError(f"no frame came within {seconds:g} s: there is nothing to check")
    findings = tuple(findings_of(look, camera, before, motors))
    frame, blobs, detection = look.shown
    return CameraCheck(
        findings=findings,
        frames=len(look.detections),
        seen=look.seen,
        frame=frame,
        blobs=blobs,
        measurement=detection.measurement,
        robot=definition,
        remarks=tuple(_remarks(findings, motors, [*look.markers.colors.values()])),
    )


def _frames_of(camera: Camera, seconds: float) -> Iterator[Frame]:
    """Yield the frames of some seconds, or until a file ends."""
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        try:
            yield camera.read(left)
        except EndOfStream:
            return
        except FrameTimeoutError:
            continue


def _remarks(
    findings: Iterable[CameraFinding], motors: Any, colors: Iterable[str]
) -> Iterator[str]:
    names = [finding.name for finding in findings if finding.verdict == NOT_KNOWN]
    if "exposure to arrival" in names:
        yield "the camera gives no exposure times: frame times are estimates, the latency unknown"
    if "round trip to the robot" in names:
        yield "the robot did not answer: is it on? Answers are optional, see PROTOCOL.md"
    if all(f"margin of {color}" in names for color in colors):
        yield "the markers cannot be judged if the robot is not detected"
    yield from _remarks_on_calibration({finding.name for finding in findings}, names)
    if motors is not None:
        yield "the robot only received a stop"


def _remarks_on_calibration(looked_at: Container[str], not_known: Container[str]) -> Iterator[str]:
    sheets, places = "shift of floor sheets", "markers' distance, by place"
    if "work area in the picture" not in looked_at or places not in not_known:
        return
    said = (
        "the calibration was tried in one place: a camera that was moved sideways, or tilted by "
        "some degrees, may show only with the robot elsewhere"
    )
    if sheets not in looked_at:
        yield f"{said}; a floor sheet that stays in place after the calibration would reveal this"
    elif sheets in not_known:
        yield (
            f"{said}, as no floor sheet is in the picture that the calibration saw (or OpenCV is "
            'not installed: pip install "robsim[camera]")'
        )
