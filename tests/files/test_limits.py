"""Nothing is unpacked before it is known to be wanted, and how large it is."""

import io
import json
import os
import re
import tracemalloc
import zipfile

import numpy as np
import pytest
from PIL import Image

import robsim
from robsim import vision as imaging
from robsim.vision import save_colors

MB = 2**20


def npy(dtype, shape, content=b""):
    """An array file whose header may claim more than there is."""
    file = io.BytesIO()
    header = {"descr": np.dtype(dtype).str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(file, header)
    return file.getvalue() + content


@pytest.fixture
def forged(tmp_path):
    """A function that saves a trace, and puts other members into its file."""

    def forge(others, groups=None):
        file = tmp_path / "forged.npz"
        robsim.Simulation(seed=1).run(3).save(file)
        with zipfile.ZipFile(file) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        if groups is not None:
            info = json.loads(str(np.load(io.BytesIO(members["info.npy"]))))
            content = io.BytesIO()
            np.save(content, np.array(json.dumps(info | {"groups": groups})))
            members["info.npy"] = content.getvalue()
        members |= others
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, member in members.items():
                archive.writestr(name, member)
        return file

    return forge


def refused(file, reason):
    """A trace is refused for this reason, and little memory and text is spent on it."""
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=rf"forged\.npz .*{reason}") as caught:
            robsim.Trace.load(file)
        assert tracemalloc.get_traced_memory()[1] < 20 * MB
    finally:
        tracemalloc.stop()
    assert len(str(caught.value)) < 500
    assert str(caught.value).isprintable()


ZEROS = bytes(30 * MB)


