"""Sessions from elsewhere: damaged, or hostile."""

import io
import os
import re
import shutil
import struct
import tracemalloc

import numpy as np
import pytest
from PIL import Image

from robsim.trace import Session
from robsim.trace.sessions import _pictures as matroska
from robsim.trace.sessions.rows import read_rows
from sessions import record
from sizes import thorough

pytest.importorskip("cv2")

# --- damage and harm


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded") / "run"
    record(folder, 6).close()
    return folder


@pytest.fixture
def folder(recorded, tmp_path):
    """A session to be damaged."""
    shutil.copytree(recorded, tmp_path / "s\u202ession\n")
    return tmp_path / "s\u202ession\n"


def refused(folder, match):
    with pytest.raises(ValueError, match=match) as caught:
        list(Session(folder))
    assert "\n" not in str(caught.value)
    assert not re.search("\u202e| object at ", str(caught.value))
    assert len(str(caught.value)) < 600


def check_damages(file, damages):
    """Each damage of a file, alone, is refused in the name of what is wrong."""
    text = file.read_bytes()
    for old, new, words in damages:
        assert old in text
        file.write_bytes(text.replace(old, new, 1))
        refused(file.parent, rf"{file.name}.*{words}")


EYE = b"[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
FIVE = b"[0, 0, 0, 0, 0]"


def _with_lens(intrinsics):
    return b"dt = 0.2\nplane_map = {matrix = %s, intrinsics = %s}" % (EYE, intrinsics)


def test_a_damaged_set_up_is_named(folder):
    no_focal_length = b"{matrix = [[0, 0, 0], [0, 1, 0], [0, 0, 1]], distortion = %s}" % FIVE
    nan = b"{matrix = %s, distortion = [nan, 0, 0, 0, 0]}" % EYE
    added = (
        (_with_lens(b"4"), r"\[plane_map\] intrinsics"),
        (_with_lens(b"{matrix = %s}" % EYE), r"intrinsics\] distortion"),
        (_with_lens(nan), r"intrinsics\] distortion .*finite"),
        (_with_lens(no_focal_length), r"\[plane_map\.intrinsics\] matrix .*focal"),
        (b"dt = 0.2\nplane_map = [[1, 2, 3], [2, 4, 6], [0, 0, 0]]", "inverse"),
        (b"dt = 0.2\nplane_map = {}", r"\[plane_map\] matrix"),
        (b"dt = 0.2\ncolors = [{name=1, y=2, u=3, v=4}]", r"\[colors\.1\] name"),
        (b"dt = 0.2\nmodel = {dt = 1, theta = [[inf]]}", r"\[model\] theta"),
        (b"dt = 0.2\nmarkers = {right.position = [0, 1], left.position = [0, 1]}", r"\[markers\] "),
        (b"dt = 0.2\nmarkers = 4", "markers"),
        *((b"dt = " + value, "dt") for value in (b"nan", b"-1", b"true")),
    )
    check_damages(
        folder / "setup.toml",
        [
            (b"format = 2", b"format = 1", "format .*1"),
            (b"format = 2", b"format = ", "TOML"),
            (b"[300, 300]", b"[300, 1e400]", "area"),
            (b"[300, 300]", b'"' + 100_000 * b"x" + b'"', "area"),
            *((b"dt = 0.2", new, words) for new, words in added),
            (b'robot = "lab"', b"robot = 7", "robot"),
            (b"started = 2", b"started = 1 # ", "started"),
        ],
    )


def test_a_damaged_line_is_named(folder):
    row, end = b"\n2,100.4,", b",0,,2,,2,"
    check_damages(
        folder / "steps.csv",
        [
            (b"k,t,", b"t,k,", ""),
            (row, b"\n3,100.4,", "line 4: step 3 follows step 1"),
            (row, b"\n-2,100.4,", r"line 4: k\b"),
            (row, b"\n2,,", "line 4: a step must have a time"),
            (row, b"\n2,nan,", r"line 4: t\b"),
            (row, b"\n2,1e300,", r"line 4: t\b"),
            (row, b"\n2,100.4,,", "line 4: .*18 .*19"),
            (row, b"\n\xff2,100.4,", "line 4: "),
            (row, b"\n" + 10_000 * b"2" + b",", "line 4: "),
            (end, b",2,,2,,2,", "line 4: interrupted"),
            (end, b",0,,0,,2,", "video_frame of step 2 must be 2, got 0"),
            (end, end + b"1 2 3", "line 4: plane_map"),
            (end, end + b"1 0 0 0 1 0 0 0 1 0 5 1 1 0 0 0 0 0", "line 4: .*focal"),
            (end, end + b"0 0 0 0 0 0 0 0 0", "line 4: .*inverse"),
        ],
    )


