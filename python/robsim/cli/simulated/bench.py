"""The command ``robsim bench``: timings of robsim, OpenCV and numpy."""

from __future__ import annotations

import itertools
import math
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robsim._core import (
    Blob,
    ColorClass,
    DriveAround,
    Renderer,
    RobotModel,
    Step,
    cpu_path,
    find_blobs,
)
from robsim.base.checks import Floats, check_int
from robsim.base.report import Column, Quantity, Report, Row, Table
from robsim.cli import errors
from robsim.cli.shared import Json
from robsim.simulation import Simulation
from robsim.simulation.world.scene import make_scene, robot_sprite
from robsim.vision.imaging.images import Pixels
from robsim.vision.imaging.noise import GaussianNoise
from robsim.vision.imaging.video import load_opencv
from robsim.vision.robots.lookup import load_robot

_ROUNDS = 25


def bench(rounds: int = _ROUNDS, as_json: Json = False) -> None:
    """Measure how fast robsim is on this machine.

    The alternatives, OpenCV and numpy, are timed in the same run on the same frames. OpenCV must be
    installed.

    --rounds N: Number of timings of each case; the median is reported.

    Example: robsim bench
    """
    result = run_bench(rounds=rounds)
    errors.show(result.to_json() if as_json else result)


Call = Callable[[], Any]
Found = dict[str, Floats]  # by colour: area, u, v of the centroid of each blob (N, 3)
AREA = (1200, 1200)  # px
MAXIMUM_DIFFERENCE = 16  # grey levels: OpenCV samples an image at multiples of 1/32 px
NOISE = GaussianNoise(40)
_SIGMA = 2.55 * NOISE.percent  # grey levels
_LEAST = 12, 5  # px of a blob, points of the outline of such a one
_START = (600.0, 600.0, 0.0)
# The robot moves from frame to frame, without a shadow, which OpenCV's functions do not draw.
_POSES = [(300 + 2.3 * k, 700 - 1.7 * k, 0.5 + 0.11 * k) for k in range(100)]
_OTHERS = {"opencv": "OpenCV", "numpy": "numpy"}
_UNITS = {"ms": 1e3, "us": 1e6}  # per second


@dataclass(frozen=True, kw_only=True)
class BenchTable(Report):
    """The timings; print it."""

    title: str = "Median times in one thread"
    quantities: tuple[Quantity, ...] = ()
    tables: tuple[Table, ...] = ()
    remarks: tuple[str, ...] = (
        "x: time relative to robsim. 1200, 480: frames of so many px squared",
        "step_gaussian: draw the robot, add 40 % of noise, find the markers",
        "step_tracked, step_unseen: steps with frames of 1200 px, and without frames; "
        "step_controller: without frames, with a controller in Python",
    )


def _table(rows: Sequence[Row]) -> Table:
    columns = [Column("ours", "robsim", format=_three_digits)]
    for other, name in _OTHERS.items():
        columns.append(Column(other, name, format=_three_digits, missing=""))
        columns.append(Column(f"{other}_ratio", "x", unit="", format=".1f", missing=""))
    return Table(key="cases", columns=columns, rows=rows, row_title="task")


def _three_digits(value: float) -> str:
    return f"{value:.3g}" if value < 999 else f"{value:,.0f}"


def timed(calls: Mapping[str, Call], rounds: int) -> dict[str, float]:
    """Time calls in turns; return the median of each (s)."""
    times: dict[str, list[float]] = {who: [] for who in calls}
    for round_ in range(rounds + 2):  # two to warm up
        for who, call in calls.items():
            start = time.perf_counter()
            call()
            if round_ >= 2:
                times[who].append(time.perf_counter() - start)
    return {who: statistics.median(values) for who, values in times.items()}


