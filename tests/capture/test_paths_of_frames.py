"""Frames at known poses, through every way in which they can come."""

import threading
import time

import numpy as np
import pytest

import posed_frames
import robsim
from mjpeg_server import MjpegServer, jpeg
from posed_frames import AREA, POSES, SIZE, difference, true_difference
from python_cameras import SteppedCamera
from robsim.capture import EndOfStream

pytestmark = [pytest.mark.threads, pytest.mark.long]

_LOSSY = 0.3  # px of the work area, at a quality of 95


def images():
    return [frame.image for frame in posed_frames.frames()]


@pytest.fixture
def folder(tmp_path):
    for k, image in enumerate(images()):
        robsim.imaging.save_image(tmp_path / f"frame{k}.png", image)
    return tmp_path


@pytest.fixture
def video(tmp_path):
    pytest.importorskip("cv2")
    file = tmp_path / "run.mkv"
    robsim.imaging.save_video(file, images(), fps=25)
    return file


def played(source, **options):
    with robsim.Camera(source, area=AREA, **options) as camera:
        assert camera.size == SIZE
        assert camera.area == AREA
        return list(camera), camera


def test_a_folder_is_played_at_the_rate_that_is_given(folder):
    frames, camera = played(folder, fps=20)
    assert [frame.index for frame in frames] == [0, 1, 2, 3]
    np.testing.assert_allclose([frame.t for frame in frames], np.arange(4) / 20, atol=1e-9)
    assert camera.dt == 1 / 20
    for k, frame in enumerate(frames):
        assert difference(frame, k) == (0, 0)
        assert true_difference(frame, k) < 1.5
        assert frame.t_arrival >= frame.t
    with pytest.raises(ValueError, match="camera is closed"):
        camera.read()


def test_a_video_without_loss_is_played_at_its_own_rate(video):
    begun = time.monotonic()
    frames, camera = played(video)
    assert time.monotonic() - begun >= 3 / 25
    assert camera.dt == pytest.approx(1 / 25)
    for frame in frames:
        assert difference(frame, frame.index) == (0, 0)
    assert camera.counts.delivered == len(frames)
    assert camera.counts.grabbed == len(POSES)


def test_the_end_of_a_file_is_an_error_of_read_and_none_of_a_loop(folder):
    with robsim.Camera(folder, fps=1000) as camera:
        for _ in camera:
            pass
        with pytest.raises(EndOfStream, match="is over"):
            camera.read()


@pytest.mark.parametrize("back_end", ["http", "ffmpeg"])
@pytest.mark.parametrize("has_length", [True, False])
def test_mjpeg_over_http(back_end, has_length):
    if back_end == "ffmpeg":
        pytest.importorskip("cv2")
    # Without a length FFmpeg sees the end of an image when the next one begins.
    permits = threading.Semaphore(1 if back_end == "http" else 2)

    def parts():
        for image in [*map(jpeg, images())] * 2:
            yield permits.acquire
            yield image, len(image) if has_length else None
        yield server.released.wait

    with (
        MjpegServer(parts) as server,
        robsim.Camera(server.url, back_end=back_end, area=AREA, open_timeout=60) as camera,
    ):
        for _ in range(6):
            frame = camera.read(10)
            off, turned = difference(frame, frame.index % 4)
            assert off < _LOSSY
            assert turned < 0.01
            permits.release()


@pytest.mark.parametrize("bgr", [False, True])
def test_a_camera_in_python(bgr):
    source = SteppedCamera(images(), bgr)
    source.permits.release()
    with robsim.Camera(source, area=AREA) as camera:
        for k in range(4):
            frame = camera.read(10)
            assert (frame.index, difference(frame, k)) == (k, (0, 0))
            source.permits.release()
        with pytest.raises(EndOfStream, match="over"):
            camera.read(10)
    assert source.calls == ["open", "close"]


def test_a_plane_map_replaces_that_of_the_area():
    source = SteppedCamera(images())
    source.permits.release()
    plane_map = robsim.imaging.PlaneMap.scaled(SIZE, (1200, 960))
    with robsim.Camera(source, area=AREA, plane_map=plane_map) as camera:
        frame = camera.read(10)
    assert frame.plane_map == plane_map


def test_each_nth_frame():
    source = SteppedCamera(images() * 3)
    source.permits.release()
    with robsim.Camera(source, every=4, fps=30) as camera:
        assert camera.dt == pytest.approx(4 / 30)
        source.permits.release(8)
        seen = [camera.read(10).index]
        while seen[-1] < 8:
            seen.append(camera.read(10).index)
    assert set(seen) <= {0, 4, 8}


def test_an_experiment_takes_it(folder):
    with robsim.Camera(folder, fps=20, area=AREA) as camera:
        trace = robsim.Experiment(camera, seed=1).run()
    assert trace.t == pytest.approx(np.arange(len(trace)) / 20)
    for pose, true in zip(trace.pose_measured, POSES, strict=True):
        assert np.hypot(*(pose[:2] - true[:2])) < 1.5
