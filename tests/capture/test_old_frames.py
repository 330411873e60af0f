"""Old frames of a stream are passed over, and counted: at its start and after a stall."""

import subprocess
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from python_devices import PATIENT
from robsim.lab import NoCameraError
from robsim.lab.cameras._devices import opencv

STEP = 0.04  # s between two frames
DELAY = 0.06  # s that the camera's encoder takes
VARIABLE = "OPENCV_FFMPEG_CAPTURE_OPTIONS"


class Stream:
    """OpenCV with a stream: frame k is taken at k STEP, and comes when the line lets it.

    `comes` is the time (s) at which each frame can be read; `stamps` are the stream's own times
    (s). The clock advances with each wait for a frame.
    """

    def __init__(self, monkeypatch, comes, stamps=None, source="rtsp://camera/stream"):
        self.taken = STEP * np.arange(len(comes))
        self.comes = np.asarray(comes)
        self.stamps = self.taken if stamps is None else stamps
        self.number, self.now = -1, 0.0
        numbers = {name: k for k, name in enumerate(opencv._NUMBER.values())}
        words = ("OPEN_TIMEOUT_MSEC", "READ_TIMEOUT_MSEC", "N_THREADS", "FOURCC", "FORMAT")
        properties = dict.fromkeys(f"CAP_PROP_{word}" for word in words)
        cv2 = SimpleNamespace(
            **numbers | properties,
            CAP_PROP_POS_MSEC="stamp",
            videoio_registry=SimpleNamespace(hasBackend=lambda _: True),
            utils=SimpleNamespace(logging=SimpleNamespace()),
            VideoCapture=lambda *_: self,
        )
        monkeypatch.setattr(opencv, "load_opencv", lambda _: cv2)
        monkeypatch.setattr(opencv, "quiet", lambda _: nullcontext())
        monkeypatch.setattr(opencv, "time", SimpleNamespace(monotonic=lambda: self.now))
        self.camera = opencv.OpenCvCamera(source, "ffmpeg")
        self.camera.open()

    def isOpened(self):
        return True

    def grab(self):
        self.number += 1
        self.now = max(self.now + 0.001, self.comes[self.number])
        return True

    def retrieve(self):
        return True, np.full((2, 2, 3), self.number % 256, np.uint8)

    def get(self, name):
        return 1000 * self.stamps[self.number] if name == "stamp" else 0

    def read(self):
        """Return number and age of the frames that were handed over, and how many were not."""
        frames, ages, n_passed = [], [], 0
        for _ in self.comes:
            if (said := self.camera.read()) is not None:
                _, exposed, arrived, passed, _ = said
                assert arrived == self.now
                frames.append(self.number)
                ages.append(self.now - self.taken[self.number])
                n_passed += passed
                if exposed is not None:
                    assert arrived - exposed < opencv.OLD
        assert n_passed == frames[-1] + 1 - len(frames)
        return np.array(frames), np.array(ages)


def live(count):
    """Return when frames come that nothing keeps back."""
    return STEP * np.arange(count) + DELAY


def stalled(count, begin, end):
    """Return the same of a line that stands still for a while."""
    comes = live(count)
    comes[(comes > begin) & (comes < end)] = end
    return comes


def test_a_backlog_at_the_start_is_passed_over(monkeypatch):
    frames, ages = Stream(monkeypatch, np.maximum(live(100), 1.2)).read()
    assert ages.max() < DELAY + 0.1
    assert frames[0] <= 1.2 / STEP + 3
    assert len(frames) == 100 - frames[0]


@pytest.mark.parametrize("stall", [1.5, 12])
def test_a_backlog_after_a_stall_is_passed_over(monkeypatch, stall):
    frames, ages = Stream(monkeypatch, stalled(600, 4, 4 + stall)).read()
    assert ages.max() < DELAY + 0.11
    n_old = int(stall / STEP)
    assert abs(600 - n_old - len(frames)) <= 10


def test_frames_come_again_though_they_stay_late(monkeypatch):
    comes = live(800)
    comes[200:] += 0.3  # such as another encoder
    frames, _ = Stream(monkeypatch, comes).read()
    assert np.diff(frames).max() * STEP == pytest.approx(10, abs=0.1)
    assert (np.diff(frames) == 1).sum() > 500


@pytest.mark.parametrize("drift", [1e-3, -1e-3])
def test_a_clock_that_drifts_and_a_busy_machine_cost_no_frame(monkeypatch, rng, drift):
    stream = Stream(monkeypatch, live(3000) + rng.uniform(0, 0.08, 3000), STEP * np.arange(3000))
    stream.stamps = (1 + drift) * stream.stamps
    assert len(stream.read()[0]) >= 2990


@pytest.mark.parametrize("stamps", ["none", "of some other kind"])
def test_frames_whose_stamps_tell_nothing_are_all_handed_over(monkeypatch, rng, stamps):
    told = np.zeros(100) if stamps == "none" else rng.permutation(100) / 10
    assert len(Stream(monkeypatch, live(100), told).read()[0]) >= 90


def test_stamps_that_start_anew_are_believed_from_there(monkeypatch):
    stamps = STEP * np.arange(600)
    stamps[1:] -= STEP  # as FFmpeg stamps the first one
    stamps[300:] -= 7
    frames, ages = Stream(monkeypatch, stalled(600, 20, 21.5), stamps).read()
    assert ages.max() < DELAY + 0.11
    assert (np.diff(frames) == 1).sum() > 540


def test_only_the_stamps_of_rtsp_are_believed(monkeypatch):
    stream = Stream(monkeypatch, 2 * live(100), source="http://camera/video")
    assert len(stream.read()[0]) == 100


@pytest.mark.parametrize("source", ["rtsp://127.0.0.1:1/a", "http://127.0.0.1:1/a"])
@pytest.mark.parametrize("is_set", [False, True])
def test_a_small_probe_is_chosen_for_rtsp_unless_the_user_chooses(monkeypatch, source, is_set):
    pytest.importorskip("cv2")
    seen = []
    start = subprocess.Popen

    def started(*arguments, env, **options):
        seen.append(env.get(VARIABLE))
        return start(*arguments, env=env, **options)

    monkeypatch.setattr(subprocess, "Popen", started)
    monkeypatch.delenv(VARIABLE, raising=False)
    if is_set:
        monkeypatch.setenv(VARIABLE, "rtsp_transport;udp")
    is_rtsp = source.startswith("rtsp")
    told = pytest.warns(UserWarning, match=VARIABLE) if is_set and is_rtsp else nullcontext()
    with told, pytest.raises(NoCameraError):
        robsim.Camera(source, back_end="ffmpeg", **PATIENT)
    chosen = "rtsp_transport;tcp|allowed_media_types;video|probesize;32" if is_rtsp else None
    assert seen == ["rtsp_transport;udp" if is_set else chosen]
