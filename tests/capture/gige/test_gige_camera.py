"""GigE Vision: frames of cameras, and invalid replies of cameras."""

import _thread
import itertools
import os
import re
import signal
import struct
import subprocess
import threading
from contextlib import suppress

import numpy as np
import pytest

import robsim
from commands import command
from gige_between import DISCOVERY, LEADER, READ_MEMORY, between
from gige_between import URL as BETWEEN
from gige_cameras import (
    ADDRESS,
    URL,
    camera_of,
    driven,
    measured,
    opened,
    served,
    through,
    ticks_of,
    wait_for_camera,
)
from robsim.lab import (
    CameraBusyError,
    CameraFeatures,
    CaptureError,
    FrameTimeoutError,
    NoCameraError,
)
from sizes import thorough
from surroundings import needs_extension, needs_program
from waiting import wait_for

# --- frames of the simulated lab


def held():
    """Threads and open files of this process."""
    return len(os.listdir("/proc/self/task")), len(os.listdir("/proc/self/fd"))


def is_busy(server):
    try:
        robsim.Camera(server.url).close()
    except CameraBusyError:
        return True
    except NoCameraError:  # it was late with an answer
        return False
    raise AssertionError("two programs have the camera")


def test_nobody_at_the_address():
    with pytest.raises(NoCameraError, match=r"127\.0\.0\.1"):
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
@pytest.mark.sanitized
def test_frames_are_those_of_the_lab_after_a_stall_too_and_poses_are_right(server):
    with camera_of(server, frame_timeout=0.5) as camera:
        assert (camera.coding, camera.region) == ("rgb8", (0, 0, 320, 240))
        assert camera.dt == pytest.approx(server.lab.dt, rel=1e-3)
        # The numbers of Aravis' fake camera begin at 65400, and end at 65535.
        frames = driven(server, camera, 150)
        assert camera.counts.torn < 60_000  # none is taken for lost where they begin anew
        before = camera.counts.timeouts
        server.lab.stall(300)
        wait_for(lambda: camera.counts.timeouts > before)
        with suppress(FrameTimeoutError):
            while True:  # one may be there
                frames.append(camera.read(0.1))
        server.lab.stall(0)
        wait_for(lambda: is_busy(server))
        frames += driven(server, camera, 10)
    ticks, truth = ticks_of(server, frames), server.lab.truth
    assert np.ptp(truth.pose[ticks, 0]) > 1  # it has moved
    errors = [
        np.hypot(*(measured(frame)[:2] - truth.pose[tick, :2]))
        for tick, frame in zip(ticks, frames, strict=True)
    ]
    # The largest stays below half a pixel of the frame, which has 3.75 px of the work area.
    assert np.median(errors) < 0.5
    assert max(errors) < 3.75 / 2
    for tick, frame in zip(ticks, frames, strict=True):
        # The device's own clock says when, and never before it was.
        assert truth.t[tick] <= frame.epoch + frame.t <= frame.epoch + frame.t_arrival
    assert server.sent_frames >= 160


WAYS = [
    # pixel format, size of packets, part of the frame, options
    ("BayerRG8", 576, (0, 0, 320, 240), {"coding": "raw8"}),
    ("Mono8", 8000, (0, 0, 320, 240), {"coding": "mono8"}),
    ("BayerGR8", 1500, (40, 60, 128, 96), {"region": (40, 60, 128, 96)}),
    ("BayerGB8", 9000, (80, 60, 160, 120), {"size": (160, 120)}),  # the middle
    *thorough([("BayerBG8", 60_000, (80, 60, 160, 120), {})], []),  # the part stays
]


@pytest.mark.slow
@pytest.mark.sanitized
def test_formats_packets_and_regions_show_the_lab_and_nothing_is_left(server):
    kept = []
    for pixel_format, packet_size, region, options in WAYS:
        left, top, width, height = region
        query = f"?packet_size={packet_size}"
        if "coding" not in options:
            query += f"&format={pixel_format}"

        def sent_as(image):
            part = image[top : top + height, left : left + width]  # noqa: B023
            return through(pixel_format)(np.ascontiguousarray(part))  # noqa: B023

        with camera_of(server, query=query, **options) as camera:
            assert (camera.region, camera.size) == (region, (width, height))
            assert camera._device.info["format"] == pixel_format  # by the camera's own table
            frames = driven(server, camera, 8)
        ticks = ticks_of(server, frames, sent_as)
        if pixel_format == "Mono8":
            assert all((frame.image == frame.image[..., :1]).all() for frame in frames)
        elif width == 320:
            poses = server.lab.truth.pose[ticks]
            for pose, frame in zip(poses, frames, strict=True):
                # 0.4 px of the frame, which the means of neighbours cost.
                assert np.hypot(*(measured(frame)[:2] - pose[:2])) < 1.5
        kept.append(held())
    # Of threads and descriptors; what other tests had may still be ending.
    wait_for(lambda: all(now <= then for now, then in zip(held(), kept[1], strict=True)))


@pytest.mark.slow
@pytest.mark.sanitized
def test_what_the_camera_has_not_is_refused(server):
    with pytest.raises(ValueError, match="coding"):
        camera_of(server, coding="yuv411")
    with pytest.raises(CaptureError, match=r"RGB8, Bayer.*got yuv422"):
        camera_of(server, coding="yuv422")
    with pytest.raises(CaptureError, match="320 x 240 px"):
        camera_of(server, region=(300, 0, 128, 96))