def _row(
    name: str, calls: Mapping[str, Call], rounds: int, *, unit: str = "ms", repeats: int = 1
) -> Row:
    """Return the time of a task that each call repeats, and the others' relative times."""
    times = {who: _UNITS[unit] * each / repeats for who, each in timed(calls, rounds).items()}
    numbers: list[float | None] = [times["ours"]]
    for theirs in map(times.get, _OTHERS):
        numbers += [theirs, theirs and theirs / times["ours"]]
    return Row(name, numbers, unit=unit)


def run_bench(
    *, rounds: int = 25, sizes: Sequence[int] = (1200, 480), frames: int = 100, steps: int = 5000
) -> BenchTable:
    """Time robsim, OpenCV and numpy: frames of some sizes (px), runs of so many frames or steps.

    ImportError: OpenCV is not installed. RuntimeError: their results differ.
    """
    check_int("rounds", rounds, minimum=1, maximum=10**6)
    cv2 = load_opencv("the comparison")
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        rows = [row for size in sizes for row in _frame_rows(cv2, size, rounds)]
    finally:
        cv2.setNumThreads(threads)
    tracked = Simulation(robot="lab", measure=True, seed=1)
    called = Simulation(robot="lab", boundary="unlimited", control=_controller, seed=1)
    for name, calls, n in (
        ("step_tracked", {"ours": _again(tracked, frames)}, frames),
        ("step_unseen", unseen_calls(steps), steps),
        ("step_controller", {"ours": _again(called, steps)}, steps),
    ):
        rows.append(_row(name, calls, rounds, unit="us", repeats=n))
    instructions = Quantity("cpu_path", "vector instructions", cpu_path())
    return BenchTable(quantities=(instructions,), tables=(_table(rows),))


def _frame_rows(cv2: Any, size: int, rounds: int) -> Iterator[Row]:
    clean, noisy = seen_robot(size), seen_robot(size, NOISE)
    draw = render_calls(cv2, size)
    yield _row(f"detect_clean_{size}", detect_calls(cv2, clean), rounds)
    yield _row(f"detect_gaussian_{size}", detect_calls(cv2, noisy), rounds)
    yield _row(f"noise_gaussian_{size}", _noise_calls(cv2, clean.frame.image.copy()), rounds)
    yield _row(f"render_{size}", draw, 10 * rounds)
    yield _row(f"step_gaussian_{size}", _noisy_calls(cv2, noisy, draw), rounds)


def seen_robot(size: int, noise: GaussianNoise | None = None) -> Simulation:
    """Return a simulation whose camera has just seen the robot, with smoothing for noise."""
    simulation = Simulation(
        robot="lab",
        resolution=(size, size),
        headings=None,
        noise=noise,
        start=(450, 700, 0.5),
        measure=True,
        smoothing=None if noise else 1,
        seed=1,
    )
    simulation.step()
    return simulation


def detect_calls(cv2: Any, simulation: Simulation) -> dict[str, Call]:
    """Return the calls that find the blobs of a frame, after a check that both find the same."""
    pixels, core = simulation.frame.image.copy(), simulation._core
    ours = _our_finder(pixels, simulation)
    theirs = opencv_finder(cv2, pixels, simulation.colors, core.smoothing)
    check_same_blobs(ours(), theirs())
    return {"ours": ours, "opencv": theirs}


def _our_finder(pixels: Pixels, simulation: Simulation) -> Callable[[], dict[str, list[Blob]]]:
    area, smoothing = simulation._core.minimum_area, simulation._core.smoothing
    colors = simulation.colors
    return lambda: find_blobs(pixels, colors, minimum_area=area, smoothing=smoothing)


def opencv_finder(
    cv2: Any, pixels: Pixels, colors: Sequence[ColorClass], window: int
) -> Callable[[], Found]:
    """Return a function that blurs an image, and finds its blobs by OpenCV's contours."""
    limits = {color.name: opencv_limits(color) for color in colors}

    def find() -> Found:
        smooth = pixels if window == 1 else cv2.blur(pixels, (window, window))
        converted = cv2.cvtColor(smooth, cv2.COLOR_RGB2YCrCb)
        return {name: _contours(cv2, cv2.inRange(converted, *limits[name])) for name in limits}

    return find


