"""Each coding, each Bayer filter, regions and rates: the pose is right."""

import numpy as np
import pytest

import robsim
import surroundings
from bus_cameras import LARGE, SIZE, error_of, new_lab
from doubles import VirtualCamera
from python_devices import PATIENT
from robsim.lab import CameraFeatures, CaptureError
from waiting import wait_for


def opened(**options):
    return robsim.Camera("firewire://", **PATIENT, **options)


def test_the_pose_is_right_in_each_coding(start):
    lab = new_lab()
    start(lab)
    for coding in ("yuv422", "rgb8", "yuv444", "raw8", "yuv411"):
        with opened(coding=coding) as camera:
            assert (camera.coding, camera.size) == (coding, SIZE)
            assert max(error_of(lab, camera.read()) for _ in range(3)) < 0.5


def test_grey_is_the_brightness_of_the_picture(start):
    start(new_lab())
    with opened(coding="rgb8") as camera:
        colored = camera.read().image.astype(float)
    for coding in ("mono8", "mono16"):
        with opened(coding=coding) as camera:
            grey = camera.read().image.astype(float)
        assert np.ptp(grey, axis=2).max() == 0
        assert abs(grey[..., 0] - colored @ (0.299, 0.587, 0.114)).max() < 2


@pytest.mark.parametrize("color_filter", ["rggb", "gbrg", "grbg", "bggr"])
def test_each_bayer_filter_gives_the_right_colors(start, color_filter):
    lab = new_lab()
    start(VirtualCamera(lab=lab, codings=("raw8",), color_filter=color_filter))
    with opened() as camera:
        assert camera.coding == "raw8"
        assert error_of(lab, camera.read()) < 0.5


def test_a_region_is_that_part_of_the_sensor(start):
    start(new_lab())
    with opened(coding="rgb8") as camera:
        whole = camera.read().image
    with opened(coding="rgb8", region=(64, 32, 160, 120)) as camera:
        assert camera.region == (64, 32, 160, 120)
        assert np.array_equal(camera.read().image, whole[32:152, 64:224])
    with pytest.raises(CaptureError, match=r"steps of 8 x 2 px"):
        opened(region=(0, 0, 161, 120))


@pytest.mark.parametrize("fps", [30, 15, 7.5, 10])
def test_the_rate_is_that_asked_for(start, fps):
    start(new_lab())
    with opened(fps=fps) as camera:
        assert camera.dt == pytest.approx(1 / fps, rel=0.02)
        times = [camera.read().t]

        def interval():  # who reads late misses some
            times.append(camera.read().t)
            return times[-1] - times[-2]

        wait_for(lambda: interval() == pytest.approx(1 / fps, abs=2e-3))


def test_a_rate_that_the_camera_does_not_have_is_told(start):
    start(new_lab(fps=30))
    with pytest.warns(UserWarning, match="30 .*60") as told, opened(fps=60) as camera:
        assert camera.dt == pytest.approx(1 / 30, rel=0.02)
    assert len(told) == 1


def test_a_rate_that_is_too_fast_for_the_bus_is_refused_with_those_that_are_not(start):
    start(new_lab(LARGE))
    with pytest.raises(CaptureError, match=r"rgb8 at 30, 15, 7.5"):
        opened(fps=400)


@pytest.mark.skipif(surroundings.THREAD_SANITIZER, reason="too slow for 60 large frames a second")
@pytest.mark.parametrize("card_is_fast", [True, False])
def test_a_fast_camera_sends_no_faster_than_it_must_and_the_card_can(start, card_is_fast):
    lab = new_lab(LARGE, fps=60)
    start(VirtualCamera(lab=lab, is_fast=True), card_is_fast=card_is_fast)

    def check_speed(speed, **asked):
        with opened(**asked) as camera:
            assert camera._device.video["speed"] == speed
            assert error_of(lab, camera.read()) < 0.5

    check_speed(400, fps=30)
    # 6912 bytes a cycle, of which S400 has 4096.
    asked = {"coding": "rgb8", "fps": 60}
    if not card_is_fast:
        with pytest.raises(CaptureError, match=r"640 x 480 px rgb8 at 30"):
            opened(**asked)
        return
    check_speed(800, **asked)
    check_speed(400, fps=30)  # what the last program has set does not stay


def test_what_a_camera_cannot_is_refused_with_what_it_can(start):
    start(VirtualCamera(lab=new_lab(), codings=("yuv422",)))
    with pytest.raises(CaptureError, match=f"{SIZE[0]} x {SIZE[1]} px yuv422 at 30"):
        opened(coding="rgb8")


def test_features_are_manual_and_stay_as_they_are_set(start):
    start(new_lab())
    with opened() as camera:
        assert "auto" not in vars(camera.features).values()
        bright = camera.read().image.mean()
    chosen = CameraFeatures(shutter=0.004, white_balance=(400, 600), exposure="auto")
    with opened(features=chosen) as camera:
        seen = camera.features
        assert seen.shutter == pytest.approx(0.004)
        assert (seen.white_balance, seen.exposure) == ((400, 600), "auto")
        camera.read()
        assert camera.read().image.mean() < 0.6 * bright
        camera.features = CameraFeatures(shutter=0.01, white_balance=(512, 512))
        for _ in range(4):
            camera.read()
        assert camera.read().image.mean() == pytest.approx(bright, rel=0.02)
    with pytest.raises(CaptureError, match=r"features\.gain .* 0 to 24 dB"):
        opened(features=CameraFeatures(gain=99))
