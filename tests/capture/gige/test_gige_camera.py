"""GigE Vision: frames of the simulated lab that Aravis' fake camera sends and `Camera` reads."""

import os
import time

import numpy as np
import pytest

import robsim
from gige_cameras import (
    ADDRESS,
    URL,
    camera_of,
    driven,
    measured,
    program,
    served,
    through,
    ticks_of,
    wait_for_camera,
)
from needs import needs_extension, needs_program
from robsim.capture import CameraFeatures, CaptureError, NoCameraError


def own_threads():
    return len(os.listdir("/proc/self/task"))


def open_files():
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.long
@pytest.mark.sanitized
def test_frames_are_those_of_the_lab_and_poses_are_right():
    with served() as server:
        with camera_of(server) as camera:
            frames = driven(server, camera, 30)
            counts = camera.counts
        ticks = ticks_of(server, frames)
        truth = server.lab.truth
    assert np.ptp(truth.pose[ticks, 0]) > 1  # it has moved
    for tick, frame in zip(ticks, frames, strict=True):
        # A pixel of the frame is 3.75 px of the work area.
        assert np.hypot(*(measured(frame)[:2] - truth.pose[tick, :2])) < 1
        # The device's own clock says when, and never before it was.
        assert truth.t[tick] <= frame.epoch + frame.t <= frame.epoch + frame.t_arrival
    assert counts.delivered == 30
    assert server.sent_frames >= 30


@pytest.mark.parametrize(
    "pixel_format",
    [
        pytest.param("BayerRG8", marks=pytest.mark.slow),
        pytest.param("BayerGR8", marks=pytest.mark.slow),
        pytest.param("BayerGB8", marks=pytest.mark.slow),
        pytest.param("BayerBG8", marks=pytest.mark.slow),
        pytest.param("Mono8", marks=pytest.mark.slow),
    ],
)
def test_every_pixel_format_shows_the_lab(pixel_format):
    with served() as server:
        with camera_of(server, query=f"?format={pixel_format}") as camera:
            frames = driven(server, camera, 10)
        ticks = ticks_of(server, frames, through(pixel_format))
        truth = server.lab.truth
    for tick, frame in zip(ticks, frames, strict=True):
        if pixel_format == "Mono8":
            assert (frame.image == frame.image[..., :1]).all()
        else:
            # 0.4 px of the frame, which the means of neighbours cost.
            assert np.hypot(*(measured(frame)[:2] - truth.pose[tick, :2])) < 1.5


@pytest.mark.slow
def test_colour_is_chosen_first_and_the_rate_is_known():
    with served() as server, camera_of(server) as camera:
        assert (camera.coding, camera.region) == ("rgb8", (0, 0, 320, 240))
        assert camera.dt == pytest.approx(server.lab.dt, rel=1e-3)


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_coding_is_chosen():
    with served() as server:
        for coding, way in (("raw8", "BayerRG8"), ("mono8", "Mono8"), ("rgb8", "RGB8")):
            with camera_of(server, coding=coding) as camera:
                assert camera.coding == coding
                ticks_of(server, driven(server, camera, 3), through(way))
        with pytest.raises(ValueError, match="coding must be one of 'rgb8', 'raw8'"):
            camera_of(server, coding="yuv411")
        with pytest.raises(CaptureError, match=r"must be one of RGB8, Bayer.*got yuv422"):
            camera_of(server, coding="yuv422")


def test_nobody_at_the_address():
    with pytest.raises(NoCameraError, match=r"no GigE Vision camera answers at 127\.0\.0\.1"):
        robsim.Camera(URL)


def test_lost_frames_are_counted_over_the_end_of_their_numbers():
    lost_between = needs_extension("gige").lost_between
    assert lost_between(1, 2) == 0
    assert lost_between(1, 5) == 3
    assert lost_between(65534, 65535) == 0
    assert lost_between(65535, 1) == 0  # 0 is no number
    assert lost_between(65535, 2) == 1
    assert lost_between(65530, 3) == 7
    assert lost_between(7, 7) == 0
    assert lost_between(65535, 65536) == 0  # GigE Vision 2
    assert lost_between(2**32, 2**32 + 4) == 3
    assert lost_between(2**32, 1) == 0  # it has started anew


@pytest.mark.slow
def test_no_frame_is_taken_for_a_lost_one_where_the_numbers_begin_anew():
    # Those of Aravis' fake camera begin at 65400.
    with served() as server, camera_of(server) as camera:
        frames = driven(server, camera, 200)
        counts = camera.counts
        ticks = ticks_of(server, frames)
    assert len(set(ticks)) == 200
    # A slow machine may lose some; 65535 would be missing where the end is not understood.
    assert counts.torn < 50


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_region_of_the_sensor():
    with served() as server:
        with camera_of(server, region=(40, 60, 128, 96)) as camera:
            assert (camera.region, camera.size) == ((40, 60, 128, 96), (128, 96))
            frames = driven(server, camera, 5)
        ticks_of(server, frames, lambda image: image[60:156, 40:168])
        with camera_of(server, size=(160, 120)) as camera:  # the middle
            frames = driven(server, camera, 5)
        ticks_of(server, frames, lambda image: image[60:180, 80:240])
        for place in ({"region": (300, 0, 128, 96)}, {"size": (640, 480)}):
            with pytest.raises(CaptureError, match="must lie in the sensor of 320 x 240 px, got "):
                camera_of(server, **place)


