"""What an HTTP camera can do wrong, and what a reader gets then: words, and never a torn image."""

import base64
import hashlib
import socket
import threading
from urllib import request

import numpy as np
import pytest

import posed_frames
import robsim
from mjpeg_server import MjpegServer, jpeg
from posed_frames import AREA, difference
from python_devices import PATIENT, read_on
from robsim.lab import (
    CaptureError,
    FrameTimeoutError,
    NoCameraError,
    NoPermissionError,
    UnpluggedError,
)
from robsim.lab.cameras._devices import process
from robsim.lab.cameras._devices.http import Parts
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
        ("401 No\r\nWWW-Authenticate: Negotiate", NoCameraError, "Negotiate"),
        ("302 Found\r\nLocation: /other", NoCameraError, "loop"),
        ("302 Found\r\nLocation: file:///etc/hostname", NoCameraError, "file:///etc/hostname"),
        ("302 Found\r\nLocation: ftp://127.0.0.1/a", NoCameraError, "ftp"),
        ("200 OK\r\nContent-Type: text/html", CaptureError, "text/html"),
        ("200 OK\r\nContent-Type: multipart/x-mixed-replace", CaptureError, "not an MJPEG stream"),
        (None, NoCameraError, "no valid HTTP answer"),
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


@pytest.mark.parametrize("is_separate", [True, False])
def test_it_is_opened_again_if_that_is_asked_for(is_separate, monkeypatch):
    monkeypatch.setattr(process, "is_possible", lambda: is_separate)
    with MjpegServer(images) as server, opened(server, reopen=True) as camera:
        wait_for(lambda: camera.counts.reopened and camera.counts.grabbed >= 5)
    assert len(server.requests) >= 2


def redirect(url):
    return f"HTTP/1.0 302 Found\r\nLocation: {url}\r\nContent-Length: 0\r\n\r\n".encode()


CHALLENGES = {
    "Basic": 'Basic realm="camera"',
    "Digest": 'Digest realm="camera", nonce="abc", qop="auth"',
    "Digest of RFC 2069": 'Digest realm="camera", nonce="abc"',
}


def unauthorized(challenge):
    head = f"HTTP/1.0 401 Unauthorized\r\nWWW-Authenticate: {challenge}"
    return f"{head}\r\nContent-Length: 0\r\n\r\n".encode()


def digest(*parts):
    return hashlib.md5(":".join(parts).encode()).hexdigest()


def is_login(said, path):
    """Whether a header has the login of user me with password p@ss."""
    if said.startswith("Basic "):
        return base64.b64decode(said[6:]) == b"me:p@ss"
    told = request.parse_keqv_list(request.parse_http_list(said.removeprefix("Digest ")))
    ends = digest("me", "camera", "p@ss"), digest("GET", path)
    between = [told[name] for name in ("nonce", "nc", "cnonce", "qop") if name in told]
    return told["response"] == digest(ends[0], *between, ends[1])


def with_login(server):
    return server.url.replace("http://", "http://me:p%40ss@")


@pytest.mark.parametrize("challenge", CHALLENGES)
def test_user_and_password_are_sent_where_they_are_asked_for(challenge):
    def answer(path, headers):
        said = headers["Authorization"]
        return None if said and is_login(said, path) else unauthorized(CHALLENGES[challenge])

    with (
        MjpegServer(images, answer=answer) as server,
        robsim.Camera(with_login(server), **PATIENT) as camera,
    ):
        camera.read()
    assert [headers["Authorization"] is not None for headers in server.requests] == [False, True]


def test_a_wrong_password_ends_soon():
    asks = unauthorized(CHALLENGES["Digest"])
    with MjpegServer(answer=asks) as server, pytest.raises(NoPermissionError) as error:
        robsim.Camera(with_login(server), **PATIENT)
    assert "p@ss" not in str(error.value)


def test_a_redirect_is_followed_and_its_text_is_not_read():
    def answer(path, headers):
        if path == "/moved":
            return None
        return redirect("/moved").replace(b"Content-Length: 0", b"Transfer-Encoding: chunked")

    with MjpegServer(images, answer=answer) as server, opened(server) as camera:
        assert camera.read().index >= 0


def test_no_other_host_gets_the_password():
    with MjpegServer(answer=unauthorized(CHALLENGES["Basic"])) as other:
        answer = redirect(other.url)
        with MjpegServer(answer=answer) as server, pytest.raises(NoPermissionError):
            robsim.Camera(with_login(server), **PATIENT)
        assert other.requests
        assert not any(headers["Authorization"] for headers in other.requests)


@pytest.mark.parametrize("kind", ["application/octet-stream", "multipart/x-mixed-replace"])
def test_a_boundary_that_only_the_stream_tells(kind):
    body = b"".join(b"--b\r\n\r\n" + image + b"\r\n" for image in images())
    answer = f"HTTP/1.0 200 OK\r\nContent-Type: {kind}\r\n\r\n".encode() + b"\r\n" + body
    with MjpegServer(answer=answer) as server, opened(server) as camera:
        assert read_on(camera)[0][-1].index == 3
        assert camera.counts.torn == 0


def test_a_single_image_is_told():
    answer = b"HTTP/1.0 200 OK\r\nContent-Type: image/jpeg\r\n\r\n" + images()[0]
    with (
        MjpegServer(answer=answer) as server,
        pytest.raises(CaptureError, match="a single image"),
    ):
        opened(server)


def test_it_is_read_in_this_process_where_there_can_be_no_other(monkeypatch):
    monkeypatch.setattr(process, "is_possible", lambda: False)
    before = threading.active_count()

    def parts():
        yield images()[0]
        yield server.released.wait

    with MjpegServer(parts) as server:
        with opened(server) as camera:
            assert difference(camera.read(), 0)[0] < 0.3
            assert threading.active_count() > before + 1
        wait_for(lambda: threading.active_count() <= before + 2)  # the others are the server's


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


def commented(image):
    """Return it with a comment that looks like the next part."""
    comment = b"\r\n--frame\r\nContent-Type: image/jpeg\r\n\r\n\xff\xd9"
    return image[:2] + b"\xff\xfe" + (2 + len(comment)).to_bytes(2, "big") + comment + image[2:]


def test_images_are_the_same_however_they_come(rng):
    for _ in range(16):
        bodies = [images()[int(k)] for k in rng.integers(0, 4, 6)]
        bodies = [commented(body) if rng.random() < 0.3 else body for body in bodies]
        data = b""
        for body in bodies:
            end = ("\r\n", "\n")[int(rng.integers(2))]
            length = f"Content-Length: {len(body)}{end}" if rng.random() < 0.5 else ""
            head = f"--frame{end}{length}Content-Type: image/jpeg{end}{end}"
            data += head.encode() + body + (end.encode() if rng.random() < 0.8 else b"")
        parts, step = Parts(b"--frame"), int(rng.integers(3, 90)) ** 2
        pieces = (data[start : start + step] for start in range(0, len(data), step))
        found = [body for piece in pieces for body in parts.feed(piece)]
        assert [body.rstrip(b"\r\n") for body in found] == bodies


def test_what_has_no_end_does_not_fill_the_memory():
    for head in (b"", b"--frame\r\n", b"--frame\r\n\r\n"):
        parts, piece = Parts(b"frame"), bytes(1 << 24)
        bodies = [len(body) for data in (head, *[piece] * 12) for body in parts.feed(data)]
        assert sum(bodies) + len(parts._data) < 1 << 28
        assert len(parts._data) < 1 << 27


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