@pytest.mark.slow
@pytest.mark.sanitized
def test_features_are_set_and_read_back(server):
    def half(image):
        return np.floor(np.arange(256) / 2 + 0.5).astype(np.uint8)[image]

    with camera_of(server, features=CameraFeatures(shutter=0.005)) as camera:
        assert camera.features == CameraFeatures(shutter=0.005, gain=0)
        ticks_of(server, driven(server, camera, 5), half)
        camera.features = CameraFeatures(shutter=0.01)  # while frames come
        assert camera.features == CameraFeatures(shutter=0.01, gain=0)
        for _ in range(10):
            camera.read()
        ticks_of(server, driven(server, camera, 5))
        for wrong in (
            {"shutter": 1e6},
            {"white_balance": (1, 2)},
            {"shutter": "auto"},
            {"exposure": 3},
        ):
            with pytest.raises(CaptureError, match=rf"features\.{next(iter(wrong))}\b"):
                camera.features = CameraFeatures(**wrong)
        assert camera.features == CameraFeatures(shutter=0.01, gain=0)


@pytest.mark.slow
def test_it_is_found_by_its_serial_number_and_keeps_the_rate_of_its_world(server):
    # The rate of the world is 100.
    with opened(f"gige://{server.serial}", area=server.lab.area, fps=10) as camera:
        frames = driven(server, camera, 5)
        while np.diff(ticks_of(server, frames)).min() > 3:
            frames += driven(server, camera, 5)
    with pytest.raises(NoCameraError, match=f"{server.serial} at {ADDRESS}"):
        robsim.Camera("gige://no-such-camera.invalid")
    report = robsim.lab.find_cameras(network=True)
    assert any(server.serial in line and f'robsim.Camera("{URL}")' in line for line in report.found)


@pytest.mark.slow
def test_the_tool_of_aravis_reads_it(server):
    tool = needs_program("arv-camera-test-0.8", "aravis-tools")
    wait_for_camera()
    words = [tool, "--duration=1", "--no-packet-socket", "-n", ADDRESS, "-a"]

    def n_completed():
        said = subprocess.run(words, capture_output=True, text=True, timeout=300).stdout
        assert re.search(r"image width\s*= 320\n", said)
        return int(re.search(r"n_completed_buffers\s*= (\d+)\n", said)[1])

    wait_for(n_completed)


@pytest.mark.slow
def test_live_drives_the_robot(server, tmp_path):
    words = ("live", "--camera", server.url, "--motors", f"udp:{server.lab.address}")
    words += ("--area", "{}x{}".format(*server.lab.area), "--steps", "200")
    words += ("--control", "go-to-point:900,600")
    words += ("--frame-timeout", "100", "--no-record", "--out", str(tmp_path))
    wait_for(lambda: command(*words).exit_code == 0)  # it may not be reached at once
    track = robsim.Trace.load(tmp_path / "trace.npz").pose_measured
    assert abs(track[-1, :2] - track[0, :2]).max() > 10


# --- invalid replies


VENDOR = 0x48  # register
NO_UTF8 = b"\xff\xe9" * 32


def with_odd_names(command, address, packet):
    """A camera whose vendor and model are no UTF-8."""
    if command != DISCOVERY:
        return packet
    return packet[: 8 + VENDOR] + NO_UTF8 + packet[8 + VENDOR + len(NO_UTF8) :]


def announced(width, height):
    """Let frames tell another size than they have."""

    def sent(packet):
        if packet[4] & 0x7F != LEADER:
            return packet
        return packet[:24] + struct.pack(">II", width, height) + packet[32:]

    return sent


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_frame_without_a_size():
    with (
        served(fps=10),
        between(with_odd_names, sent=announced(0, 0)),
        pytest.raises(CaptureError, match="no frame"),
    ):
        opened(BETWEEN)


@pytest.mark.slow
@pytest.mark.sanitized
def test_a_frame_that_is_smaller_than_it_tells_is_torn():
    numbers = itertools.count()
    change = announced(2**31 - 1, 2**31 - 1)

    def sent(packet):
        is_leader = packet[4] & 0x7F == LEADER
        return change(packet) if is_leader and next(numbers) % 2 else packet

    with served(), between(sent=sent), opened(BETWEEN) as camera:
        while camera.counts.torn < 3:
            assert camera.read(300).image.shape == (240, 320, 3)
    with (
        served(),
        between(sent=change),
        pytest.raises(FrameTimeoutError),
    ):
        opened(BETWEEN, open_timeout=2)


@pytest.mark.slow
def test_frames_that_no_memory_holds():
    # The camera's XML has a formula of the bytes of a frame.
    def answer(command, _, packet):
        if command != READ_MEMORY:
            return packet
        return packet[:12] + packet[12:].replace(b"* HEIGHT *", b"* 999999 *")

    with served(fps=10), between(answer), pytest.raises(CaptureError, match="268435456"):
        opened(BETWEEN)


@pytest.mark.slow
def test_ctrl_c_ends_the_wait_for_a_camera_that_only_says_that_it_will_answer():
    # GigE Vision: PENDING_ACK, which asks for so many ms of patience.
    asked = threading.Event()

    def answer(command, address, packet):
        if command == DISCOVERY:
            return packet
        asked.set()
        return struct.pack(">HHH", 0, 0x89, 4) + packet[6:8] + struct.pack(">HH", 0, 65535)

    def interrupt():
        if asked.wait(300):
            _thread.interrupt_main()

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with served(fps=10), between(answer):
            thread = threading.Thread(target=interrupt)
            thread.start()
            with pytest.raises(KeyboardInterrupt):
                opened(BETWEEN)
            thread.join()
    finally:
        signal.signal(signal.SIGINT, before)
