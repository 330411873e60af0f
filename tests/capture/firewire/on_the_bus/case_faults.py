"""What goes wrong on a bus: each by its name, and mended where it can be."""

import contextlib
import ctypes
import errno
import fcntl
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import robsim
from bus_cameras import LARGE, SIZE, error_of, new_lab
from python_devices import PATIENT
from robsim import _firewire
from robsim.lab import (
    CameraFeatures,
    CaptureError,
    FrameTimeoutError,
    NoBandwidthError,
    NoBusError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from robsim.lab.cameras.sources import source_of
from sizes import thorough
from waiting import wait_for

LONG = 300  # s


def opened(url="firewire://", **options):
    return robsim.Camera(url, **PATIENT | options)


def read_until_timeout(camera):
    with contextlib.suppress(FrameTimeoutError):
        while True:
            camera.read(0.3)


def test_without_a_bus():
    assert not any(name.startswith("fw") for name in os.listdir("/dev"))
    with pytest.raises(NoBusError, match="/dev/fw0"):
        opened()


def test_a_bus_without_a_camera(start):
    start(new_lab()).unplug()
    with pytest.raises(NoCameraError):
        opened()


def test_a_node_that_must_not_be_read_is_named(start):
    start(new_lab()).deny()
    with pytest.raises(NoPermissionError, match="/dev/fw1"):
        opened()


def test_a_camera_that_answers_no_question_about_features_sends_all_the_same(start):
    lab = new_lab()
    start(lab).simplify()
    with opened() as camera:
        assert error_of(lab, camera.read()) < 0.5
        assert camera.features == CameraFeatures()
    with pytest.raises(CaptureError, match=r"features\.gain"):
        opened(features=CameraFeatures(gain=3))


def test_a_camera_that_is_unplugged_while_it_is_opened_opens_again(start):
    bus = start(new_lab())
    began = time.monotonic()
    opened().close()
    took = time.monotonic() - began
    for share in np.linspace(0.4, 1.1, thorough(90, 12)):
        unplugging = threading.Timer(share * took, bus.unplug)
        unplugging.start()
        with contextlib.suppress(NoCameraError, UnpluggedError):  # no other: these pass
            opened().close()
        unplugging.join()
        bus.plug_in()
        wait_for(_firewire.cameras)
        with opened() as camera:
            assert camera.features  # it is there


def test_a_stall_is_a_time_out_and_passes(start):
    lab = new_lab()
    bus = start(lab)
    with opened() as camera:
        camera.read()
        bus.stall(LONG)
        read_until_timeout(camera)
        bus.stall(0)
        assert error_of(lab, camera.read()) < 0.5
        assert camera.counts.reopened == 0


@pytest.mark.parametrize("power_fails", [False, True])
def test_frames_come_again_after_a_reset_of_the_bus(start, power_fails):
    lab = new_lab()
    bus = start(lab)
    with opened() as camera:
        camera.read()
        bus.reset(power_fails=power_fails)
        wait_for(lambda: camera._device.restarts == power_fails)
        assert max(error_of(lab, camera.read()) for _ in range(10)) < 0.5
        assert camera._device.restarts == power_fails


def test_what_the_bus_has_no_more_of_is_named(start):
    bus = start(new_lab())
    for what, words in (("channels", "no isochronous channel"), ("bandwidth", f"{SIZE[0]} x")):
        bus.refuse(**{what: True})
        with pytest.raises(NoBandwidthError, match=words):
            opened()
    bus.refuse()
    with opened() as camera:
        camera.read()


def test_frames_that_are_too_small_are_not_read(start):
    bus = start(new_lab(LARGE))
    bus.shorten()
    options = {"coding": "rgb8", "region": (64, 32, 320, 240)}
    with pytest.raises(
        CaptureError, match=r"320 x 240 px in rgb8 has 230400 bytes, got 115\d\d\d:"
    ):
        opened(**options)
    bus.shorten(shortened=False)
    with opened(**options) as camera:
        assert camera.read().image.shape == (240, 320, 3)


def test_two_cameras_share_the_bus(start):
    labs = new_lab(LARGE), new_lab(LARGE)
    bus = start(*labs)
    with opened("firewire://0") as first:
        # Both at 30 frames/s do not fit: the second one takes what is left.
        with opened(f"firewire://{bus.guid(1)}") as second:
            assert first.dt < 1 / 29
            for lab, camera in zip(labs, (first, second), strict=True):
                assert error_of(lab, camera.read()) < 0.5
        with pytest.raises(NoBandwidthError, match=r"yuv422 at 30 frames/s, which takes 5\d %"):
            opened("firewire://1", coding="yuv422", fps=30)
    with pytest.raises(NoCameraError, match=r"camera 5 .*firewire://0 "):
        opened("firewire://5")


def test_after_an_overrun_no_old_frame_comes(start, monkeypatch):
    lab = new_lab()
    bus = start(lab)
    lost, ends = 12, []

    def opened_and_not_read(*args, **options):
        opened = source_of(*args, **options)
        wait_for(lambda: bus.lost_frames() >= lost)
        ends.append(lab.truth.t[-1])
        return opened

    monkeypatch.setattr("robsim.lab.cameras.camera.source_of", opened_and_not_read)
    with opened() as camera:
        frame = camera.read()
        assert camera.counts.dropped >= 6  # all that the buffers had
        assert error_of(lab, frame) < 0.5
        # What the buffers had was exposed before all of those.
        assert frame.epoch + frame.t > ends[0] - 0.5 * lost * lab.dt
        assert error_of(lab, camera.read()) < 0.5


def test_a_camera_that_a_crashed_program_left_sending_is_taken_over(start):
    lab = new_lab()
    bus = start(lab)
    code = (
        "import robsim, sys\n"
        "camera = robsim.Camera('firewire://', open_timeout=300)\n"
        "print(camera.size, flush=True)\n"
        "sys.stdin.read()\n"
    )
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", code], **pipes) as child:
        assert child.stdout.readline()
        child.kill()
    assert bus.is_sending()
    with opened() as camera:
        assert error_of(lab, camera.read()) < 0.5
    assert not bus.is_sending()


def test_features_that_were_set_hold_when_it_is_plugged_in_again(start):
    lab = new_lab()
    bus = start(lab)
    first = CameraFeatures(shutter=0.004, exposure="auto")
    with opened(features=first, reopen=True) as camera:
        camera.features = CameraFeatures(shutter=0.006, gain=6)
        for opened_again in (0, 1):
            assert error_of(lab, camera.read()) < 0.5
            seen = camera.features
            assert (seen.shutter, seen.gain) == pytest.approx((0.006, 6))
            assert seen.exposure == "auto"  # nothing was said of it
            if not opened_again:
                bus.unplug()
                read_until_timeout(camera)
                bus.plug_in()
                wait_for(lambda: camera.counts.reopened)


@pytest.mark.parametrize("name", ["__open_2", "__open64_2"])
def test_programs_that_check_their_calls_see_the_bus(start, name):
    start(new_lab())
    library = ctypes.CDLL(None, use_errno=True)
    descriptor = library[name](b"/dev/fw1", os.O_RDWR)
    assert descriptor >= 0
    buffer = ctypes.create_string_buffer(8)
    fcntl.fcntl(descriptor, fcntl.F_SETFL, os.O_NONBLOCK)
    assert library["__read_chk"](descriptor, buffer, 8, 8) == -1  # no event has come
    assert ctypes.get_errno() == errno.EAGAIN
    os.close(descriptor)
    assert library[name](b"/dev/fw7", os.O_RDWR) == -1
    assert ctypes.get_errno() == errno.ENOENT
