"""Frames at known poses, through every way in which they can come."""

import threading

import pytest

import posed_frames
import robsim
from mjpeg_server import MjpegServer, jpeg
from posed_frames import AREA, POSES, SIZE, difference, true_difference
from python_devices import PATIENT, SteppedCamera
from robsim.lab import EndOfStream

pytestmark = [pytest.mark.threads, pytest.mark.long]

_LOSSY = 0.3  # px of the work area, at a quality of 95


def images():
    return [frame.image for frame in posed_frames.frames()]


@pytest.fixture
def folder(tmp_path):
    for k, image in enumerate(images()):
        robsim.vision.save_image(tmp_path / f"frame{k}.png", image)
    return tmp_path


@pytest.fixture
def video(tmp_path):
    pytest.importorskip("cv2")
    file = tmp_path / "run.mkv"
    robsim.vision.save_video(file, images(), fps=25)
    return file


def played(source, dt, **options):
    """Play frames in real time: a machine that is busy may drop some, and never the last."""
    with robsim.Camera(source, area=AREA, **PATIENT | options) as camera:
        assert (camera.size, camera.area) == (SIZE, AREA)
        assert camera.dt == pytest.approx(dt)
        frames = list(camera)
    assert frames[-1].index == 3
    for frame in frames:
        assert frame.t == pytest.approx(dt * frame.index, abs=1e-9)
        assert frame.t_arrival >= frame.t
        assert difference(frame, frame.index) == (0, 0)
    assert camera.counts.delivered == len(frames)
    assert camera.counts.grabbed == len(POSES)
    return frames, camera


def test_a_folder_is_played_at_the_rate_that_is_given(folder):
    frames, camera = played(folder, 1 / 20, fps=20)
    assert all(true_difference(frame, frame.index) < 1.5 for frame in frames)
    with pytest.raises(ValueError, match="closed"):
        camera.read()


def test_a_video_without_loss_is_played_at_its_own_rate(video):
    played(video, 1 / 25)


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
        robsim.Camera(server.url, back_end=back_end, area=AREA, **PATIENT) as camera,
    ):
        for _ in range(6):
            frame = camera.read()
            off, turned = difference(frame, frame.index % 4)
            assert off < _LOSSY
            assert turned < 0.01
            permits.release()


@pytest.mark.parametrize("bgr", [False, True])
def test_a_camera_in_python(bgr):
    source = SteppedCamera(images(), bgr, permits=1)
    with robsim.Camera(source, area=AREA, **PATIENT) as camera:
        for k in range(4):
            frame = camera.read()
            assert (frame.index, difference(frame, k)) == (k, (0, 0))
            source.permits.release()
        with pytest.raises(EndOfStream, match="over"):
            camera.read()
    assert source.calls == ["open", "close"]


def test_each_nth_frame():
    source = SteppedCamera(images() * 3, permits=1)
    with robsim.Camera(source, every=4, fps=30, **PATIENT) as camera:
        assert camera.dt == pytest.approx(4 / 30)
        source.permits.release(8)
        seen = [camera.read().index]
        while seen[-1] < 8:
            seen.append(camera.read().index)
    assert set(seen) <= {0, 4, 8}