def opencv_limits(color: ColorClass) -> tuple[Pixels, Pixels]:
    """Return the limits in OpenCV's order: Y, Cr, Cb."""
    lower, upper = zip(color.y, color.v, color.u, strict=True)
    return np.array(lower, np.uint8), np.array(upper, np.uint8)


def _contours(cv2: Any, mask: Any) -> Floats:
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    moments = [cv2.moments(outline) for outline in outlines if len(outline) >= _LEAST[1]]
    large = [(m["m00"], m["m10"], m["m01"]) for m in moments if m["m00"] >= _LEAST[0]]
    return np.array([(area, u / area, v / area) for area, u, v in large], float).reshape(-1, 3)


def check_same_blobs(ours: Mapping[str, Sequence[Blob]], theirs: Found) -> None:
    """Raise RuntimeError unless the others find the largest blob of each colour, too."""
    for color, blobs in ours.items():
        u, v = max(blobs, key=lambda blob: blob.area).centroid
        distances = np.hypot(theirs[color][:, 1] - u, theirs[color][:, 2] - v)
        if distances.min(initial=np.inf) > 2:
            raise RuntimeError(f"OpenCV must find the {color} blob at ({u:.1f}, {v:.1f}), too")


def _opencv_noise(cv2: Any, pixels: Pixels) -> Callable[[Pixels], Pixels]:
    """Return a function that writes an image with Gaussian noise to some pixels."""
    values = np.empty(pixels.shape, np.int16)

    def noisy(clean: Pixels) -> Pixels:
        cv2.randn(values, 0, _SIGMA)
        cv2.add(clean, values, pixels, dtype=cv2.CV_8U)
        return pixels

    return noisy


def _noise_calls(cv2: Any, clean: Pixels) -> dict[str, Call]:
    """Return the calls that add Gaussian noise to an image."""
    ours, rng = np.empty_like(clean), np.random.default_rng(1)
    opencv = _opencv_noise(cv2, np.empty_like(clean))

    def numpy() -> Pixels:
        noisy = np.float32(_SIGMA) * rng.standard_normal(clean.shape, dtype=np.float32) + clean
        return np.clip(np.rint(noisy, out=noisy), 0, 255, out=noisy).astype(np.uint8)

    return {
        "ours": lambda: NOISE.add(clean, 1, 1, out=ours),
        "opencv": lambda: opencv(clean),
        "numpy": numpy,
    }


def render_calls(cv2: Any, size: int) -> dict[str, Callable[[], Pixels]]:
    """Return the calls that draw the robot at its next pose, after a check that they look alike."""
    scene = make_scene(
        robot=load_robot("lab"),
        area=AREA,
        resolution=(size, size),
        headings=0,
        background=None,
        adjust_background=lambda background: background,
    )
    renderer = Renderer(scene)
    theirs = _opencv_renderer(cv2, renderer, size / AREA[0])
    for pose in _POSES[::10]:
        difference = np.abs(renderer.render(pose).astype(int) - theirs(pose)).max()
        if difference > MAXIMUM_DIFFERENCE:
            raise RuntimeError(
                f"robsim and OpenCV must draw the same robot at {pose}, got differences of up to "
                f"{difference} grey levels"
            )
    our_poses, their_poses = itertools.cycle(_POSES), itertools.cycle(_POSES)
    return {
        "ours": lambda: renderer.render(next(our_poses)),
        "opencv": lambda: theirs(next(their_poses)),
    }


