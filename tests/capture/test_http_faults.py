"""What an HTTP camera can do wrong, and what a reader gets then: words, and never a torn image."""

import socket
import threading

import numpy as np
import pytest

import posed_frames
import robsim
from mjpeg_server import MjpegServer, jpeg
from posed_frames import AREA, difference
from python_devices import PATIENT, read_on
from robsim import _core
from robsim.lab import (
    CaptureError,
    FrameTimeoutError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from waiting import wait_for

pytestmark = [pytest.mark.threads, pytest.mark.long]


def originals():
    return [frame.image for frame in posed_frames.frames()]


def images():
    return [jpeg(image) for image in originals()]


@pytest.fixture(params=["http", "ffmpeg"])
def back_end(request):
    if request.param == "ffmpeg":
        pytest.importorskip("cv2")
    return request.param


def opened(server, **options):
    return robsim.Camera(server.url, area=AREA, **PATIENT | options)


@pytest.mark.parametrize(
    ("said", "kind", "words"),
    [
        ("404 Not Found", NoCameraError, "404 Not Found"),
        ("401 Unauthorized", NoPermissionError, "401"),
        ("302 Found\r\nLocation: /other", NoCameraError, "302 Found /other"),
        ("200 OK\r\nContent-Type: text/html", CaptureError, "text/html"),
        ("200 OK\r\nContent-Type: multipart/x-mixed-replace", CaptureError, "no MJPEG stream"),
        (None, NoCameraError, "no answer of HTTP"),
    ],
)
def test_another_answer_is_told(said, kind, words):
    answer = f"HTTP/1.0 {said}\r\nContent-Length: 0\r\n\r\n" if said else "SSH-2.0-OpenSSH\r\n"
    with MjpegServer(answer=answer.encode()) as server:
        with pytest.raises(CaptureError, match=words) as error:
            opened(server)
        assert type(error.value) is kind


def test_an_ffmpeg_stream_that_is_none():
    pytest.importorskip("cv2")
    answer = b"HTTP/1.0 404 Not Found\r\nContent-Length: 0\r\n\r\n"
    with MjpegServer(answer=answer) as server, pytest.raises(NoCameraError):
        opened(server, back_end="ffmpeg")


def test_nobody_there(back_end):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))  # and never listens
        url = f"http://127.0.0.1:{taken.getsockname()[1]}/"
        with pytest.raises(NoCameraError, match="refused"):
            robsim.Camera(url, back_end=back_end, **PATIENT)


def test_an_address_of_ipv6_is_named_as_such_and_a_password_is_not():
    with pytest.raises(NoCameraError, match=r"http://\[::1\]:1/v") as error:
        robsim.Camera("http://me:secret@[::1]:1/v", **PATIENT)
    assert "secret" not in str(error.value)


def test_a_mute_server():
    with MjpegServer(is_mute=True) as server, pytest.raises(FrameTimeoutError, match=r"0\.2 s"):
        opened(server, open_timeout=0.2)


def test_a_stall_is_a_time_out_and_the_stream_goes_on_after_it():
    goes_on = threading.Event()

    def parts():
        yield from images()[:1]
        yield goes_on.wait
        yield from images()[1:2]
        yield server.released.wait

    with MjpegServer(parts) as server, opened(server) as camera:
        camera.read()
        for _ in range(2):
            with pytest.raises(TimeoutError, match=r"0\.05 s"):
                camera.read(0.05)
        goes_on.set()
        assert difference(camera.read(), 1)[0] < 0.3


def test_the_end_of_the_stream_comes_after_its_last_image(back_end):
    with MjpegServer(images) as server, opened(server, back_end=back_end) as camera:
        frames, error = read_on(camera)
        assert isinstance(error, UnpluggedError)
        assert frames[-1].index == 3
        with pytest.raises(UnpluggedError):
            camera.read()
    assert "http://127.0.0.1" in str(error)


def test_it_is_opened_again_if_that_is_asked_for():
    with MjpegServer(images) as server, opened(server, reopen=True) as camera:
        wait_for(lambda: camera.counts.reopened and camera.counts.grabbed >= 5)
    assert len(server.requests) >= 2


def test_user_and_password():
    with MjpegServer(images) as server:
        url = server.url.replace("http://", "http://me:p%40ss@")
        with robsim.Camera(url, **PATIENT) as camera:
            camera.read()
    assert server.requests[0]["Authorization"] == "Basic bWU6cEBzcw=="


def test_a_size_that_changes_is_an_error():
    goes_on = threading.Event()
    parts = [images()[0], goes_on.wait, jpeg(np.zeros((64, 48, 3), np.uint8))]
    with MjpegServer(parts) as server, opened(server) as camera:
        camera.read()
        goes_on.set()
        assert "48 x 64 px instead of 300 x 240 px" in str(read_on(camera)[1])


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
def test_torn_images_reach_nobody(back_end):
    tears = [tear for name, tear in TEARS.items() if (name, back_end) != ("nothing", "ffmpeg")]
    whole = images()

    def parts():
        for k, tear in enumerate([*tears, *tears]):
            yield whole[k % 4]
            yield tear(whole[(k + 1) % 4], whole[(k + 2) % 4])
        yield whole[0]

    with MjpegServer(parts) as server, opened(server, back_end=back_end) as camera:
        frames, _ = read_on(camera)
        counts = camera.counts
    for frame in frames:
        assert min(np.abs(frame.image - i.astype(int)).max() for i in originals()) < 60
    assert counts.torn == 2 * len(tears)
    assert counts.grabbed == 2 * len(tears) + 1


def test_a_length_that_is_too_long_costs_that_image_and_no_more():
    whole = images()
    parts = [whole[0], (halved(whole[1]), len(whole[1])), whole[2]]
    with MjpegServer(parts) as server, opened(server) as camera:
        frames, _ = read_on(camera)
        assert frames[-1].index == 2
        assert camera.counts.torn == 1


def stream_of(reader, is_chunked=False):
    return _core.ImageStream(
        reader.fileno(), boundary=b"frame", begun=b"", is_chunked=is_chunked, name="it"
    )


def in_chunks(data, rng):
    """Return data in chunks of HTTP."""
    pieces = []
    while data:
        n = int(rng.integers(1, 3000))
        pieces.append(b"%X\r\n%s\r\n" % (len(data[:n]), data[:n]))
        data = data[n:]
    return b"".join(pieces)


@pytest.mark.parametrize("is_chunked", [False, True])
def test_images_are_the_same_however_they_come(rng, is_chunked):
    for _ in range(8):
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
            stream = stream_of(reader, is_chunked)
            for start in range(0, len(data), step := int(rng.integers(3, 90)) ** 2):
                camera.sendall(data[start : start + step])
            camera.close()
            while sum(bool(jpeg) + n_passed for jpeg, _, n_passed, _ in found) < len(bodies):
                found.append(stream.take(300))
            with pytest.raises(UnpluggedError):
                stream.take(300)
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

    with MjpegServer(answer=answer()) as server, opened(server) as camera:
        frames, _ = read_on(camera)
        assert camera.counts.torn == 0
    assert frames[-1].index == 3
    assert difference(frames[-1], 3)[0] < 0.3
