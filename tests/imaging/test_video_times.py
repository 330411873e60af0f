"""Videos of any container: frame k is picture k, at its own time."""

import struct
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest

import robsim
from robsim.estimation.identification.regressions import interruptions
from robsim.vision.imaging import images

av = pytest.importorskip("av")

from numbered_videos import SIZE, number_in, numbered, write_numbered  # noqa: E402

MS = Fraction(1, 1000)
STEPS = [33 * MS, 42 * MS, 67 * MS, 33 * MS, 33 * MS, 50 * MS, 42 * MS]
PHONE = [sum((STEPS[i % 7] for i in range(k)), Fraction()) for k in range(40)]
SWITCHED = [Fraction(min(k, 20) + 2 * max(k - 20, 0), 5) for k in range(40)]
LOST = [Fraction(k, 5) for k in range(50) if k % 5 != 3]
H264 = {"codec": "libx264", "preset": "ultrafast", "crf": "18"}
INTERLACED = {"codec": "mpeg2video", "tick": Fraction(1, 25), "flags": 1 << 18 | 1 << 29, "b": "4M"}


def written(path, times, codec, **options):
    if codec not in av.codecs_available:
        pytest.skip(f"this system has no {codec}")
    write_numbered(path, times, codec, **options)
    return robsim.Recording(path)


