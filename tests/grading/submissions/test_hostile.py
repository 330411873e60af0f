"""Hostile folders and zips: refused in words."""

import io
import os
import random
import re
import socket
import stat
import struct
import sys
import zipfile

import pytest

from robsim.teach.submissions import folder as reader
from submissions import CONTROL, PLAIN, Rules, packed, read_submission, refused, write

on_posix = pytest.mark.skipif(sys.platform == "win32", reason="needs links, pipes and sockets")


# --- folders


SECRET = "import secret; the teacher's own line\n"


@pytest.fixture(params=[True, False], ids=["by descriptor", "by path"])
def by_descriptor(request, monkeypatch):
    """Folders as they are read here, and as where they have no descriptors."""
    if request.param and not reader._BY_DESCRIPTOR:
        pytest.skip("this system has no descriptors of folders")
    monkeypatch.setattr(reader, "_BY_DESCRIPTOR", request.param)
    return request.param


@pytest.fixture
def mine(tmp_path, by_descriptor):
    (tmp_path / "secret.py").write_text(SECRET)
    return write(tmp_path / "s001", control=PLAIN)


def told(mine, words):
    error = refused(mine)
    assert words in str(error)
    assert "teacher" not in str(error)
    return error


@on_posix
def test_links_are_not_followed(mine, tmp_path):
    for target in ("../secret.py", "/etc/passwd", "nothing", "helper.py", "."):
        (mine / "helper.py").symlink_to(target)
        assert told(mine, "s001: 'helper.py' is a link").file == "helper.py"
        (mine / "helper.py").unlink()
    write(tmp_path / "other", helper=SECRET)
    (mine / "lib").symlink_to(tmp_path / "other", target_is_directory=True)
    told(mine, "s001: 'lib' is a link")


@on_posix
def test_a_submission_that_is_a_link_is_not_followed(mine, tmp_path):
    (tmp_path / "s002").symlink_to(mine, target_is_directory=True)
    (tmp_path / "s003.py").symlink_to(tmp_path / "secret.py")
    told(tmp_path / "s002", "s002 is a link")
    told(tmp_path / "s003.py", "s003.py is a link")
    packed(tmp_path / "secret.zip", {"control.py": SECRET})
    folder = tmp_path / "s004"
    folder.mkdir()
    (folder / "mine.zip").symlink_to(tmp_path / "secret.zip")  # all there is
    told(folder, "mine.zip is a link")


@on_posix
def test_pipes_keep_nobody(mine, tmp_path):
    os.mkfifo(mine / "helper.py")
    told(mine, "s001: 'helper.py' is a pipe")
    os.mkfifo(tmp_path / "s002.py")
    told(tmp_path / "s002.py", "s002.py is a pipe")


@on_posix
def test_sockets_are_refused(mine, monkeypatch):
    monkeypatch.chdir(mine)  # its path may be too long for a socket
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("helper.py")
        told(mine, "s001: 'helper.py' is a socket")


@on_posix
def test_devices_are_refused(mine):
    try:
        os.mknod(mine / "helper.py", 0o20666, os.makedev(1, 5))  # zeros without end
    except OSError:
        pytest.skip("may not make devices")
    told(mine, "s001: 'helper.py' is a device")


def becomes_a_link(path, secret):
    if path.is_dir():
        path.rename(path.with_name("old"))
    else:
        path.unlink()
    path.symlink_to(secret if path.suffix else secret.parent / "other")


def becomes_a_pipe(path, secret):
    path.unlink()
    os.mkfifo(path)


@on_posix
@pytest.mark.parametrize("by_descriptor", [True], indirect=True)
@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("control.py", becomes_a_link, "'control.py' cannot be read"),
        ("lib", becomes_a_link, "'lib' cannot be read"),
        ("control.py", becomes_a_pipe, "'control.py' is a pipe"),
    ],
)
def test_what_changes_while_it_is_read_is_not_followed(
    mine, tmp_path, monkeypatch, name, change, words
):
    """Between the look and the opening each file or folder becomes something else."""
    write(tmp_path / "other", helper=SECRET)
    write(mine / "lib", helper="")
    real = os.stat

    def swapped(path, **options):
        status = real(path, **options)
        if path == name:
            change(mine / name, tmp_path / "secret.py")
        return status

    monkeypatch.setattr(reader.os, "stat", swapped)
    told(mine, f"s001: {words}")


@on_posix
def test_a_file_that_grows_is_cut_off(mine, monkeypatch):
    """It is small when it is looked at, and has no end when it is read."""
    with (mine / "hole.bin").open("wb") as file:
        file.truncate(2**40)
    told(mine, "s001: 'hole.bin' has more than 1 MiB")
    monkeypatch.setattr(reader.Intake, "check_size", lambda self, path, size: sizes.append(size))
    sizes = []
    read_submission(mine, CONTROL)
    assert max(size for size in sizes if size < 2**40) == 2**20 + 1


