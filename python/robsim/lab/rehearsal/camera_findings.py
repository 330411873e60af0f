"""The findings on a camera: values, verdicts, remedies."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robsim._core import MotorLink, trusted_width
from robsim.base.checks import Floats
from robsim.base.report import Quantity
from robsim.lab.calibration.grid import SHIFTS, remedy_of_shifts
from robsim.lab.cameras.camera import Camera, CameraCounts
from robsim.lab.rehearsal import _calibration_findings as mapping
from robsim.lab.rehearsal._camera_look import CameraLook, MarkerLight
from robsim.vision.imaging.calibration import Calibration

VERDICTS = ("good", "poor", "bad")
_NOTHING = 5e-4
NOT_KNOWN = "not known"

# Limits of good and of poor, where these depend on the look; beyond the second it is bad.
_RATE = (9.5, 4.5)  # frames/s; the robot of 2008 had 5
_KEPT = 0.9  # of the rate that a camera promises
_MOSTLY_LOST = 0.6  # of the median interval: it is that of two frames
_WHOLE = 0.1  # of an interval, from a whole number of them
_LOST = (0.02, 0.15)  # of the frames
_ONE = 1.5  # frame: a single one is no fault
_MEAN = (64, 25)  # levels; below the first, `detect` calls a picture dark
_BRIGHT = 235  # level
_CLIPPED = (0.1, 1.0)  # of a marker's pixels
_WIDTH = 9.0  # px of the frame; how small is too small, the noise tells
_STILL = 2.0  # px
_TRUSTED = 4.0  # signal to noise; below it, a pose is not to be trusted

# All other rules: unit, limits of good and of poor; those of % as parts, those of ms in s.
_RULES = {
    "jitter": ("ms", 0.2, 0.5),  # of the interval
    "white pixels": ("%", 0.25, 0.5),  # above the second it is overexposed
    "markers' level": ("", 70, 40),
    "contrast": ("levels", 40.0, 20.0),
    "margin": ("levels", 20.0, 6.0),
    "found": ("%", 0.7, 0.45),  # of a marker's area
    "noise": ("levels", 13.0, math.inf),  # 5 %; whether it is too much, the markers tell
    "signal to noise of the markers": ("", 8.0, _TRUSTED),
    "robot detected": ("%", 0.98, 0.8),
    "other blobs": ("a frame", 0.05, math.inf),
    "scatter of the position": ("px", 0.02, 0.06),  # of the distance between the markers
    "scatter of the heading": ("rad", math.radians(1), math.radians(3)),
    "markers' distance": ("%", 0.025, 0.06),
    "markers' distance, by place": ("%", 0.025, 0.06),
    "shift of floor sheets": ("px", *SHIFTS),
    "work area in the picture": ("%", 0.9, 0.5),
    "exposure to arrival": ("ms", 0.05, 0.15),
    "round trip to the robot": ("ms", 0.05, 0.15),
}
_SCALES = {"%": 100, "ms": 1e3}

_REMEDIES = {
    "no blobs": "train the colours in this light (robsim colors train), or is it another robot?",
    "at the border": "move the robot away from the border of the picture",
    "ambiguous": "leave only one robot, and nothing of its colours, in the picture",
    "by chance": "remove things in the markers' colours from the floor, or train narrower colours",
    "dark": "give more light, or a longer exposure",
    "overexposed": "give a shorter exposure, or less light",
    "shape": "give more light, or train the colours in this light; or is there no robot?",
    "small markers": "bring the camera closer, take more pixels, or print larger markers",
}


def _remedy(reason: str | None, colors: Mapping[str, str]) -> str | None:
    for role, color in colors.items():
        if reason == f"no {color} blob":
            return f"train the {role} marker's colour, {color}, in this light: robsim colors train"
    return _REMEDIES.get(reason or "")


@dataclass(frozen=True)
class CameraFinding:
    """A finding of a camera check.

    Attributes
    ----------
    name : str
        Its name.
    value : float
        Its value; NaN = not known.
    unit : str
        Its unit.
    verdict : str
        ``"good"``, ``"poor"``, ``"bad"`` or ``"not known"``.
    remedy : str
        The remedy if it is not good.

    Examples
    --------
    >>> with robsim.lab.SimulatedLab() as lab, robsim.Camera(lab) as camera:
    ...     check = robsim.lab.check_camera(camera, robot="lab", seconds=0.5)
    >>> check.findings[0].name, check.findings[0].unit
    ('frame rate', '1/s')
    """

    name: str
    value: float
    unit: str
    verdict: str
    remedy: str = ""

    @property
    def amount(self) -> str:
        """The value and the unit as text; ``"-"`` if the value is not known."""
        if math.isnan(self.value):
            return "-"
        return Quantity(self.name, "", self.value, self.unit, three_digits).line.strip()

    def __str__(self) -> str:
        return f"{self.name} {self.amount} ({self.verdict})"


def three_digits(value: float) -> str:
    return "0" if abs(value) < _NOTHING else f"{value:.3g}"


def rank(finding: CameraFinding) -> int:
    """Return the severity of a finding: 0 = good or not known."""
    return VERDICTS.index(finding.verdict) if finding.verdict in VERDICTS else 0


def _judged(
    name: str, value: float, remedy: str, *, called: str = "", times: float = 1.0
) -> CameraFinding:
    """Return a finding by its rule, whose limits are multiplied."""
    unit, good, poor = _RULES[name]
    return _finding(called or name, value, unit, (times * good, times * poor), remedy)


def _finding(
    name: str, value: float, unit: str, limits: tuple[float, float], remedy: str
) -> CameraFinding:
    """Return a finding; the order of the limits of good and poor gives the better direction."""
    good, poor = limits
    sign = 1 if good <= poor else -1
    if math.isnan(value):
        return CameraFinding(name, value, unit, NOT_KNOWN)
    verdict = VERDICTS[sum(sign * value > sign * limit for limit in limits)]
    return CameraFinding(name, _SCALES.get(unit, 1) * float(value), unit, verdict, remedy)


def findings_of(
    look: CameraLook, camera: Camera, before: CameraCounts, motors: MotorLink | None
) -> Iterator[CameraFinding]:
    """Yield all findings; `before` are the camera's counts before the check."""
    yield from _regularity(look, camera, before)
    yield from _exposure(look)
    yield from _markers(look)
    yield from _noise(look)
    yield from _detection(look)
    yield from _scatter(look)
    yield from _map(look, camera)
    yield from _latency(look, camera, motors)


