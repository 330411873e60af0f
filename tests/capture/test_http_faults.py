"""What an HTTP camera can do wrong, and what a reader gets then: words, and never a torn image."""

import contextlib
import ctypes
import socket
import threading
import time

import numpy as np
import pytest

import posed_frames
import robsim
import sanitizers
from mjpeg_server import MjpegServer, jpeg
from posed_frames import AREA, difference
from python_cameras import read_on
from robsim import _core
from robsim.capture import (
    CaptureError,
    FrameTimeoutError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from robsim.capture._devices.http import HttpCamera

pytestmark = [pytest.mark.threads, pytest.mark.long]


def images():
    return [jpeg(frame.image) for frame in posed_frames.frames()]


@pytest.fixture(params=["http", "ffmpeg"])
def back_end(request):
    if request.param == "ffmpeg":
        pytest.importorskip("cv2")
    return request.param


def answer(text):
    return f"HTTP/1.0 {text}\r\nContent-Length: 0\r\n\r\n".encode()


@pytest.mark.parametrize(
    ("said", "kind", "words"),
    [
        ("404 Not Found", NoCameraError, "answers 404 Not Found: is the path right"),
        ("401 Unauthorized", NoPermissionError, "answers 401: give user and password"),
        ("302 Found\r\nLocation: /other", NoCameraError, "answers 302 Found /other"),
        ("200 OK\r\nContent-Type: text/html", CaptureError, "sends text/html and no MJPEG"),
        ("200 OK\r\nContent-Type: multipart/x-mixed-replace", CaptureError, "no MJPEG stream"),
    ],
)
def test_another_answer_is_told(said, kind, words):
    with MjpegServer(answer=answer(said)) as server, pytest.raises(CaptureError) as error:
        robsim.Camera(server.url)
    assert type(error.value) is kind
    assert words in str(error.value)


def test_an_ffmpeg_stream_that_is_none(back_end):
    with MjpegServer(answer=answer("404 Not Found")) as server, pytest.raises(NoCameraError):
        robsim.Camera(server.url, back_end=back_end)


def test_what_speaks_no_http():
    words = "no answer of HTTP: is it a camera"
    with (
        MjpegServer(answer=b"SSH-2.0-OpenSSH\r\n") as server,
        pytest.raises(NoCameraError, match=words),
    ):
        robsim.Camera(server.url)


def test_nobody_there(back_end):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and never listens
        url = f"http://127.0.0.1:{taken.getsockname()[1]}/"
        with pytest.raises(NoCameraError, match=r"cannot be reached .*refused"):
            robsim.Camera(url, back_end=back_end)


def test_a_mute_server():
    with MjpegServer(is_mute=True) as server, pytest.raises(FrameTimeoutError) as error:
        robsim.Camera(server.url, open_timeout=0.2)
    assert "within" in str(error.value)
    assert "0.2 s: is it on" in str(error.value) or "open_timeout = 0.2 s" in str(error.value)


def test_a_stall_is_a_time_out_and_the_stream_goes_on_after_it():
    goes_on = threading.Event()

    def parts():
        yield from images()[:1]
        yield goes_on.wait
        yield from images()[1:2]
        yield server.released.wait

    with MjpegServer(parts) as server, robsim.Camera(server.url, area=AREA) as camera:
        camera.read()
        for _ in range(2):
            with pytest.raises(TimeoutError, match="it can be tried again"):
                camera.read(0.05)
        goes_on.set()
        assert difference(camera.read(10), 1)[0] < 0.3


def test_the_end_of_the_stream_comes_after_its_last_image(back_end):
    with MjpegServer(images) as server, robsim.Camera(server.url, back_end=back_end) as camera:
        frames, error = read_on(camera)
        assert isinstance(error, UnpluggedError)
        assert frames[-1].index == 3
        with pytest.raises(UnpluggedError):
            camera.read(10)
    assert "http://127.0.0.1" in str(error)


def test_it_is_opened_again_if_that_is_asked_for():
    with MjpegServer(images) as server, robsim.Camera(server.url, reopen=True) as camera:
        while camera.counts.reopened < 1 or camera.counts.grabbed < 5:
            with contextlib.suppress(FrameTimeoutError):
                camera.read(0.1)
    assert len(server.requests) >= 2


def test_user_and_password():
    with MjpegServer(images) as server:
        url = server.url.replace("http://", "http://me:p%40ss@")
        with robsim.Camera(url) as camera:
            camera.read()
    assert server.requests[0]["Authorization"] == "Basic bWU6cEBzcw=="


def test_a_size_that_changes_is_an_error():
    other = jpeg(np.zeros((64, 48, 3), np.uint8))
    goes_on = threading.Event()
    parts = [images()[0], goes_on.wait, other]
    with MjpegServer(parts) as server, robsim.Camera(server.url) as camera:
        camera.read()
        goes_on.set()
        assert "have 48 x 64 px in place of 300 x 240 px" in str(read_on(camera)[1])


def test_another_size_than_asked_for():
    words = "have 300 x 240 px in place of 640 x 480 px"
    with MjpegServer(images) as server, pytest.raises(CaptureError, match=words):
        robsim.Camera(server.url, size=(640, 480))


def halved(image):
    return image[: len(image) // 2]


TEARS = {
    "cut, and the length says so": lambda image, other: (halved(image), len(image) // 2),
    "cut, without a length": lambda image, other: (halved(image), None),
    "cut, with an end marker": lambda image, other: (halved(image) + b"\xff\xd9", None),
    "a piece is missing": lambda image, other: (image[:2000] + image[2600:], None),
    "the next one in the middle of it": lambda image, other: (halved(image) + other, None),
    "other bytes in it": lambda image, other: (image[:2500] + bytes(300) + image[2800:], None),
    "garbage": lambda image, other: (b"hello" * 1000, 5000),
    "nothing": lambda image, other: (b"", 0),
}


@pytest.mark.slow
@pytest.mark.sanitized
@pytest.mark.parametrize("tear", TEARS)
def test_a_torn_image_reaches_nobody(tear, back_end):
    whole = images()

    def parts():
        for k in range(8):
            yield TEARS[tear](whole[k % 4], whole[(k + 1) % 4]) if k % 2 else whole[k % 4]

    with MjpegServer(parts) as server, robsim.Camera(server.url, back_end=back_end) as camera:
        frames, _ = read_on(camera)
        counts = camera.counts
    for frame in frames:
        assert min(np.abs(frame.image - i.astype(int)).max() for i in originals()) < 60
    if tear == "nothing" and back_end == "ffmpeg":  # which takes it for the end of the stream
        assert (counts.grabbed, counts.torn) == (1, 0)
        return
    assert counts.torn >= 3
    assert counts.grabbed == 4


def originals():
    return [frame.image for frame in posed_frames.frames()]


def test_a_length_that_is_too_long_costs_that_image_and_no_more():
    whole = images()
    with MjpegServer([whole[0], (halved(whole[1]), len(whole[1])), whole[2]]) as server:
        camera = robsim.Camera(server.url)
        frames, _ = read_on(camera)
        camera.close()
    assert frames[-1].index == 2
    assert camera.counts.torn == 1


def in_chunks(data, rng):
    """Return data in chunks of HTTP."""
    pieces = []
    while data:
        n = int(rng.integers(1, 3000))
        pieces.append(b"%X\r\n%s\r\n" % (len(data[:n]), data[:n]))
        data = data[n:]
    return b"".join(pieces)


@pytest.mark.parametrize("is_chunked", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_images_are_the_same_however_they_come(seed, is_chunked):
    rng = np.random.default_rng(seed)
    bodies = [images()[int(k)] for k in rng.integers(0, 4, 6)]
    data = b""
    for body in bodies:
        end = ("\r\n", "\n")[int(rng.integers(2))]
        length = f"Content-Length: {len(body)}{end}" if rng.random() < 0.5 else ""
        head = f"--frame{end}{length}Content-Type: image/jpeg{end}{end}"
        data += head.encode() + body + (end.encode() if rng.random() < 0.8 else b"")
    if is_chunked:
        data = in_chunks(data, rng)
    found = []
    camera, reader = socket.socketpair()
    with camera, reader:
        stream = _core.ImageStream(
            reader.fileno(), boundary=b"frame", begun=b"", is_chunked=is_chunked, name="it"
        )
        for start in range(0, len(data), step := int(rng.integers(1, 90)) ** 2):
            camera.sendall(data[start : start + step])
        camera.close()
        while sum(bool(jpeg) + n_passed for jpeg, _, n_passed, _ in found) < len(bodies):
            found.append(stream.take(10))
        with pytest.raises(UnpluggedError, match="it has ended the stream"):
            stream.take(10)
    assert found[-1][0] == bodies[-1]
    assert not any(n_torn for *_, n_torn in found)


def test_a_camera_that_answers_in_chunks():
    # As the example of the ESP32-CAM does: boundary, head and image are a chunk each.
    def answer():
        kind = "multipart/x-mixed-replace;boundary=0987"
        said = f"HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nTransfer-Encoding: chunked\r\n\r\n"
        chunks = []
        for image in images():
            head = f"Content-Type: image/jpeg\r\nContent-Length: {len(image)}\r\n\r\n".encode()
            chunks += [b"\r\n--0987\r\n", head, image]
        return said.encode() + b"".join(b"%x\r\n%s\r\n" % (len(c), c) for c in chunks)

    with MjpegServer(answer=answer()) as server, robsim.Camera(server.url, area=AREA) as camera:
        frames, _ = read_on(camera)
        assert camera.counts.torn == 0
    assert frames[-1].index == 3
    assert difference(frames[-1], 3)[0] < 0.3


def test_images_are_read_while_somebody_keeps_the_interpreter():
    hold = ctypes.PyDLL(None).usleep
    camera, reader = socket.socketpair()
    with camera, reader:
        stream = _core.ImageStream(
            reader.fileno(), boundary=b"frame", begun=b"", is_chunked=False, name="it"
        )
        sent = time.monotonic()
        for image in images():
            camera.sendall(b"--frame\r\nContent-Length: %d\r\n\r\n%s\r\n" % (len(image), image))
        hold(2_000_000 if sanitizers.THREAD else 300_000)  # us
        held = time.monotonic()
        jpeg, arrived, n_passed, _ = stream.take(0)
    assert jpeg == images()[-1]
    assert n_passed == 3
    assert sent <= arrived < held


def test_an_address_of_ipv6_is_named_as_such():
    assert HttpCamera("http://me:secret@[::1]:8080/v", 1.0).name == "http://[::1]:8080/v"


def test_a_camera_that_sends_torn_images_alone():
    parts = [halved(images()[0]), halved(images()[1]), lambda: server.released.wait(5)]
    words = r"no whole frame within open_timeout = 0.3 s, and 2 torn ones"
    with MjpegServer(parts) as server, pytest.raises(FrameTimeoutError, match=words):
        robsim.Camera(server.url, open_timeout=0.3)