@pytest.mark.long
def test_what_a_trace_does_not_list_is_not_unpacked(forged):
    refused(forged({"more.npy": npy("<f8", (len(ZEROS) // 8,), ZEROS)}), "")


def test_what_numpy_of_old_adds_does_no_harm(forged):
    assert len(robsim.Trace.load(forged({"allow_pickle.npy": npy("?", (), b"\0")}))) == 3


@pytest.mark.long
def test_a_trace_that_is_packed_too_well(forged):
    rows = len(ZEROS) // 24
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robsim.trace._trace_file._MOST_SMALL", MB)
        groups = {"pose_true": 3, "u": 2, "bounced": 1}
        others = {
            f"{k}.npy": npy("<f8", (rows, n), ZEROS[: 8 * n * rows]) for k, n in groups.items()
        }
        refused(forged(others), r"\d+ MB.*\d+ MB")


def test_a_header_that_lies(forged):
    for member, reason in (
        (npy("<f8", (10**12, 3)), "size"),
        (npy("<f8", (-1, 3)), ""),
        (npy("<f8", (3, 3), bytes(80)), "size"),
        (npy("<f8", (4, 3), bytes(96)), "pose_true 4"),
        (npy("<f4", (3, 3), bytes(36)), "float32"),
        (npy("<f8", (3,) * 3, bytes(216)), r"\(3, 3, 3\)"),
        (npy("O", (3, 3), bytes(72)), "size|objects|pickle"),
        (b"\x93NUMPY\x01\x00\xff\xff{" + b"(" * 60_000, ""),
    ):
        refused(forged({"pose_true.npy": member}), reason)


def test_an_info_that_is_larger_than_what_it_says(forged):
    for text in ("[],", '{"a":1},', " ", "[" * 5000 + "]" * 5000 + ","):
        info = io.BytesIO()
        np.save(info, np.array("[" + text * (5 * MB // len(text)) + "1]"))
        refused(forged({"info.npy": info.getvalue()}), "info|keys and values|deep")


def test_a_zip_header_that_lies(forged):
    file = forged({"pose_true.npy": npy("<f8", (3, 3), bytes(72))})
    whole = file.read_bytes()
    for size in (0, 4, MB * 2**10):
        content = bytearray(whole)
        for start, offset in ((b"PK\x01\x02", 24), (b"PK\x03\x04", 22)):
            for found in re.finditer(re.escape(start), whole):
                at = found.start() + offset
                content[at : at + 4] = size.to_bytes(4, "little")
        file.write_bytes(content)
        refused(file, "")


def test_a_group_whose_name_cannot_be_shown(forged):
    member = npy("<f8", (3, 4), bytes(96))
    for name in (
        "blobs_a\0b",
        "blobs_" + 41 * "a",
        "blobs_\x1b[2J",
        "blobs_\u202e",
        "\n",
        "blobs_<b>",
        "=1",
    ):
        groups = ["pose_true", "u", "bounced", name]
        refused(forged({f"{name}.npy": member}, groups), "name of a group")


def test_a_trace_that_is_packed_too_well_is_saved_in_another_way(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.trace._trace_file._MOST_SMALL", 1000)
    monkeypatch.setattr("robsim.trace._trace_file._most_unpacked", lambda size: max(1000, 2 * size))
    trace = robsim.Simulation(seed=1, control=lambda step: (0.0, 0.0)).run(500)
    trace.save(tmp_path / "still.npz")
    assert robsim.Trace.load(tmp_path / "still.npz") == trace


# --- TOML


@pytest.mark.long
def test_a_text_that_would_take_long(tmp_path):
    file = tmp_path / "file.toml"
    for text, reason in (
        ("a" + ".a" * 20_000 + " = 1", "8 parts"),
        ("[" + "a . " * 20_000 + "a]", "8 parts"),
        ("'a'" + '."a"' * 20_000 + " = 1", "8 parts"),
        ("x = {y" + ".y" * 20_000 + " = 1}", "8 parts"),
        ("x = [" + "1," * 200_000 + "]", "100000 keys"),
        ("\n" * 300_000, "100000 keys"),
        ("a" * 900_000, ""),
        ("x = " + "[" * 50_000, ""),
        ("x = " + "9" * 50_000, ""),
        ("x=[" + "1," * 90_000 + "]", ""),
        ("x = '" + "a" * 900_000 + "'", ""),
    ):
        file.write_text(text)
        for read in (robsim.load_colors, robsim.Scenario.load):
            with pytest.raises(ValueError, match=rf"file\.toml.*{reason}") as caught:
                read(file)
            assert len(str(caught.value)) < 500 + len(str(tmp_path))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_or_a_device_without_an_end_is_no_file(tmp_path):
    device, pipe = tmp_path / "device.mkv", tmp_path / "pipe.mkv"
    device.symlink_to("/dev/zero")
    os.mkfifo(pipe)
    readers = robsim.load_colors, robsim.Scenario.load, robsim.Trace.load, imaging.load_image
    for file in (device, pipe):
        for read in readers:
            with pytest.raises(ValueError, match=rf"{file.name} must be a regular file"):
                read(file)
    for read in readers:
        with pytest.raises(IsADirectoryError):
            read(tmp_path)


@pytest.mark.parametrize("number", ["9", "0.9", "0xf", "0b1", "1_0"])
def test_a_number_of_many_digits_takes_little_memory(tmp_path, number):
    file = tmp_path / "scenario.toml"
    file.write_text(f"seed = {number}{number[-1] * 2_000_000}")
    tracemalloc.start()
    try:
        with pytest.raises(ValueError, match=r"scenario\.toml.* digits") as caught:
            robsim.Scenario.load(file)
        assert tracemalloc.get_traced_memory()[1] < 128 * MB
    finally:
        tracemalloc.stop()
    assert "sys." not in str(caught.value)


def test_a_colour_file_has_at_most_1000_colours(tmp_path):
    file = tmp_path / "colors.toml"
    colors = [robsim.ColorClass(f"c{i}", u=(i % 256, 255)) for i in range(1001)]
    with pytest.raises(ValueError, match="1001"):
        save_colors(file, colors)
    assert not file.exists()
    file.write_text("".join(f"[c{i}]\n" for i in range(1001)))
    with pytest.raises(ValueError, match=r"colors\.toml.*1001"):
        robsim.load_colors(file)


# --- pictures and videos


def test_a_picture_of_another_program_is_not_read(tmp_path):
    (tmp_path / "a.eps").write_text("%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\nshowpage\n")
    with pytest.raises(ValueError, match=r"a\.eps"):
        imaging.load_image(tmp_path / "a.eps")


def test_a_picture_of_many_pixels_whatever_pillow_allows(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.vision.imaging.images.MOST_PIXELS", 1000)
    Image.new("1", (40, 30)).save(tmp_path / "a.png")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", None)
    with pytest.raises(ValueError, match=r"a\.png has too many pixels: at most 1000 are read"):
        imaging.load_image(tmp_path / "a.png")


PLAYLISTS = {
    "c.mkv": "ffconcat version 1.0\nfile secret.mkv\n",
    "c.mp4": "\ufeffffconcat version 1.0\nfile secret.mkv\n",
    "c.avi": "#EXTM3U\n#EXTINF:1\nsecret.mkv\n#EXT-X-ENDLIST\n",
    "c.m3u8": "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1\nsecret.mkv\n#EXT-X-ENDLIST\n",
    "c.webm": "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nm=video 1 RTP/AVP 96\n",
    "c.sdp": "v=0\n",
    "c.mpd": "<?xml version='1.0'?><MPD xmlns='urn:mpeg:dash:schema:mpd:2011'></MPD>",
    "c.mov": "<?xml version='1.0'?><smil></smil>",
}


@pytest.fixture
def video(tmp_path):
    """A video that others would like to be taken for."""
    pytest.importorskip("av")
    imaging.save_video(tmp_path / "secret.mkv", [np.zeros((16, 16, 3), np.uint8)], fps=5)
    return tmp_path / "secret.mkv"


def test_a_playlist_is_no_video(video):
    for name, text in PLAYLISTS.items():
        playlist = video.with_name(name)
        playlist.write_text(text)
        with pytest.raises(ValueError, match=re.escape(name)):
            robsim.Recording(playlist)


def test_a_name_that_stands_for_other_files_is_no_video(video):
    for name in ("a%d.png", "a*.jpg", "a%03d.y", "a%d.dpx"):
        video = video.rename(video.with_name(name))
        with pytest.raises(ValueError, match=re.escape(name)):
            robsim.Recording(video)


def test_a_video_may_be_called_as_it_likes(video, monkeypatch):
    monkeypatch.chdir(video.parent)
    for name in ("50 %.mkv", "concat:a.mkv", "a[1].mkv"):
        video = video.rename(video.with_name(name))
        assert len(list(robsim.Recording(name))) == 1


def test_a_video_of_each_container_is_one(tmp_path):
    cv2 = pytest.importorskip("cv2")
    codecs = {".webm": "VP80", ".avi": "MJPG", ".mpg": "MPG1", ".flv": "FLV1"}
    for suffix in (".mp4", ".webm", ".mkv", ".avi", ".mov", ".mpg", ".flv"):
        file = tmp_path / f"video{suffix}"
        code = cv2.VideoWriter_fourcc(*codecs.get(suffix, "mp4v"))
        writer = cv2.VideoWriter(str(file), cv2.CAP_FFMPEG, code, 25, (64, 48))
        for level in range(5):
            writer.write(np.full((48, 64, 3), 40 * level, np.uint8))
        writer.release()
        if file.exists() and file.stat().st_size >= 500:  # not every OpenCV writes each of them
            assert robsim.Recording(file, dt=0.1).size == (64, 48)