def _regularity(look: CameraLook, camera: Camera, before: CameraCounts) -> Iterator[CameraFinding]:
    index, t, _ = np.array(look.times).T
    intervals, numbers = np.diff(t), np.diff(index)
    interval = _interval_of(intervals / numbers)
    rate = 1 / interval
    # Frames between two read frames: frames at the camera's own interval, without a number.
    missing = np.maximum(np.rint(intervals / interval) - numbers, 0) if len(t) > 1 else np.zeros(1)
    came = (index[-1] - index[0]) + 1
    torn = camera.counts.torn - before.torn
    timeouts = camera.counts.timeouts - before.timeouts
    lost = float(missing.sum()) if len(t) > 1 else math.nan
    jitter = math.nan
    if len(t) > 1:
        jitter = float(np.std(intervals - interval * np.rint(intervals / interval)))
    promised = 0.0 if camera.dt is None else 1 / camera.dt
    wanted = f": it promised {promised:.3g} per second" if rate < _KEPT * promised else ""
    yield _finding(
        "frame rate",
        rate,
        "1/s",
        (max(_RATE[0], _KEPT * promised), _RATE[1]),
        f"shorten the exposure, give more light, or request smaller frames{wanted}",
    )
    remedy = "frames arrive irregularly: use a wired network, close other programs"
    yield _judged("jitter", jitter, remedy, times=interval)
    said = f", {torn} of them torn" if torn else ""
    said += f"; {timeouts} timeouts without a frame" if timeouts else ""
    good, poor = (max(limit, _ONE / (came + lost)) for limit in _LOST)
    yield _finding(
        "lost frames",
        lost / (came + lost),
        "%",
        (good, poor),
        f"{lost:.0f} of {came + lost:.0f} were lost{said}: use a shorter cable, another USB port "
        "or a wired network, or request fewer frames",
    )