@on_posix
def test_too_many_files_and_too_deep_folders(mine):
    few = Rules(slots=("control",), files=10)
    for i in range(10):
        (mine / f"{i}.txt").touch()
    assert "s001 has more than 10 files" in str(refused(mine, few))
    for i in range(200):
        (mine / f".{i}").touch()
    assert "s001 has more than 200 files and folders" in str(refused(mine, few))
    deep = write(mine.parent / "s002", control=PLAIN)
    for _ in range(9):
        deep /= "a"
        deep.mkdir()
    told(mine.parent / "s002", "has too long a path")


@on_posix
def test_names_that_are_no_text(mine):
    try:
        os.mkdir(os.fsencode(mine) + b"/\xff")
    except OSError:
        pytest.skip("the file system refuses such a name")
    told(mine, "'\\udcff' has invisible characters in its name")


@on_posix
def test_a_file_that_may_not_be_read(mine, monkeypatch):
    real = os.open

    def denied(path, flags, *others, **options):
        if os.path.basename(path) == "control.py":  # as for a user without privileges
            raise PermissionError(13, "Permission denied")
        return real(path, flags, *others, **options)

    monkeypatch.setattr(reader.os, "open", denied)
    told(mine, "'control.py' cannot be read")


@on_posix
def test_no_descriptor_is_left_open(mine):
    before = len(os.listdir("/proc/self/fd")) if sys.platform == "linux" else 0
    os.mkfifo(mine / "helper.py")
    for _ in range(5):
        refused(mine)
    after = len(os.listdir("/proc/self/fd")) if sys.platform == "linux" else 0
    assert after == before


# --- zips


def entry(name, mode=stat.S_IFREG | 0o644, **others):
    info = zipfile.ZipInfo("x")
    info.filename = name
    info.external_attr = mode << 16
    info.compress_type = zipfile.ZIP_DEFLATED
    for key, value in others.items():
        setattr(info, key, value)
    return info


def with_raw_name(path, name, raw):
    """A zip whose entry has a name that Python would not write."""
    assert len(name) == len(raw)
    packed(path, {"control.py": PLAIN, name: "x = 1"})
    path.write_bytes(path.read_bytes().replace(name.encode(), raw))
    return path


HARM = {
    "leads out of the folder": [
        *("../control.py", "a/../../control.py", ".git/../../x", "a/..", "a\\..\\x.py"),
    ],
    "is an absolute path": ["/etc/passwd", "//server/share", "C:/x.py", "c:x.py"],
    "invisible characters in its name": [
        *("a\nb.py", "a\x1b[31m.py", "\u202eyp.lortnoc", "a\u200b.py", "a\u00a0.py"),
        "a\ufffe.py",
    ],
    "has the name of a device": ["con.py", "x/AUX", "lpt1.tar.py"],
    "ends in a space or a dot": ["a /b.py", "a./b.py"],
    "in its name": ["what?.py", "ab:stream.py"],
    "has too long a": [
        *("x" * 151, "x" * 5000, "a/" * 9 + "b", "/".join(("x" * 90, "y" * 90, "z" * 90))),
    ],
    "is an archive inside": ["notes.zip", "notes.TAR"],
    "one file on some systems": [
        "Control.py",
        "CONTROL.PY/x.py",
        "\uff43ontrol.py",
    ],
}


@pytest.mark.parametrize("words", HARM)
def test_names_that_do_harm_somewhere(tmp_path, words):
    for name in HARM[words]:
        path = packed(tmp_path / "s001.zip", {"control.py": PLAIN, entry(name): "x = 1"})
        error = str(refused(path))
        assert words in error
        assert error.startswith("s001.zip: ")
        assert error.isprintable()
        assert os.listdir(tmp_path) == ["s001.zip"]


def test_names_that_do_none(tmp_path):
    for name in ("a .py/b", "x" * 150, "a/" * 7 + "b"):
        path = packed(tmp_path / "s001.zip", {"control.py": PLAIN, entry(name): "x = 1"})
        assert name in read_submission(path, CONTROL).sources


def test_backslashes_of_old_programs_are_those_of_folders(tmp_path):
    names = ("s001\\", "s001\\control.py", "s001\\data\\table.csv")
    files = {entry(name): PLAIN if name.endswith("py") else "" for name in names}
    found = read_submission(packed(tmp_path / "s001.zip", files), CONTROL)
    assert [*found.sources] == ["control.py", "data/table.csv"]


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_file_that_is_there_twice(tmp_path):
    for name, again in (("control.py", "control.py/x"), ("\u00e4.py", "a\u0308.py")):
        for second in (name, again):
            files = {"control.py": PLAIN, entry(name): "", entry(second): "other"}
            error = refused(packed(tmp_path / "s001.zip", files))
            assert f"'{name}' occurs twice" in str(error)