def check(recording, times, numbers=None):
    """All pictures come in their order, at their times, and again in any order."""
    frames = list(recording)
    wanted = list(range(len(times))) if numbers is None else numbers
    assert [number_in(frame.image) for frame in frames] == wanted
    assert [frame.index for frame in frames] == list(range(len(times)))
    assert recording.count == len(times)
    error = np.subtract([frame.t for frame in frames], [float(t - times[0]) for t in times])
    np.testing.assert_allclose(error, 0, atol=1e-9)
    for k in (len(times) - 1, 1, len(times) // 2, 0, len(times) - 2):
        again = recording._at(k)
        assert (number_in(again.image), again.t) == (wanted[k], frames[k].t)
        np.testing.assert_array_equal(again.image, frames[k].image)


@pytest.mark.long
@pytest.mark.parametrize("b_frames", [0, 3])
@pytest.mark.parametrize("ending", ["mp4", "mov", "mkv", "ts"])
@pytest.mark.parametrize("start", [Fraction(), Fraction(1, 2), Fraction(1000)])
def test_irregular_times(tmp_path, ending, b_frames, start):
    times = [start + t for t in PHONE]
    recording = written(tmp_path / f"run.{ending}", times, b_frames=b_frames, **H264)
    assert recording.dt is None
    check(recording, times)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("vp9.webm", {"codec": "libvpx-vp9", "deadline": "realtime", "cpu-used": "8"}),
        ("vp8.webm", {"codec": "libvpx"}),
        ("ffv1.mkv", {"codec": "ffv1", "pixels": "bgr0"}),
        ("mjpeg.mov", {"codec": "mjpeg", "pixels": "yuvj420p"}),
        ("mpeg4.mp4", {"codec": "mpeg4", "b_frames": 2, "b": "4M"}),
        ("run.flv", {"codec": "flv", "b": "4M"}),
        ("wmv2.wmv", {"codec": "wmv2", "b": "4M"}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_irregular_times_of_other_codecs(tmp_path, name, options):
    check(written(tmp_path / name, PHONE, **options), PHONE)


def test_irregular_times_of_a_gif(tmp_path):
    tick = Fraction(1, 100)
    times = [round(t / tick) * tick for t in PHONE]
    recording = written(tmp_path / "run.gif", times, "gif", pixels="rgb8", tick=tick)
    assert recording.dt is None
    check(recording, times)


@pytest.mark.parametrize("ending", ["mp4", "mkv"])
def test_a_rate_that_is_switched_is_not_constant(tmp_path, ending):
    recording = written(tmp_path / f"run.{ending}", SWITCHED, **H264)
    assert recording.dt is None
    check(recording, SWITCHED)


@pytest.mark.parametrize("b_frames", [0, 3])
@pytest.mark.parametrize("ending", ["mp4", "mov", "mkv"])
def test_lost_frames_leave_the_rate_as_it_is(tmp_path, ending, b_frames):
    recording = written(tmp_path / f"run.{ending}", LOST, b_frames=b_frames, **H264)
    assert recording.dt == pytest.approx(0.2)
    check(recording, LOST)


@pytest.mark.parametrize("codec", ["mpeg4", "mjpeg"])
def test_lost_frames_of_an_avi(tmp_path, codec):
    pixels = "yuvj420p" if codec == "mjpeg" else "yuv420p"
    recording = written(tmp_path / "run.avi", LOST, codec, tick=Fraction(1, 5), pixels=pixels)
    assert recording.dt == pytest.approx(0.2)
    check(recording, LOST)


@pytest.mark.parametrize("codec", ["mpeg4", "libx264"])
def test_an_avi_that_has_no_times_for_its_b_frames(tmp_path, codec):
    times = [Fraction(k, 25) for k in range(40)]
    recording = written(tmp_path / "run.avi", times, codec, tick=Fraction(1, 25), b_frames=2)
    assert recording.dt == pytest.approx(0.04)
    check(recording, times)


def test_the_rounding_of_the_file_is_undone(tmp_path):
    times = [Fraction(k, 30) for k in range(40)]  # in ms: 0, 33, 67, ...
    recording = written(tmp_path / "run.mkv", times, tick=Fraction(1, 30), **H264)
    assert recording.dt == pytest.approx(1 / 30, rel=1e-6)
    check(recording, times)


@pytest.mark.parametrize("ending", ["mpg", "ts", "mkv"])
def test_interlaced(tmp_path, ending):
    times = [Fraction(k, 25) for k in range(40)]
    recording = written(tmp_path / f"run.{ending}", times, b_frames=2, **INTERLACED)
    check(recording, times)
    for frame in recording:
        assert np.abs(frame.image[16:48] - numbered(frame.index)[16:48].astype(float)).mean() < 10


def test_a_cut_by_an_edit_list(tmp_path):
    times = [Fraction(k, 25) for k in range(40)]
    write_numbered(tmp_path / "whole.mp4", times, tick=Fraction(1, 25), b_frames=2, **H264)
    with (
        av.open(str(tmp_path / "whole.mp4")) as whole,
        av.open(str(tmp_path / "a.mp4"), "w") as cut,
    ):
        stream = whole.streams.video[0]
        copy = cut.add_stream_from_template(stream)
        shift = round(16 / 25 / stream.time_base)
        whole.seek(shift, stream=stream)
        for packet in whole.demux(stream):
            if packet.dts is not None:
                packet.pts, packet.dts = packet.pts - shift, packet.dts - shift
                packet.stream = copy
                cut.mux(packet)
    check(robsim.Recording(tmp_path / "a.mp4"), times[16:], list(range(16, 40)))


@pytest.mark.parametrize("matrix", [(0, -1, 1, 0), (-1, 0, 0, -1)])
def test_a_video_that_players_turn_is_read_as_on_the_sensor(tmp_path, matrix):
    file = tmp_path / "run.mp4"
    upright = next(iter(written(file, PHONE[:2], **H264))).image
    content = bytearray(file.read_bytes())

    def coded(a, b, c, d):
        return struct.pack(">9i", *(65536 * x for x in (a, b, 0, c, d, 0, 0, 0)), 2**30)

    at = content.index(coded(1, 0, 0, 1), content.index(b"tkhd"))
    content[at : at + 36] = coded(*matrix)
    file.write_bytes(content)
    images.tell_of_turn.cache_clear()
    with pytest.warns(UserWarning, match="as on the sensor"):
        recording = robsim.Recording(file)
    np.testing.assert_array_equal(next(iter(recording)).image, upright)


def test_a_run_has_the_times_of_the_file(tmp_path):
    recording = written(tmp_path / "run.mkv", LOST, **H264)
    trace = robsim.Experiment(recording, measure=None).run()
    np.testing.assert_allclose(trace.t, [float(t) for t in LOST], atol=1e-9)
    assert not trace.interrupted.any()
    gaps = [k for k in range(1, 40) if LOST[k] - LOST[k - 1] > Fraction(1, 5)]
    assert np.flatnonzero(interruptions(trace)).tolist() == gaps  # no sample spans one


def test_a_camera_plays_them_at_their_times(tmp_path):
    recording = written(tmp_path / "run.mkv", PHONE[:8], **H264)
    with robsim.Camera(tmp_path / "run.mkv") as camera:
        seen = {number_in(frame.image): frame.t for frame in camera}
    own = [frame.t for frame in recording]
    first = min(seen)
    for k, t in seen.items():
        assert t - seen[first] == pytest.approx(own[k] - own[first], abs=1e-6)


def test_several_threads_read_one_recording(tmp_path):
    recording = written(tmp_path / "run.mp4", PHONE, b_frames=2, **H264)

    def read(k):
        return [number_in(frame.image) for frame in recording], number_in(recording._at(k).image)

    with ThreadPoolExecutor(4) as pool:
        for k, (numbers, again) in enumerate(pool.map(read, range(8))):
            assert (numbers, again) == (list(range(40)), k)


@pytest.mark.filterwarnings("ignore:.*ends after")  # which is where it was
def test_of_two_frames_at_one_time_the_first_is_shown(tmp_path):
    file = tmp_path / "run.mkv"
    write_numbered(file, PHONE[:6], "mjpeg", pixels="yuvj420p")
    content = bytearray(file.read_bytes())
    at = content.rindex(b"\x81\0\x42\x80")  # a block 66 ms after the begin of its cluster
    content[at + 2] = 33
    file.write_bytes(content)
    check(robsim.Recording(file), PHONE[:5])


def test_a_cut_before_the_first_key_frame_is_not_grey(tmp_path):
    file = tmp_path / "run.ts"
    times = [Fraction(k, 25) for k in range(40)]
    written(file, times, "mpeg4", tick=Fraction(1, 25), b="4M")
    with av.open(str(file)) as container:
        at = [one.pos for one in container.demux(video=0) if one.size][4]
    head, content = file.read_bytes()[: 3 * 188], file.read_bytes()
    file.write_bytes(head + content[at:])  # with the tables of the stream
    with pytest.warns(UserWarning, match="are left out"):
        frames = list(robsim.Recording(file))
    assert [number_in(frame.image) for frame in frames] == list(range(12, 40))


def test_frame_k_beside_a_sound(tmp_path):
    file = tmp_path / "run.ts"
    with av.open(str(file), "w") as container:
        stream, sound = container.add_stream("mpeg4", rate=25), container.add_stream("mp2", 48000)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for k in range(100):  # longer than the video
            silence = av.AudioFrame(format="s16", layout="stereo", samples=1152)
            silence.sample_rate, silence.pts = 48000, 1152 * k
            container.mux(sound.encode(silence))
        for k in range(40):
            frame = av.VideoFrame.from_ndarray(numbered(k), format="rgb24")
            frame.pts = k
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
        container.mux(sound.encode(None))
    check(robsim.Recording(file), [Fraction(k, 25) for k in range(40)])


def test_a_title_in_another_coding(tmp_path):
    file = tmp_path / "run.avi"
    write_numbered(file, SWITCHED[:3], "mpeg4", tick=Fraction(1, 5))
    file.write_bytes(file.read_bytes().replace(b"Lavf", b"L\xe4vf"))
    check(robsim.Recording(file), SWITCHED[:3])


def test_a_tape_of_a_dv_camcorder(tmp_path):
    with av.open(str(tmp_path / "tape.dv"), "w", format="dv") as tape:
        stream = tape.add_stream("dvvideo", rate=25)
        stream.width, stream.height, stream.pix_fmt = 720, 576, "yuv420p"
        for level in (60, 120, 180):
            pixels = np.full((576, 720, 3), level, np.uint8)
            tape.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        tape.mux(stream.encode(None))
    recording = robsim.Recording(tmp_path / "tape.dv")
    assert [round(frame.image.mean(), -1) for frame in recording] == [60, 120, 180]
    assert [frame.t for frame in recording] == pytest.approx([0, 0.04, 0.08])


def test_a_short_video_without_durations_is_whole(tmp_path):
    times = [Fraction(k, 25) for k in range(12)]
    check(written(tmp_path / "run.wmv", times, "wmv2", tick=Fraction(1, 25)), times)
