"""Folders that are damaged, or made by somebody who means harm: an error in words, at once."""

import io
import shutil
import struct

import numpy as np
import pytest
from PIL import Image

from robsim.sessions import Session
from robsim.sessions import _matroska as matroska
from sessions import record

pytest.importorskip("cv2")


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
    assert "\u202e" not in str(caught.value)
    assert len(str(caught.value)) < 600


def edit(file, old, new):
    text = file.read_bytes()
    assert old in text
    file.write_bytes(text.replace(old, new, 1))


EYE = b"[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
FIVE = b"[0, 0, 0, 0, 0]"


def _with_lens(intrinsics):
    return b"dt = 0.2\nplane_map = {matrix = %s, intrinsics = %s}" % (EYE, intrinsics)


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        (b"format = 2", b"format = 3", "format must be 1 or 2, got 3"),
        (b"format = 2", b"format = ", "is not a TOML file"),
        (b"[300, 300]", b"[300, 1e400]", "area must be"),
        (b"[300, 300]", b"[300, 99999999999]", "area must lie within"),
        (b"[300, 300]", b'"' + 100_000 * b"x" + b'"', "area must be"),
        (b"dt = 0.2", b"dt = nan", "dt must be"),
        (b"dt = 0.2", b"dt = -1", "dt must be"),
        (b"dt = 0.2", b"dt = true", "dt must be"),
        (b"dt = 0.2", b"dt = 0.2\nplane_map = [[1, 2, 3], [2, 4, 6], [0, 0, 0]]", "inverse"),
        (b"dt = 0.2", b"dt = 0.2\nplane_map = [[1, 2], [3]]", "plane_map must be"),
        (b"dt = 0.2", _with_lens(b"4"), r"plane_map\.intrinsics must be a table, got 4"),
        (b"dt = 0.2", _with_lens(b"{}"), r"plane_map\.intrinsics\.matrix must be an array"),
        (
            b"dt = 0.2",
            _with_lens(b"{matrix = %s}" % EYE),
            r"intrinsics\.distortion must be an array",
        ),
        (
            b"dt = 0.2",
            _with_lens(b"{matrix = %s, distortion = [nan, 0, 0, 0, 0]}" % EYE),
            r"plane_map\.intrinsics\.distortion must be 5 finite",
        ),
        (
            b"dt = 0.2",
            _with_lens(b"{matrix = [[0, 0, 0], [0, 1, 0], [0, 0, 1]], distortion = %s}" % FIVE),
            "plane_map: matrix must have focal lengths above 0",
        ),
        (b"dt = 0.2", b"dt = 0.2\nplane_map = {}", r"plane_map\.matrix must be"),
        (b"dt = 0.2", b"dt = 0.2\ncolors = [{name = 'red'}]", "colors must have y"),
        (b"dt = 0.2", b"dt = 0.2\ncolors = [{name=1, y=2, u=3, v=4}]", "colors: "),
        (b"dt = 0.2", b"dt = 0.2\nmodel = {dt = 1, theta = [[inf]]}", "model.theta must be"),
        (
            b"dt = 0.2",
            b"dt = 0.2\nmarkers = {right.position = [0, 1], left.position = [0, 1]}",
            "markers: ",
        ),
        (b"dt = 0.2", b"dt = 0.2\nmarkers = 4", "markers must be a table"),
        (b'robot = "lab"', b"robot = 7", "robot must be a text"),
        (b"started = 2", b"started = 1 # ", "started must be a time"),
    ],
)
def test_a_damaged_set_up_is_named(folder, old, new, match):
    edit(folder / "setup.toml", old, new)
    refused(folder, rf"setup.toml.*{match}")


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        (b"k,t,", b"t,k,", "is not the time base"),
        (b"\n2,100.4,", b"\n3,100.4,", "line 4: step 3 follows step 1"),
        (b"\n2,100.4,", b"\n-2,100.4,", "line 4: k must be a whole number"),
        (b"\n2,100.4,", b"\n" + 30 * b"2" + b",100.4,", "line 4: k must be a whole number"),
        (b"\n2,100.4,", b"\n2,,", "line 4: a step must have a time"),
        (b"\n2,100.4,", b"\n2,nan,", "line 4: t must be a finite number"),
        (b"\n2,100.4,", b"\n2,1e400,", "line 4: t must be a finite number"),
        (b"\n2,100.4,", b"\n2,1e300,", "line 4: t must be at most"),
        (b"\n2,100.4,", b"\n2,100.4,,", "line 4: there must be 18 columns, got 19"),
        (b"\n2,100.4,", b"\n\n2,100.4,", "line 4: there must be 18 columns, got 0"),
        (b"\n2,100.4,", b"\n\xff2,100.4,", "line 4: "),
        (b"\n2,100.4,", b"\n" + 10_000 * b"2" + b",", "line 4: a line must have"),
        (b",0,,2,,2,", b",2,,2,,2,", "line 4: interrupted must be 0 or 1"),
        (b",0,,2,,2,", b",0,,0,,2,", "video_frame of step 2 must be 2, got 0"),
        (b",0,,2,,2,", b",0,,99,,2,", "video_frame of step 2 must be 2, got 99"),
        (b",0,,2,,2,", b",0,,2,,2,1 2 3", "line 4: plane_map must be 9 numbers"),
        (b",0,,2,,2,", b",0,,2,,2,1 0 0 0 1 0 0 0 1 5 5", "must be 9 numbers, or 18 with a lens"),
        (b",0,,2,,2,", b",0,,2,,2,1 0 0 0 1 0 0 0 1 0 5 1 1 0 0 0 0 0", "line 4: .*focal lengths"),
        (b",0,,2,,2,", b",0,,2,,2,1 0 0 0 1 0 0 0 1 5 5 1 1 0 x 0 0 0", "line 4: plane_map must"),
        (b",0,,2,,2,", b",0,,2,,2,0 0 0 0 0 0 0 0 0", "line 4: .*inverse"),
    ],
)
def test_a_damaged_line_is_named(folder, old, new, match):
    edit(folder / "steps.csv", old, new)
    refused(folder, rf"steps.csv.*{match}")