def test_a_null_character_ends_no_name(tmp_path):
    path = with_raw_name(tmp_path / "s001.zip", "controlxpy", b"control\0py")
    assert "has a null character in its name" in str(refused(path))


def test_what_is_no_file(tmp_path):
    for kind in (stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR, stat.S_IFSOCK):
        files = {"control.py": PLAIN, entry("helper.py", kind | 0o777): "/etc/passwd"}
        error = refused(packed(tmp_path / "s001.zip", files))
        assert ("link" if kind == stat.S_IFLNK else "a device or a pipe") in str(error)
        assert error.file == "helper.py"


def test_a_password(tmp_path):
    path = packed(tmp_path / "s001.zip", {"control.py": PLAIN})
    content = bytearray(path.read_bytes())
    content[6] |= 1
    content[content.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(content)
    assert "'control.py' is encrypted" in str(refused(path))


def test_an_unusual_compression(tmp_path):
    for method in (zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA):
        info = entry("control.py", compress_type=method)
        error = refused(packed(tmp_path / "s001.zip", {info: PLAIN}))
        assert "is compressed in an unusual way" in str(error)


@pytest.mark.long
def test_bombs(tmp_path):
    zeros = packed(tmp_path / "s001.zip", {"control.py": PLAIN, "zeros": bytes(900_000)})
    assert "'zeros' is more than 100 times larger than packed" in str(refused(zeros))
    large = packed(tmp_path / "s002.zip", {"control.py": PLAIN, "zeros": bytes(50_000_000)})
    assert "more than 1 MiB" in str(refused(large, Rules(ratio=10_000)))
    each = random.Random(1).randbytes(900_000)
    many = packed(
        tmp_path / "s003.zip", {"control.py": PLAIN} | {f"{i}.bin": each for i in range(6)}
    )
    assert "has more than 5 MiB in all" in str(refused(many))
    files = {"control.py": PLAIN} | {f"{i}.txt": "x" for i in range(100)}
    assert "has more than 100 files" in str(refused(packed(tmp_path / "s004.zip", files)))
    folders = {"control.py": PLAIN} | {f"{i}/": "" for i in range(1999)}
    read_submission(packed(tmp_path / "s005.zip", folders), CONTROL)
    entries = {"control.py": PLAIN} | {f"{i}/": "" for i in range(2000)}
    assert "has too many files" in str(refused(packed(tmp_path / "s006.zip", entries)))
    huge = tmp_path / "s007.zip"
    huge.write_bytes(packed(tmp_path / "x.zip", {"control.py": PLAIN}).read_bytes() + bytes(2**23))
    assert "s007.zip has more than 6 MiB" in str(refused(huge))


def test_a_size_that_is_a_lie_is_counted(tmp_path):
    path = packed(tmp_path / "s001.zip", {"control.py": PLAIN, "zeros": bytes(9_000_000)})
    content = path.read_bytes()
    path.write_bytes(content.replace(struct.pack("<I", 9_000_000), struct.pack("<I", 100)))
    error = str(refused(path, Rules(ratio=10_000)))  # Python stops at 100, and the sum is wrong
    assert "more than 1 MiB" in error or "cannot be read as a zip" in error


def test_entries_that_share_their_bytes_count_each(tmp_path):
    """Each file is the next one's header and bytes: a small zip of any size."""
    body = io.BytesIO()
    with zipfile.ZipFile(body, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros", random.Random(2).randbytes(1000) * 900)
    content = body.getvalue()
    listed = content.index(b"PK\x01\x02")
    end = content.rindex(b"PK\x05\x06")
    one = content[listed:end]
    many = content[:listed] + one * 50
    tail = struct.pack("<4s4H2LH", b"PK\x05\x06", 0, 0, 50, 50, len(one) * 50, listed, 0)
    (tmp_path / "s001.zip").write_bytes(many + tail)
    said = str(refused(tmp_path / "s001.zip", Rules(ratio=10_000)))
    assert re.search("twice|Overlapped", said)  # in our words, or in those of a newer zipfile


def test_what_is_no_zip_or_cut_off(tmp_path):
    whole = packed(tmp_path / "s001.zip", {"control.py": PLAIN * 100}).read_bytes()
    contents = [b"PK\x05\x06", b"hello" * 100, b"PK\x03\x04" * 1000]
    for content in (*contents, *(whole[:length] for length in range(0, len(whole), 7))):
        (tmp_path / "s001.zip").write_bytes(content)
        assert str(refused(tmp_path / "s001.zip")).startswith("s001.zip cannot be read as a zip (")