def _interval_of(each: Floats) -> float:
    """Return the time between two exposures (s), if some frames are lost."""
    if not len(each):
        return math.nan
    interval, shortest = float(np.median(each)), float(np.quantile(each, 0.1))
    if shortest <= 0:
        return interval
    off = np.abs(each / shortest - np.rint(each / shortest))
    is_multiple = np.median(off) < _WHOLE
    return shortest if is_multiple and shortest < _MOSTLY_LOST * interval else interval


def _exposure(look: CameraLook) -> Iterator[CameraFinding]:
    mean, white, black = np.median(look.light, axis=0)
    dark = "give more light, or a longer exposure, and switch the automatic off"
    bright = "give a shorter exposure, or less light, and switch the automatic off"
    # A dark floor is no fault, as long as the markers have light.
    is_seen = any(look.marker_light.values())
    yield _finding("mean level", mean, "", (_MEAN[1], 0) if is_seen else _MEAN, dark)
    yield _judged("white pixels", white, bright)
    yield CameraFinding("black pixels", 100 * black, "%", "good")
    yield _judged("markers' level", _marker(look, "level", min), f"dark markers: {dark}")
    is_bright = _marker(look, "level", max) > _BRIGHT
    limits = _CLIPPED if is_bright else (1, 1)  # noise clips pixels, too
    remedy = f"the markers are too bright to keep their colour: {bright}"
    yield _finding("markers clipped", _marker(look, "clipped", max), "%", limits, remedy)


def _marker(look: CameraLook, name: str, worst: Callable[[list[float]], float]) -> float:
    """Return the median of a value over the frames, of the worse marker."""
    values = [
        float(np.median([getattr(light, name) for light in lights]))
        for lights in look.marker_light.values()
        if lights
    ]
    return worst(values) if values else math.nan


def _markers(look: CameraLook) -> Iterator[CameraFinding]:
    wanted = trusted_width(float(np.median(look.noise)))
    yield _finding(
        "marker width",
        look.markers.width_in(look.shown[0]),
        "px",
        (max(_WIDTH, 2 * wanted), wanted),
        f"{_REMEDIES['small markers']}; with this noise poses can be trusted from {wanted:.2g} px "
        "on, in good light",
    )
    lost, second = "with slightly less light it is lost", "it is found only at the second chance"
    for name, lights in look.marker_light.items():
        of = {key: _median_of(lights, key) for key in ("contrast", "margin", "found")}
        train = f"train {name} in this light (robsim colors train), or change the light"
        paper = "its surroundings have nearly its colour: put it on black or white paper"
        weak = f"{lost if of['margin'] >= 0 else second}: {train}"
        yield _judged(
            "contrast", of["contrast"], f"{paper}, or {train}", called=f"contrast of {name}"
        )
        yield _judged("margin", of["margin"], weak, called=f"margin of {name}")
        yield _judged("found", of["found"], train, called=f"{name} found")


def _noise(look: CameraLook) -> Iterator[CameraFinding]:
    """Yield the camera's noise, and the markers' signal relative to it."""
    less = "give more light, a longer exposure instead of gain"
    remedy = f"the pixels are noisy: {less}, or larger markers in the picture"
    yield _judged("noise", float(np.median(look.noise)), remedy)
    found = look.signal_to_noise
    yield _judged(
        "signal to noise of the markers",
        float(np.median(found)) if found else math.nan,
        f"poses can be trusted from {_TRUSTED:g} on, and below 3 the robot counts as unseen: "
        f"{less}, more pixels, or larger markers",
    )


