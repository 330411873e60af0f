"""The benchmark of a live camera's frames: from the bytes that it sends to the robot's pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench_camera.result import CameraBench, Path
from robsim._core import Frame, Measurement, cpu_path, find_blobs, locate, to_rgb
from robsim.base.checks import check_int
from robsim.cli.simulated.bench import Call, check_same_blobs, opencv_finder, timed
from robsim.simulation.simulation import Simulation
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise
from robsim.vision.imaging.video import load_opencv
from sent_pixels import from_rgb

SIZES = ((1280, 960), (640, 480))
FORMATS = ("yuv422", "yuv411", "mono8", "bayer_rggb", "rgb8")
NOISE_PERCENT = 1.0
BUFFERS = 4  # of a camera: the next frame is never the one that the cache still holds


def run_camera_bench(
    *, rounds: int = 25, sizes: tuple[tuple[int, int], ...] = SIZES
) -> CameraBench:
    """Time a frame's way from the bytes of a camera to RGB and to the robot's pose.

    Parameters
    ----------
    rounds : int
        Number of timed rounds of each case; the result is the median.
    sizes : tuple of (int, int)
        Widths and heights of the frames (px).

    Returns
    -------
    CameraBench
        The times; print it.

    Raises
    ------
    ImportError
        If OpenCV is not installed.
    RuntimeError
        If OpenCV finds other blobs.
    """
    check_int("rounds", rounds, minimum=1, maximum=10**6)
    cv2 = load_opencv("the comparison")
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        paths = [
            _path(cv2, simulation, format_, rounds)
            for simulation in map(_simulation, sizes)
            for format_ in FORMATS
        ]
    finally:
        cv2.setNumThreads(threads)
    return CameraBench(cpu_path=cpu_path(), paths=tuple(paths))


def _simulation(size: tuple[int, int]) -> Simulation:
    """Return a simulated lab whose camera has this size, after its first frame."""
    width, height = size
    simulation = Simulation(
        robot="lab",
        area=(1200, 1200 * height // width),
        resolution=size,
        headings=None,
        noise=GaussianNoise(NOISE_PERCENT),
        start=(450, 600, 0.5),
        measure=True,
        seed=1,
    )
    simulation.step()
    return simulation


@dataclass
class _Buffers:
    """The frames of a camera in its memory, one after the other.

    Attributes
    ----------
    frames : list of array (N,) of uint8
        The bytes of each.
    """

    frames: list[Pixels]
    taken: int = 0

    def next(self) -> Pixels:
        """Return the bytes of the next frame."""
        self.taken += 1
        return self.frames[self.taken % len(self.frames)]


def _path(cv2: Any, simulation: Simulation, format_: str, rounds: int) -> Path:
    image = simulation.frame.image
    sent = np.frombuffer(from_rgb(image, format_), np.uint8)
    buffers = _Buffers([sent.copy() for _ in range(BUFFERS)])
    height, width, _ = image.shape
    theirs = np.empty_like(image)
    convert = opencv_conversion(cv2, format_, theirs)
    to_image = timed(
        {
            "ours": lambda: to_rgb(buffers.next(), width, height, format_),
            "opencv": lambda: convert(buffers.next()),
        },
        rounds,
    )
    if format_ == "mono8":  # it shows no colours: there is nothing to find
        return Path(format=format_, size=(width, height), to_rgb=to_image)
    calls = _measure_calls(cv2, simulation, format_, buffers, convert, theirs)
    return Path(
        format=format_,
        size=(width, height),
        to_rgb=to_image,
        to_pose=timed(calls, rounds),
    )


def _measure_calls(
    cv2: Any,
    simulation: Simulation,
    format_: str,
    buffers: _Buffers,
    convert: Callable[[Pixels], Any],
    theirs: Pixels,
) -> dict[str, Call]:
    """Return the calls that find the robot in the next frame: OpenCV's its blobs alone."""
    plane_map, colors = simulation.frame.plane_map, simulation.colors
    markers = simulation.markers
    height, width, _ = theirs.shape
    finder = opencv_finder(cv2, theirs, colors, simulation._core.smoothing)

    def blobs() -> dict[str, Any]:
        image = to_rgb(buffers.next(), width, height, format_)
        frame = Frame(image, copy=False, plane_map=plane_map)
        return find_blobs(frame, colors, markers=markers)

    def ours() -> Measurement | None:
        return locate(blobs(), markers, plane_map)

    def opencv() -> Any:
        convert(buffers.next())
        return finder()

    check_same_blobs(blobs(), opencv())
    if ours() is None:
        raise RuntimeError(f"robsim must find the robot in a frame in {format_}")
    return {"ours": ours, "opencv": opencv}


def opencv_conversion(cv2: Any, format_: str, rgb: Pixels) -> Callable[[Pixels], Any]:
    """Return what one would take instead: it writes a camera's bytes to an image as RGB.

    OpenCV reads YUV 4:2:2 as that of television, 16 .. 235, and has no 4:1:1 of this order: numpy
    sorts its bytes first. Of RGB the bytes are copied.

    Parameters
    ----------
    cv2 : module
        OpenCV.
    format_ : str
        How the camera sends pixels.
    rgb : array (H, W, 3) of uint8
        Where to write to.
    """
    height, width, _ = rgb.shape

    def as_packed(code: int, *shape: int) -> Callable[[Pixels], Any]:
        return lambda raw: cv2.cvtColor(raw.reshape(shape), code, rgb)

    def yuv411(raw: Pixels) -> None:
        units = raw.reshape(height, width // 4, 6)  # U Y Y V Y Y
        sorted_ = np.empty((height, width // 4, 4, 3), np.uint8)
        sorted_[..., 0] = units[..., (1, 2, 4, 5)]
        sorted_[..., 1] = units[..., 3:4]
        sorted_[..., 2] = units[..., 0:1]
        cv2.cvtColor(sorted_.reshape(rgb.shape), cv2.COLOR_YCrCb2RGB, rgb)

    return {
        "yuv422": as_packed(cv2.COLOR_YUV2RGB_UYVY, height, width, 2),
        "yuv411": yuv411,
        "mono8": as_packed(cv2.COLOR_GRAY2RGB, height, width),
        # OpenCV names a filter by its second row: BG is R G over G B.
        "bayer_rggb": as_packed(cv2.COLOR_BayerBG2RGB, height, width),
        "rgb8": lambda raw: np.copyto(rgb, raw.reshape(rgb.shape)),
    }[format_]