def test_a_torn_last_line_is_ignored_and_told(folder):
    steps = folder / "steps.csv"
    steps.write_bytes(steps.read_bytes()[:-4])
    session = Session(folder)
    assert session.count == 5
    assert not session.is_complete
    assert "steps.csv has 5 of 6 steps" in session.problems
    assert "the last line of steps.csv is torn: it is ignored" in session.problems
    assert "1 frames at the end have no row: they are ignored" in session.problems


def test_a_video_that_is_cut_off_leaves_steps_without_a_frame(folder):
    video = folder / "frames.mkv"
    for size, frames in ((20_000, range(1, 6)), (400, [0]), (100, [0]), (3, [0]), (0, [0])):
        video.write_bytes(video.read_bytes()[:size])
        session = Session(folder)
        assert sum(o.frame is not None for o in session) in frames
        assert any("of 6 frames: the last steps have none" in p for p in session.problems)
    video.unlink()
    assert Session(folder).problems == ("there is no frames.mkv: no step has a frame",)
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


@pytest.mark.parametrize(
    ("pictures", "match"),
    [
        ([png(16, 16), b"no picture"], "frame 1 of .*frames.mkv is damaged"),
        ([png(16, 16), png(17, 16)], "frame 1 .* 17 x 16 px, unlike the first"),
        ([png(16, 16)[:-40]], "frame 0 .* is damaged"),
        ([b"GIF89a" + bytes(100)], "frame 0 .* is damaged"),
        # A picture that claims to be huge is not unpacked.
        ([png(16, 16).replace(struct.pack(">II", 16, 16), struct.pack(">II", 30000, 30000))], "0"),
    ],
)
def test_a_damaged_picture_is_named(folder, pictures, match):
    (folder / "frames.mkv").write_bytes(video_of(pictures))
    refused(folder, match)


@pytest.mark.long
@pytest.mark.fuzz
def test_any_damage_is_told_or_harmless(folder, rng):
    files = {name: (folder / name).read_bytes() for name in ("setup.toml", "steps.csv", "end.toml")}
    files["frames.mkv"] = video_of([png(16, 16)] * 6)
    for _ in range(150):
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


def test_a_folder_without_a_session_is_told(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"has no session: no file setup\.toml"):
        Session(tmp_path)
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        Session(tmp_path / "none")
    with pytest.raises(TypeError, match="folder must be a path, got 3"):
        Session(3)