def _median_of(lights: Sequence[MarkerLight], name: str) -> float:
    return float(np.median([getattr(light, name) for light in lights])) if lights else math.nan


def _detection(look: CameraLook) -> Iterator[CameraFinding]:
    total = len(look.detections)
    missed = Counter(one.reason for one in look.detections if one.measurement is None)
    remedy = ""
    if missed:
        reason, times = missed.most_common(1)[0]
        example = next(one for one in look.detections if one.reason == reason)
        remedy = f"in {times} of {total} frames, {example.explanation}"
        if known := _remedy(reason, look.markers.colors):
            remedy += f"; {known}"
    yield _judged("robot detected", look.seen / total, remedy)
    yield _judged(
        "other blobs",
        float(np.mean(look.others)) if look.seen else math.nan,
        "there are other things, as large as the markers and of their colours, in the picture: "
        "remove them, or train narrower colours",
    )


def _scatter(look: CameraLook) -> Iterator[CameraFinding]:
    position = heading = moved = math.nan
    still = 0.0
    if look.seen >= 6:
        poses = np.array(look.poses)
        poses[:, 2] = np.unwrap(poses[:, 2])
        scatter = poses.std(axis=0)
        first, last = np.array_split(poses[:, :2], 3)[::2]
        moved = float(np.linalg.norm(last.mean(axis=0) - first.mean(axis=0)))
        still = _STILL + float(np.hypot(*scatter[:2]))
        if moved <= still:
            position, heading = float(scatter[:2].max()), float(scatter[2])
    noisy = "give more light, a longer exposure instead of gain, or take larger markers"
    stand = "the robot moved: let it stand, to see how noisy its pose is"
    yield _finding("motion", moved, "px", (still, math.inf), stand)
    yield _judged("scatter of the position", position, noisy, times=look.markers.distance)
    yield _judged("scatter of the heading", heading, noisy)


def _map(look: CameraLook, camera: Camera) -> Iterator[CameraFinding]:
    """Yield whether the map from pixels to the floor fits the robot."""
    excess = mapping.median_excess(look.pairs)
    remedy = mapping.remedy(excess, look.pairs, camera.calibration, look.markers.distance)
    off = _judged("markers' distance", abs(excess), remedy)
    yield dataclasses.replace(off, value=100 * excess)
    spread = mapping.spread_over_places(look.pairs, camera.area)
    remedy = mapping.remedy_of_spread(camera.calibration)
    yield _judged("markers' distance, by place", spread, remedy)
    if camera.calibration is not None:
        yield from _sheets(look, camera.calibration)
        yield _judged(
            "work area in the picture",
            mapping.visible_share(camera.calibration),
            "the picture does not show all of the work area: was the camera moved since its "
            "calibration, or is --area too large?",
        )


def _sheets(look: CameraLook, calibration: Calibration) -> Iterator[CameraFinding]:
    """Yield whether floor sheets kept their calibrated positions, if there are any."""
    if calibration.marks:
        shifts = mapping.shifts_of_sheets(look.last, calibration)
        largest = max(shifts.values(), default=math.nan)
        yield _judged("shift of floor sheets", largest, remedy_of_shifts(shifts))


def _latency(look: CameraLook, camera: Camera, motors: MotorLink | None) -> Iterator[CameraFinding]:
    _, t, t_arrival = np.array(look.times).T
    yield _judged(
        "exposure to arrival",
        float(np.median(t_arrival - t)) if camera._knows_exposure() else math.nan,
        "the robot is no longer where the frame shows it: take a camera by number or MJPEG, "
        "smaller frames, no filter in the camera",
    )
    if motors is not None:
        answers = motors.round_trip_times
        answer = float(np.median(answers)) if len(answers) else math.nan
        remedy = "the line to the robot is slow: use a nearer access point, or a cable"
        yield _judged("round trip to the robot", answer, remedy)