def test_rows_take_little_more_memory_than_their_file(folder):
    steps = folder / "steps.csv"
    head = steps.read_bytes().splitlines(keepends=True)[0]
    commas = b"," * (head.count(b",") - 1)
    place = head.split(b",").index(b"interrupted") - 1
    line = b"%d,0" + b"," * place + b"0" + commas[place:] + b"\n"
    steps.write_bytes(head + b"".join(line % k for k in range(30_000)))
    (folder / "frames.mkv").unlink()
    tracemalloc.start()
    try:
        rows, is_torn = read_rows(steps)
        assert tracemalloc.get_traced_memory()[1] < 10 * steps.stat().st_size
    finally:
        tracemalloc.stop()
    assert (len(rows), is_torn) == (30_000, False)


def test_a_session_has_so_many_steps_and_pictures_at_most(folder, monkeypatch):
    monkeypatch.setattr("robsim.trace.sessions.rows._MOST_ROWS", 5)
    refused(folder, "line 7: a session must have at most 5 steps")
    monkeypatch.undo()
    monkeypatch.setattr("robsim.trace.sessions._pictures._MOST_PICTURES", 5)
    refused(folder, "at most 5 pictures")


def test_a_line_without_an_end_is_not_read_whole(folder):
    with (folder / "steps.csv").open("ab") as file:
        file.truncate(2**30)  # of zeros, which take no room on the disk
    tracemalloc.start()
    try:
        refused(folder, "at most 4096 bytes")
        assert tracemalloc.get_traced_memory()[1] < 2**23
    finally:
        tracemalloc.stop()


def test_a_torn_last_line_is_ignored_and_told(folder):
    steps = folder / "steps.csv"
    steps.write_bytes(steps.read_bytes()[:-4])
    session = Session(folder)
    assert session.count == 5
    assert not session.is_complete
    said = " ".join(session.problems)
    assert "5 of 6 steps" in said
    assert "torn" in said
    assert "1 frames at the end" in said


def test_a_video_that_is_cut_off_leaves_steps_without_a_frame(folder):
    video = folder / "frames.mkv"
    for size, frames in ((20_000, range(1, 6)), (400, [0]), (100, [0]), (3, [0]), (0, [0])):
        video.write_bytes(video.read_bytes()[:size])
        session = Session(folder)
        assert sum(o.frame is not None for o in session) in frames
        assert any("of 6 frames: the last steps have none" in p for p in session.problems)
    video.unlink()
    assert "frames.mkv" in Session(folder).problems[0]
    assert len(Session(folder).trace) == 6


def test_what_is_no_video_of_a_session_is_refused(folder):
    (folder / "frames.mkv").write_bytes(b"RIFF    AVI " + bytes(1000))
    refused(folder, "frames.mkv is not a video of a session")


def video_of(pictures):
    return matroska.head("PNG", (16, 16), None) + b"".join(
        matroska.cluster(picture, 10 * k) for k, picture in enumerate(pictures)
    )


def png(width, height):
    stream = io.BytesIO()
    Image.fromarray(np.zeros((height, width, 3), np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def test_a_damaged_picture_is_named(folder):
    whole = png(16, 16)
    # A picture that claims to be huge is not unpacked.
    huge = whole.replace(struct.pack(">II", 16, 16), struct.pack(">II", 30000, 30000))
    for pictures, words in (
        ([whole, b"no picture"], "frame 1 of .*frames.mkv is damaged"),
        ([whole, png(17, 16)], "frame 1 .* 17 x 16 px"),
        ([whole[:-40]], "frame 0 .* is damaged"),
        ([b"GIF89a" + bytes(100)], "frame 0 .* is damaged"),
        ([huge], "0"),
    ):
        (folder / "frames.mkv").write_bytes(video_of(pictures))
        refused(folder, words)


@pytest.mark.long
@pytest.mark.fuzz
def test_any_damage_is_told_or_harmless(folder, rng):
    files = {name: (folder / name).read_bytes() for name in ("setup.toml", "steps.csv", "end.toml")}
    files["frames.mkv"] = video_of([png(16, 16)] * 6)
    for _ in range(thorough(150, 80)):
        for name, content in files.items():
            (folder / name).write_bytes(content)
        name = str(rng.choice(list(files)))
        damaged = bytearray(files[name])
        for _ in range(rng.integers(1, 4)):
            damaged[rng.integers(len(damaged))] = rng.integers(256)
        (folder / name).write_bytes(damaged[: rng.integers(len(damaged) + 1)])
        told = ""
        try:
            session = Session(folder)
            assert sum(1 for _ in session) == session.count == len(session.trace) <= 6
        except (ValueError, TypeError) as error:
            told = str(error)
        assert told.isprintable(), told


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
@pytest.mark.parametrize("name", ["steps.csv", "frames.mkv"])
def test_a_pipe_in_a_session_is_not_waited_for(folder, name):
    (folder / name).unlink()
    os.mkfifo(folder / name)
    refused(folder, rf"{name} must be a regular file")


def test_a_folder_without_a_session_is_told(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"setup\.toml"):
        Session(tmp_path)
    with pytest.raises(FileNotFoundError, match="no folder"):
        Session(tmp_path / "none")
