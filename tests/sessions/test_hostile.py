"""Sessions from elsewhere: damaged, or hostile."""

import io
import os
import re
import shutil
import struct
import tracemalloc
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType
from PIL import Image

from commands import command
from robsim.trace import Session
from robsim.trace.sessions._file import complete
from robsim.trace.sessions._setup import setup_text
from sessions import SETUP, record, write_file
from sizes import thorough

pytest.importorskip("cv2")

TEXT = setup_text(SETUP, kind="JPEG")
OLD = Path(__file__).parents[1] / "data/0.1.0/session"


def png(width, height):
    stream = io.BytesIO()
    Image.fromarray(np.zeros((height, width, 3), np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def line(k, more=""):
    return f'{{"k": {k}, "t": {100 + k / 5!r}{more}}}'.encode()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A whole session of six steps."""
    file = tmp_path_factory.mktemp("recorded") / "run.mcap"
    record(file, 6).close()
    return file


@pytest.fixture
def file(recorded, tmp_path):
    """A session to be damaged."""
    return Path(shutil.copy(recorded, tmp_path / "s\u202ession\n.mcap"))


@pytest.fixture
def folder(tmp_path):
    """A session of an earlier robsim, to be damaged."""
    return Path(shutil.copytree(OLD, tmp_path / "old"))


def refused(path, match):
    with pytest.raises(ValueError, match=match) as caught:
        list(Session(path))
    assert "\n" not in str(caught.value)
    assert not re.search("\u202e| object at ", str(caught.value))
    assert len(str(caught.value)) < 600


EYE = "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"


def with_lens(intrinsics):
    return f"dt = 0.2\nplane_map = {{matrix = {EYE}, intrinsics = {intrinsics}}}"


def test_a_damaged_set_up_is_named(tmp_path):
    no_focal_length = "{matrix = [[0, 0, 0], [0, 1, 0], [0, 0, 1]], distortion = [0, 0, 0, 0, 0]}"
    nan = f"{{matrix = {EYE}, distortion = [nan, 0, 0, 0, 0]}}"
    added = (
        (with_lens(4), r"\[plane_map\] intrinsics"),
        (with_lens(f"{{matrix = {EYE}}}"), r"intrinsics\] distortion"),
        (with_lens(nan), r"intrinsics\] distortion .*finite"),
        (with_lens(no_focal_length), r"\[plane_map\.intrinsics\] matrix .*focal"),
        ("dt = 0.2\nplane_map = [[1, 2, 3], [2, 4, 6], [0, 0, 0]]", "inverse"),
        ("dt = 0.2\nplane_map = {}", r"\[plane_map\] matrix"),
        ("dt = 0.2\ncolors = [{name=1, y=2, u=3, v=4}]", r"\[colors\.1\] name"),
        ("dt = 0.2\nmodel = {dt = 1, theta = [[inf]]}", r"\[model\] theta"),
        ("dt = 0.2\nmarkers = {right.position = [0, 1], left.position = [0, 1]}", r"\[markers\] "),
        ("dt = 0.2\nmarkers = 4", "markers"),
        *(("dt = " + value, "dt") for value in ("nan", "-1", "true")),
    )
    for old, new, words in (
        ("format = 3", "format = 1", "format .*1"),
        ("format = 3", "format = ", "TOML"),
        ("[300, 300]", "[300, 1e400]", "area"),
        ("[300, 300]", '"' + 100_000 * "x" + '"', "area"),
        *(("dt = 0.2", new, words) for new, words in added),
        ('robot = "lab"', "robot = 7", "robot"),
        ("started = 2", "started = 1 # ", "started"),
    ):
        assert old in TEXT
        write_file(tmp_path / "a.mcap", TEXT.replace(old, new, 1), [])
        refused(tmp_path / "a", f"a.mcap.*{words}")
    write_file(tmp_path / "a.mcap", "", [])
    refused(tmp_path / "a", "set-up")


@pytest.mark.parametrize(
    ("damaged", "words"),
    [
        (line(3), "step 3 follows step 1"),
        (line(-2), r"k\b"),
        (b'{"k": 2}', "t is missing"),
        (b'{"t": 2}', "k is missing"),
        (b'{"k": 2, "t": NaN}', r"t\b"),
        (b'{"k": 2, "t": 1e300}', r"t\b"),
        (b'{"k": 2, "t": 1e400}', r"t\b"),
        (b'{"k": true, "t": 1}', r"k\b"),
        (b'{"k": 2, "t": 1', "JSON"),
        (b"[1, 2]", "table"),
        (b"\xff", ""),
        (b"[" * 3000, ""),
        (line(2, ', "u": [1]'), "u must be 2 numbers"),
        (line(2, ', "u": [1, "2"]'), "u must be"),
        (line(2, ', "reason": 4'), "reason"),
        (line(2, ', "interrupted": 2'), "interrupted"),
        (line(2, ', "headings": 0'), "headings"),
        (line(2, f', "frame_index": {2**63}'), "frame_index"),
        (line(2, ', "plane_map": [1, 2, 3]'), "plane_map"),
        (line(2, ', "plane_map": {"matrix": [[0, 0, 0], [0, 0, 0], [0, 0, 0]]}'), "inverse"),
        (line(2, ', "reason": "' + 5000 * "x" + '"'), "4096 bytes"),
    ],
)
def test_a_damaged_step_is_named(tmp_path, damaged, words):
    write_file(tmp_path / "a.mcap", TEXT, [(line(0), None), (line(1), None), (damaged, None)])
    refused(tmp_path / "a", f"a.mcap: step 2 .*{words}")


def peak_of(action):
    tracemalloc.start()
    try:
        action()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_steps_take_little_more_memory_than_their_file(tmp_path):
    file = tmp_path / "a.mcap"
    write_file(file, TEXT, [(b'{"k":%d,"t":0}' % k, None) for k in range(20_000)])
    file.write_bytes(file.read_bytes()[:-100])  # to be completed
    assert peak_of(lambda: Session(file)) < 10 * file.stat().st_size
    assert Session(file).count == 20_000


def test_a_session_has_so_many_steps_at_most(file, monkeypatch):
    monkeypatch.setattr("robsim.trace.sessions._file.MOST_ROWS", 5)
    refused(file, "at most 5 steps")


def test_packed_chunks_are_refused(tmp_path):
    for kind in (CompressionType.ZSTD, CompressionType.LZ4):  # which may unpack to anything
        write_file(tmp_path / "a.mcap", TEXT, [(line(0), None)], compression=kind)
        refused(tmp_path / "a", "packed")


def chunk_of(size, inside=b""):
    """The start of a chunk that says to have so many bytes."""
    return struct.pack("<BQQQQIIQ", 6, 40 + size, 0, 0, size, 0, 0, size) + inside


def test_lengths_that_lie_take_no_memory(file):
    whole = file.read_bytes()
    end = whole.index(b"\x0f\x04\0\0\0\0\0\0\0")  # of the data
    huge = 2**62
    channel = struct.pack("<BQHHI", 4, huge, 9, 1, 2**32 - 1)
    for added, words in (
        (struct.pack("<BQ", 12, 2**29), "at most"),
        (chunk_of(2**29, channel), "shorter than a record"),
        (chunk_of(2**29, struct.pack("<BQHHI", 4, 2**28, 9, 1, 2**32 - 1)), "at most"),
        (struct.pack("<BQQQQIIQ", 6, 2**29, 0, 0, 9, 0, 0, huge), "damaged"),
        (struct.pack("<BQQQI", 9, 2**29, 0, 0, 2**31), "too short"),
    ):
        with file.open("wb") as stream:
            stream.write(whole[:end] + added)
            stream.truncate(2**30)  # of zeros, which take no room on the disk
        assert peak_of(lambda words=words: refused(file, words)) < 2**24


def test_an_index_that_lies_is_not_believed(file, rng):
    whole = file.read_bytes()
    end = whole.index(b"\x0f\x04\0\0\0\0\0\0\0") + 13
    file.write_bytes(whole[:end] + rng.bytes(len(whole) - end - 8) + whole[-8:])
    session = Session(file)
    assert session.is_complete
    assert sum(one.frame is not None for one in session) == 6


def test_a_changed_bit_is_told(recorded, file):
    whole = bytearray(recorded.read_bytes())
    place = whole.index(b"\xff\xd8\xff\xe0", whole.index(b'"k": 3')) + 5000  # in its JPEG
    whole[place] ^= 1
    file.write_bytes(whole)
    refused(file, "frame of step 3 .* checksum")
    write_file(file, TEXT, [(line(k), None) for k in range(3)])
    file.write_bytes(file.read_bytes().replace(b"100.2", b"100.3"))
    refused(file, "checksum")


def test_a_damaged_picture_is_named(tmp_path):
    whole = png(16, 16)
    # A picture that claims to be huge is not unpacked.
    huge = whole.replace(struct.pack(">II", 16, 16), struct.pack(">II", 30000, 30000))
    for pictures, words in (
        ([whole, b"no picture"], r"step 1 of .*a\.mcap is damaged"),
        ([whole, png(17, 16)], "step 1 .* 17 x 16 px"),
        ([whole[:-40]], "step 0 .* is damaged"),
        ([b"GIF89a" + bytes(100)], "step 0 .* is damaged"),
        ([huge], "step 0"),
    ):
        write_file(tmp_path / "a.mcap", TEXT, [(line(k), one) for k, one in enumerate(pictures)])
        refused(tmp_path / "a", words)


@pytest.mark.long
@pytest.mark.fuzz
def test_any_damage_is_told_or_harmless(tmp_path, rng):
    file = tmp_path / "a.mcap"
    write_file(file, TEXT, [(line(k), png(16, 16)) for k in range(6)])
    whole = file.read_bytes()
    for _ in range(thorough(600, 300)):
        damaged = bytearray(whole)
        for _ in range(rng.integers(1, 4)):
            damaged[rng.integers(len(damaged))] = rng.integers(256)
        file.write_bytes(damaged[: rng.integers(len(damaged) + 1)])
        told = ""
        try:
            session = Session(file)
            assert sum(1 for _ in session) == session.count == len(session.trace) <= 6
        except (ValueError, TypeError) as error:
            told = str(error)
        assert told.isprintable(), told


# --- cut off


def counts_of(file):
    """Messages by topic, as the library reads them; the index must agree."""
    with file.open("rb") as stream:
        opened = make_reader(stream, validate_crcs=True)
        summary = opened.get_summary()
        counts = dict.fromkeys(one.topic for one in summary.channels.values())
        for schema, channel, message in opened.iter_messages(log_time_order=False):
            assert schema.name
            assert message.log_time <= summary.statistics.message_end_time
            counts[channel.topic] = (counts[channel.topic] or 0) + 1
        by_index = summary.statistics.channel_message_counts
        assert {summary.channels[key].topic: n for key, n in by_index.items()} == {
            topic: n for topic, n in counts.items() if n
        }
        assert summary.statistics.chunk_count == len(summary.chunk_indexes)
        named = [one.name for one in opened.iter_metadata()]
        assert summary.statistics.metadata_count == len(summary.metadata_indexes) == len(named)
        return counts


@pytest.mark.long
def test_a_file_cut_anywhere_is_completed(recorded, tmp_path, rng):
    whole = recorded.read_bytes()
    lines = [row.k for row in Session(recorded)._rows]
    ends = [whole.index(b'"k": %d' % k) for k in lines]
    places = [*rng.integers(0, len(whole), thorough(200, 60)), len(whole) - 1, len(whole) - 300]
    for place in places:
        file = tmp_path / f"{place}.mcap"
        file.write_bytes(whole[:place])
        begun = sum(end < place for end in ends)
        if begun == 0:
            with suppress(ValueError):  # before there was a set-up
                assert len(Session(file)) == 0
            continue
        assert Session(file).count in (begun - 1, begun)
        assert file.read_bytes() == whole[:place]  # it may be a copy under way
        os.utime(file, (0, 0))
        session = Session(file)
        assert begun - 1 <= session.count <= begun
        assert sum(one.frame is not None for one in session) == session.count
        assert file.read_bytes()[-8:] == whole[-8:]
        assert counts_of(file).get("/robsim/steps") in (session.count, session.count or None)
        assert complete(file) == "whole"
        again = Session(file)
        assert len(again.trace) == session.count
        np.testing.assert_array_equal(again.trace.u, Session(recorded).trace.u[: session.count])
        file.unlink()


def test_what_is_not_from_a_kill_is_not_cut_off(file):
    whole = bytearray(file.read_bytes())
    with file.open("rb") as stream:
        chunk = make_reader(stream).get_summary().chunk_indexes[2].chunk_start_offset
    for at in (chunk + 5, chunk + 1):
        damaged = whole[:-100]
        damaged[at] = 255
        file.write_bytes(damaged)
        with suppress(ValueError):
            assert Session(file).count == 2
        assert file.read_bytes() == damaged


def test_repair_says_what_it_did(file, tmp_path):
    def said():
        run = command("sessions", "repair", str(file), str(tmp_path / "other"))
        assert run.exit_code == 0, run.output
        return [line.rpartition("it ")[2] for line in run.output.splitlines()]

    shutil.copy(file, tmp_path / "other.mcap")
    file.write_bytes(file.read_bytes()[:-3])
    first, second = said()
    assert "completed" in first
    assert "is complete" in second
    assert said() == [second, second]
    file.write_bytes(b"RIFF")
    other = tmp_path / "other.mcap"
    other.write_bytes(other.read_bytes()[:-3])
    refusal = command("sessions", "repair", str(file), str(other))
    assert refusal.exit_code == 2
    assert file.read_bytes() == b"RIFF"
    assert "completed" in refusal.output


def test_a_file_that_is_written_is_not_completed(tmp_path):
    writer = record(tmp_path / "s", 3)
    writer.flush()
    before = writer.path.read_bytes()
    assert complete(writer.path) == "in use"
    assert Session(writer.path).count == 3
    assert writer.path.read_bytes() == before
    writer.close()
    assert complete(writer.path) == "whole"


def test_what_is_no_session_is_told(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.mcap"):
        Session(tmp_path / "none")
    (tmp_path / "a.mcap").write_bytes(b"RIFF    AVI " + bytes(1000))
    refused(tmp_path / "a", "not an MCAP file")
    (tmp_path / "a.mcap").write_bytes(b"")
    refused(tmp_path / "a", "a.mcap")
    with pytest.raises(FileNotFoundError, match=r"setup\.toml"):
        Session(tmp_path)
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.mcap")
        refused(tmp_path / "pipe", "must be a regular file")


# --- folders of an earlier robsim


def test_a_damaged_folder_is_told(folder):
    rows = (folder / "steps.csv").read_bytes()
    for old, new, words in (
        (b"k,t,", b"t,k,", r"steps\.csv"),
        (b"\n2,", b"\n3,", r"steps\.csv: step 3 .* not follow step 1"),
        (b"\n2,", b"\nx,", r"steps\.csv: .*x"),
        (b"\n2,", b"\n2,9,", r"steps\.csv"),
        (b"\n2,", b"\n" + 10_000 * b"2" + b",", r"steps\.csv"),
        (b"\n2,", b"\n\xff", r"steps\.csv"),
    ):
        (folder / "steps.csv").write_bytes(rows.replace(old, new, 1))
        refused(folder, words)
    (folder / "steps.csv").write_bytes(rows)
    (folder / "setup.toml").write_text("format = 1")
    refused(folder, r"setup\.toml.*format")


def test_a_folder_that_is_cut_off_is_read(folder):
    rows, video = (folder / "steps.csv").read_bytes(), (folder / "frames.mkv").read_bytes()
    (folder / "end.toml").unlink()
    for n in (len(rows) - 4, 300, 100, 0):
        (folder / "steps.csv").write_bytes(rows[:n])
        session = Session(folder)
        assert sum(1 for _ in session) == session.count < 6
        assert not session.is_complete
    (folder / "steps.csv").write_bytes(rows)
    for n in (len(video) // 2, 20_000, 100, 0):
        (folder / "frames.mkv").write_bytes(video[:n])
        assert sum(one.frame is not None for one in Session(folder)) < 6
        assert len(Session(folder)) == 6
