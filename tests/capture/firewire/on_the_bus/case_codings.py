"""Each coding, each Bayer filter, regions and rates: the pose is right."""

import numpy as np
import pytest

import robsim
from bus_cameras import LARGE, SIZE, error_of, new_lab
from robsim.capture import CameraFeatures, CaptureError
from robsim.live import VirtualCamera

COLORED = ("yuv422", "rgb8", "yuv444", "raw8", "yuv411")


@pytest.mark.parametrize("coding", COLORED)
def test_the_pose_is_right_in_each_coding(start, coding):
    lab = new_lab()
    start(lab)
    with robsim.Camera("firewire://", coding=coding) as camera:
        assert (camera.coding, camera.size) == (coding, SIZE)
        assert [error_of(lab, camera.read()) for _ in range(5)] == pytest.approx([0] * 5, abs=0.5)


@pytest.mark.parametrize("coding", ["mono8", "mono16"])
def test_grey_is_the_brightness_of_the_picture(start, coding):
    lab = new_lab()
    start(lab)
    with robsim.Camera("firewire://", coding="rgb8") as camera:
        colored = camera.read().image.astype(float)
    with robsim.Camera("firewire://", coding=coding) as camera:
        grey = camera.read().image.astype(float)
    assert np.ptp(grey, axis=2).max() == 0
    assert abs(grey[..., 0] - colored @ (0.299, 0.587, 0.114)).max() < 2


@pytest.mark.parametrize("color_filter", ["rggb", "gbrg", "grbg", "bggr"])
def test_each_bayer_filter_gives_the_right_colors(start, color_filter):
    lab = new_lab()
    start(VirtualCamera(lab=lab, codings=("raw8",), color_filter=color_filter))
    with robsim.Camera("firewire://") as camera:
        assert camera.coding == "raw8"
        assert error_of(lab, camera.read()) < 0.5


def test_a_region_is_that_part_of_the_sensor(start):
    lab = new_lab()
    start(lab)
    with robsim.Camera("firewire://", coding="rgb8") as camera:
        whole = camera.read().image
    width, height = SIZE[0] // 2, SIZE[1] // 2
    region = (64, 32, width, height)
    with robsim.Camera("firewire://", coding="rgb8", region=region) as camera:
        assert camera.region == region
        part = camera.read().image
    assert np.array_equal(part, whole[32 : 32 + height, 64 : 64 + width])
    with pytest.raises(CaptureError, match=r"steps of 8 x 2 px"):
        robsim.Camera("firewire://", region=(0, 0, width + 1, height))


@pytest.mark.parametrize("fps", [30, 15, 7.5, 10])
def test_the_rate_is_that_asked_for(start, fps):
    start(new_lab())
    with robsim.Camera("firewire://", fps=fps) as camera:
        assert camera.dt == pytest.approx(1 / fps, rel=0.02)
        camera.read()
        times = [camera.read().t for _ in range(5)]
    assert np.diff(times).min() == pytest.approx(1 / fps, abs=2e-3)


def test_a_rate_that_the_camera_does_not_have_is_told(start):
    start(new_lab(fps=30))
    with (
        pytest.warns(UserWarning, match="sends 30 frames/s; asked for were 60") as told,
        robsim.Camera("firewire://", fps=60) as camera,
    ):
        assert camera.dt == pytest.approx(1 / 30, rel=0.02)
    assert len(told) == 1


def test_a_rate_that_is_too_fast_for_the_bus_is_refused_with_those_that_are_not(start):
    start(new_lab(LARGE))
    with pytest.raises(CaptureError, match=r"it has .* px rgb8 at 30, 15, 7.5"):
        robsim.Camera("firewire://", fps=400)


@pytest.mark.parametrize("card_is_fast", [True, False])
def test_a_fast_camera_sends_no_faster_than_it_must_and_the_card_can(start, card_is_fast):
    if SIZE != LARGE:  # too slow for 60 large frames a second, and nothing may be skipped here
        return
    lab = new_lab(fps=60)
    start(VirtualCamera(lab=lab, is_fast=True), card_is_fast=card_is_fast)
    with robsim.Camera("firewire://", fps=30) as camera:
        assert camera._device.video["speed"] == 400
        assert error_of(lab, camera.read()) < 0.5
    # 6912 bytes a cycle, of which S400 has 4096.
    asked = {"coding": "rgb8", "fps": 60}
    if not card_is_fast:
        with pytest.raises(CaptureError, match=r"it has .*640 x 480 px rgb8 at 30"):
            robsim.Camera("firewire://", **asked)
        return
    with robsim.Camera("firewire://", **asked) as camera:
        assert camera._device.video["speed"] == 800
        assert error_of(lab, camera.read()) < 0.5
    # What the last program has set does not stay.
    with robsim.Camera("firewire://", fps=30) as camera:
        assert camera._device.video["speed"] == 400
        assert error_of(lab, camera.read()) < 0.5


def test_what_a_camera_cannot_is_refused_with_what_it_can(start):
    start(VirtualCamera(lab=new_lab(), codings=("yuv422",)))
    with pytest.raises(CaptureError, match=f"it has .*{SIZE[0]} x {SIZE[1]} px yuv422 at 30"):
        robsim.Camera("firewire://", coding="rgb8")


def test_features_are_manual_and_stay_as_they_are_set(start):
    start(new_lab())
    with robsim.Camera("firewire://") as camera:
        assert "auto" not in vars(camera.features).values()
        bright = camera.read().image.mean()
    chosen = CameraFeatures(shutter=0.004, white_balance=(400, 600), exposure="auto")
    with robsim.Camera("firewire://", features=chosen) as camera:
        seen = camera.features
        assert seen.shutter == pytest.approx(0.004)
        assert (seen.white_balance, seen.exposure) == ((400, 600), "auto")
        camera.read()
        assert camera.read().image.mean() < 0.6 * bright
        camera.features = CameraFeatures(shutter=0.01, white_balance=(512, 512))
        for _ in range(4):
            camera.read()
        assert camera.read().image.mean() == pytest.approx(bright, rel=0.02)
    with pytest.raises(CaptureError, match=r"features.gain must be a number from 0 to 24 dB"):
        robsim.Camera("firewire://", features=CameraFeatures(gain=99))
