"""The search for cameras: found cameras, missing parts, and reasons."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from robsim.base.checks import check_bool
from robsim.base.report import Report
from robsim.base.text import cut, one_line
from robsim.lab.cameras._devices import firewire, gige
from robsim.lab.cameras._devices.opencv import back_end_of_system, back_ends, no_permission
from robsim.lab.cameras.errors import CaptureError, NoBackEndError
from robsim.vision.imaging.video import load_opencv


@dataclass(frozen=True, kw_only=True)
class CameraReport(Report):
    """The cameras of this computer.

    Attributes
    ----------
    found : tuple of str
        Available cameras and readers, each with its argument for `Camera`.
    missing : tuple of str
        Unavailable cameras and readers, with reason and remedy.

    Examples
    --------
    >>> report = robsim.lab.find_cameras()
    >>> 'a file played at its own rate: robsim.Camera("run.mkv")' in report.found
    True
    """

    found: tuple[str, ...]
    missing: tuple[str, ...]

    @property
    def title(self) -> str:
        """The subject of the report."""
        return "Cameras"

    @property
    def verdict(self) -> str:
        """The number of cameras that were found, in a word or two."""
        count = sum(line.startswith("camera ") for line in self.found)
        return f"{count} found" if count else "none found"

    @property
    def remarks(self) -> tuple[str, ...]:
        """A sentence for each camera that was found, then one for each missing camera."""
        return (*self.found, *self.missing)


def find_cameras(*, network: bool = False) -> CameraReport:
    """Return the available cameras, and the reasons for missing ones, without opening any camera.

    Parameters
    ----------
    network : bool
        Whether to search the networks of this computer for GigE Vision cameras, too, which takes
        1 s.

    Raises
    ------
    TypeError
        If `network` is not a bool.

    Examples
    --------
    >>> robsim.lab.find_cameras().found[-1]
    'a file played at its own rate: robsim.Camera("run.mkv")'
    """
    on_gige = _gige(check_bool("network", network))
    found: list[str] = []
    missing: list[str] = []
    for is_there, sentence in (*_opencv(), *_video_nodes(), *_fire_wire(), *on_gige, *_always()):
        (found if is_there else missing).append(sentence)
    return CameraReport(found=tuple(found), missing=tuple(missing))


def _opencv() -> Iterator[tuple[bool, str]]:
    try:
        cv2 = load_opencv("a camera by number or RTSP")
    except ImportError as error:
        yield False, str(error)
        return
    there = back_ends(cv2)
    yield True, f"OpenCV {cut(cv2.__version__)} with {', '.join(there) or 'no back end'}"
    if back_end_of_system() not in there:
        yield (
            False,
            f"this OpenCV has no {back_end_of_system()}, which reads cameras by number: install "
            "opencv-python-headless",
        )
    if "ffmpeg" not in there:
        yield False, "this OpenCV has no ffmpeg, which reads RTSP: install opencv-python-headless"


def _video_nodes() -> Iterator[tuple[bool, str]]:
    if back_end_of_system() != "v4l2":
        yield True, "cameras by number, which are not listed here: try robsim.Camera(0)"
        return
    nodes = [node for node in glob.glob("/dev/video*") if re.fullmatch(r"/dev/video\d+", node)]
    nodes.sort(key=_number)
    if not nodes:
        yield (
            False,
            "cameras by number: there is no /dev/video*; plug one in (to a container or a virtual "
            "machine it must be passed on)",
        )
    for node in nodes:
        if os.access(node, os.R_OK | os.W_OK):
            number = _number(node)
            yield True, f"camera {number}: {node}{_name_of(node)}: robsim.Camera({number})"
        else:
            yield False, no_permission(node)


def _number(node: str) -> int:
    return int(node.removeprefix("/dev/video"))


def _name_of(node: str) -> str:
    try:
        name = Path("/sys/class/video4linux", Path(node).name, "name").read_text(errors="replace")
    except OSError:
        return ""
    return f" ({one_line(name.strip())})"


def _fire_wire() -> Iterator[tuple[bool, str]]:
    try:
        extension = firewire.EXTENSION.load()
    except NoBackEndError as error:
        yield False, f"cameras on FireWire: {error}"
        return
    readable, denied = extension.nodes()
    for node in denied:
        yield False, no_permission(node)
    try:
        cameras = extension.cameras()
    except CaptureError as error:
        yield False, f"cameras on FireWire: {error}"
        return
    if not cameras and not readable and not denied:  # the library reads some on USB, too
        yield False, "cameras on FireWire: this computer has no FireWire bus (/dev/fw0)"
    for number, (guid, vendor, model) in enumerate(cameras):
        name = one_line(f"{vendor} {model}")
        yield True, f'camera on FireWire: {name}, {guid}: robsim.Camera("firewire://{number}")'


def _gige(is_network_searched: bool) -> Iterator[tuple[bool, str]]:
    try:
        extension = gige.EXTENSION.load()
    except NoBackEndError as error:
        yield False, f"cameras on GigE: {error}"
        return
    by_address = 'by its address, serial number or name: robsim.Camera("gige://ADDRESS")'
    cameras = extension.find_cameras() if is_network_searched else []
    for one in cameras:
        url = f"gige://{one['address']}"
        name = one_line(f"{one['vendor']} {one['model']} {one['serial']}")
        yield True, f'camera on GigE: {name}: robsim.Camera("{url}")'
    if is_network_searched and not cameras:
        yield (
            False,
            "cameras on GigE: none answers on the networks of this computer within 1 s; one "
            f"elsewhere opens {by_address}",
        )
    elif not cameras:
        yield True, f"GigE Vision, {by_address}"
    largest = gige.largest_receive_buffer()
    if largest is not None and largest < gige.ENOUGH_RECEIVE_BUFFER:
        yield (
            False,
            f"room for large frames from GigE: this system keeps {largest} bytes of what arrives, "
            "and frames of more may be torn; sudo sysctl -w "
            f"net.core.rmem_max={8 * gige.ENOUGH_RECEIVE_BUFFER}",
        )


def _always() -> Iterator[tuple[bool, str]]:
    yield True, 'MJPEG over HTTP: robsim.Camera("http://HOST:PORT/PATH")'
    yield True, 'a file played at its own rate: robsim.Camera("run.mkv")'