def _opencv_renderer(cv2: Any, renderer: Renderer, scale: float) -> Callable[..., Pixels]:
    """Return a function that copies the background, rotates the robot's image and blends it in."""
    robot = load_robot("lab")
    background = renderer.render((-1e4, -1e4, 0.0)).copy()
    frame = np.empty_like(background)
    image, centre, _ = robot_sprite(robot, scale)
    alpha = image[:, :, 3:]
    image = np.rint(np.dstack((image[:, :, :3] * (alpha / 255), alpha))).astype(np.uint8)
    half = math.ceil(math.hypot(*image.shape[:2]) / 2) + 1
    side = 2 * half + 1

    def render(pose: tuple[float, float, float]) -> Pixels:
        cv2.copyTo(background, None, frame)
        u, v = ((x + 0.5) * scale - 0.5 for x in pose[:2])
        left, top = round(u) - half, round(v) - half
        angle = pose[2] + math.radians(robot.alignment)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        matrix = np.column_stack((turn, np.array((u - left, v - top)) - turn @ centre))
        rotated = cv2.warpAffine(image, matrix, (side, side), flags=cv2.INTER_LINEAR)
        shown = cv2.bitwise_not(cv2.extractChannel(rotated, 3))
        part = frame[top : top + side, left : left + side]
        cv2.multiply(part, cv2.cvtColor(shown, cv2.COLOR_GRAY2RGB), part, scale=1 / 255)
        cv2.add(part, cv2.cvtColor(rotated, cv2.COLOR_RGBA2RGB), part)
        return frame

    return render


def _noisy_calls(cv2: Any, simulation: Simulation, draw: Mapping[str, Call]) -> dict[str, Call]:
    """Return the calls that draw the robot at its next pose, add noise and find its markers."""
    ours, theirs = (np.empty_like(simulation.frame.image) for _ in range(2))
    noisy, numbers = _opencv_noise(cv2, theirs), itertools.count()
    find = _our_finder(ours, simulation)
    opencv_find = opencv_finder(cv2, theirs, simulation.colors, simulation._core.smoothing)

    def step() -> Any:
        NOISE.add(draw["ours"](), 1, next(numbers), out=ours)
        return find()

    def opencv() -> Any:
        noisy(draw["opencv"]())
        return opencv_find()

    return {"ours": step, "opencv": opencv}


def _again(simulation: Simulation, steps: int) -> Call:
    """Return the call that reruns a simulation."""

    def run() -> None:
        simulation.reset()
        simulation.run(steps)

    return run


def _controller(step: Step) -> tuple[float, float]:
    return (1.0, 0.2) if step.k % 20 < 10 else (0.2, 1.0)


def unseen_calls(steps: int) -> dict[str, Call]:
    """Return the calls that run without frames, after a check that their paths agree."""
    simulation = Simulation(
        robot="lab", control=DriveAround(), boundary="unlimited", start=_START, seed=1
    )
    trace = simulation.run(steps)
    if not np.allclose(_numpy_path(trace.u[:100]), trace.pose_true[:100], atol=1e-6):
        raise RuntimeError("the path of the robot must be the same in robsim and numpy")
    return {"ours": _again(simulation, steps), "numpy": lambda: _numpy_path(trace.u)}


def _numpy_path(u: Floats) -> Floats:
    """Return the path of the default robot for inputs (N, 2), step by step."""
    a1, a2, b1, b2, d1 = RobotModel().theta.T
    path = np.empty((len(u), 3))
    path[0] = pose_2 = pose_1 = np.array(_START)
    for k in range(1, len(u)):
        direction = np.array([np.cos(pose_1[2]), np.sin(pose_1[2]), 1.0])
        # pose(k) = a1 pose(k-1) + a2 pose(k-2) + (b1 u1 + b2 u2 + d1) (cos, sin, 1)
        pose = a1 * pose_1 + a2 * pose_2 + (b1 * u[k - 1, 0] + b2 * u[k - 1, 1] + d1) * direction
        path[k] = pose
        pose_1, pose_2 = pose, pose_1
    path[:, 2] = (path[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return path