@pytest.mark.slow
@pytest.mark.sanitized
def test_features_are_set_and_read_back():
    def half(image):
        return np.floor(np.arange(256) / 2 + 0.5).astype(np.uint8)[image]

    with served() as server:
        features = CameraFeatures(shutter=0.005)
        with camera_of(server, features=features) as camera:
            assert camera.features == CameraFeatures(shutter=0.005, gain=0)
            ticks_of(server, driven(server, camera, 5), half)
            camera.features = CameraFeatures(shutter=0.01)  # while frames come
            assert camera.features == CameraFeatures(shutter=0.01, gain=0)
            for _ in range(10):
                camera.read()
            ticks_of(server, driven(server, camera, 5))
        for wrong, message in (
            ({"shutter": 1e6}, r"features.shutter must be a number from .* s on this camera"),
            ({"white_balance": (1, 2)}, "features.white_balance: this camera has no such"),
            ({"shutter": "auto"}, "features.shutter: this camera has no automatic one"),
            ({"exposure": 3}, "features.exposure: cameras on GigE have no such feature"),
        ):
            with pytest.raises(CaptureError, match=message):
                camera_of(server, features=CameraFeatures(**wrong))


@pytest.mark.slow
@pytest.mark.parametrize("packet_size", [576, 1500, 9000, 60_000])
def test_packets_of_any_size(packet_size):
    with served(fps=30) as server:
        with camera_of(server, query=f"?packet_size={packet_size}") as camera:
            frames = driven(server, camera, 10)
        ticks_of(server, frames)


@pytest.mark.slow
def test_it_is_found_by_its_serial_number():
    with served() as server:
        with robsim.Camera(f"gige://{server.serial}", area=server.lab.area) as camera:
            ticks_of(server, driven(server, camera, 3))
        with pytest.raises(NoCameraError, match=f"Found: {server.serial} at {ADDRESS}"):
            robsim.Camera("gige://no-such-camera.invalid")
        report = robsim.capture.find_cameras(network=True)
    assert any(
        line == f'camera on GigE: Aravis Fake {server.serial}: robsim.Camera("{URL}")'
        for line in report.found
    )


@pytest.mark.slow
@pytest.mark.sanitized
def test_nothing_is_left_of_a_closed_camera():
    with served() as server:
        with camera_of(server) as camera:
            camera.read()
        threads, files = own_threads(), open_files()
        for _ in range(20):
            with camera_of(server) as camera:
                camera.read()
        assert own_threads() <= threads
        assert open_files() <= files
    with served() as server:
        pass
    threads, files = own_threads(), open_files()
    for _ in range(10):
        with served() as server, camera_of(server) as camera:
            camera.read()
    assert own_threads() <= threads
    assert open_files() <= files


@pytest.mark.slow
def test_the_pattern_of_the_fake_camera_of_aravis():
    fake = needs_program("arv-fake-gv-camera-0.8", "aravis-tools")
    with program(fake, "-i", ADDRESS, "-s", "FAKE1"):
        wait_for_camera()
        with robsim.Camera(f"{URL}?format=Mono8") as camera:
            frames = [camera.read()]
            began = time.monotonic()
            frames += [camera.read() for _ in range(29)]
            lasted = time.monotonic() - began
            assert camera.size == (512, 512)
            assert camera.counts.torn < 15
    v, u = np.mgrid[:512, :512]
    steps = []
    for frame in frames:
        first = int(frame.image[0, 0, 0])  # (u + v + number of the frame) mod 255
        pattern = (u + v + first) % 255
        assert np.array_equal(frame.image, np.repeat(pattern[..., None], 3, axis=2))
        steps.append(first)
    # Each is a step on, at 25 frames/s at most: a slow machine has fewer. 65535 is followed by 1,
    # which is 1 more mod 255.
    moved = np.cumsum(np.mod(np.diff(steps), 255))
    times = np.array([frame.t - frames[0].t for frame in frames[1:]])
    assert np.diff(moved, prepend=0).min() >= 1
    assert (25 * times >= moved - 1.5).all()
    assert (np.diff(times, prepend=0) > 0).all()
    assert times[-1] < lasted + 0.5


@pytest.mark.slow
def test_lost_packets_tear_frames_and_none_of_them_is_seen():
    fake = needs_program("arv-fake-gv-camera-0.8", "aravis-tools")
    with program(fake, "-i", ADDRESS, "-r", "5"):  # of 1000
        wait_for_camera()
        with robsim.Camera(f"{URL}?format=Mono8&packet_size=8000") as camera:
            end = time.monotonic() + 4
            frames = []
            while time.monotonic() < end:
                frames.append(camera.read(timeout=3))
            counts = camera.counts
    assert counts.torn >= 2
    v, u = np.mgrid[:512, :512]
    for frame in frames:
        assert np.array_equal(frame.image[..., 1], (u + v + int(frame.image[0, 0, 0])) % 255)
    # What is missing is in the numbers of the frames, too.
    assert frames[-1].index + 1 >= len(frames) + counts.torn - 1
