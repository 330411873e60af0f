"""Zips that are made to harm who opens them: refused in words, and nothing else happens."""

import io
import random
import stat
import struct
import zipfile

import pytest

from robsim.grading._submissions import Rules, read_submission
from submissions import CONTROL, PLAIN, packed, refused


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


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("../control.py", "leads out of the folder"),
        ("a/../../control.py", "leads out of the folder"),
        (".git/../../x", "leads out of the folder"),
        ("a/..", "leads out of the folder"),
        ("/etc/passwd", "is an absolute path"),
        ("//server/share", "is an absolute path"),
        ("C:/x.py", "is an absolute path"),
        ("c:x.py", "is an absolute path"),
        ("a\\..\\x.py", "leads out of the folder"),
        ("a\\x.py", "has \\ in its name"),
        ("a\nb.py", "characters in its name that cannot be seen"),
        ("a\x1b[31m.py", "characters in its name that cannot be seen"),
        ("\u202eyp.lortnoc", "characters in its name that cannot be seen"),
        ("a\u200b.py", "characters in its name that cannot be seen"),
        ("a\u00a0.py", "characters in its name that cannot be seen"),
        ("a\ufffe.py", "characters in its name that cannot be seen"),
        ("con.py", "has the name of a device under Windows"),
        ("x/AUX", "has the name of a device under Windows"),
        ("lpt1.tar.py", "has the name of a device under Windows"),
        ("a .py/b", None),
        ("a /b.py", "ends in a space or a dot"),
        ("a./b.py", "ends in a space or a dot"),
        ("what?.py", "has ? in its name"),
        ("ab:stream.py", "has : in its name"),
        ("x" * 151, "has too long a name"),
        ("x" * 90 + "/" + "y" * 90 + "/" + "z" * 90, "has too long a path"),
        ("a/" * 9 + "b", "has too long a path"),
        ("notes.zip", "is an archive inside the submission"),
        ("notes.TAR", "is an archive inside the submission"),
        ("Control.py", "and 'control.py' are one file on some systems"),
        ("control.py/x", "and 'control.py' are one file on some systems|is there twice"),
        ("CONTROL.PY/x.py", "and 'control.py' are one file on some systems"),
        ("\uff43ontrol.py", "and 'control.py' are one file on some systems"),
    ],
)  # fmt: skip
def test_names_that_do_harm_somewhere(tmp_path, name, words):
    path = packed(tmp_path / "s001.zip", {"control.py": PLAIN, entry(name): "x = 1"})
    if words is None:
        assert name in read_submission(path, CONTROL).sources
        return
    error = refused(path)
    assert any(each in str(error) for each in words.split("|")), error
    assert str(error).startswith("s001.zip: ")
    assert str(error).isprintable()


def test_names_of_two_spellings_are_one(tmp_path):
    files = {"control.py": PLAIN, "ä.py": "", "ä.py".replace("ä", "a\u0308"): ""}
    assert "'ä.py' is there twice" in str(refused(packed(tmp_path / "s001.zip", files)))


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_file_that_is_there_twice(tmp_path):
    files = {"control.py": PLAIN, entry("control.py"): "other"}
    assert "'control.py' is there twice" in str(refused(packed(tmp_path / "s001.zip", files)))


def test_a_null_character_ends_no_name(tmp_path):
    path = with_raw_name(tmp_path / "s001.zip", "controlxpy", b"control\0py")
    assert "has a null character in its name" in str(refused(path))


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (stat.S_IFLNK, "is a link: put the file itself in its place"),
        (stat.S_IFIFO, "is no file, but a device or a pipe"),
        (stat.S_IFCHR, "is no file, but a device or a pipe"),
        (stat.S_IFSOCK, "is no file, but a device or a pipe"),
    ],
)
def test_what_is_no_file(tmp_path, kind, words):
    files = {"control.py": PLAIN, entry("helper.py", kind | 0o777): "/etc/passwd"}
    error = refused(packed(tmp_path / "s001.zip", files))
    assert str(error).startswith(f"s001.zip: 'helper.py' {words}")
    assert error.file == "helper.py"


def test_a_password(tmp_path):
    path = packed(tmp_path / "s001.zip", {"control.py": PLAIN})
    content = bytearray(path.read_bytes())
    content[6] |= 1
    content[content.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(content)
    assert "'control.py' is encrypted: pack it without a password" in str(refused(path))


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_an_unusual_compression(tmp_path, method):
    info = entry("control.py", compress_type=method)
    error = refused(packed(tmp_path / "s001.zip", {info: PLAIN}))
    assert "is compressed in an unusual way" in str(error)


@pytest.mark.long
def test_bombs(tmp_path):
    zeros = packed(tmp_path / "s001.zip", {"control.py": PLAIN, "zeros": bytes(900_000)})
    assert "'zeros' is more than 100 times larger than packed" in str(refused(zeros))
    large = packed(tmp_path / "s002.zip", {"control.py": PLAIN, "zeros": bytes(50_000_000)})
    assert "more than 1 MiB: make it smaller" in str(refused(large, Rules(ratio=10_000)))
    each = random.Random(1).randbytes(900_000)
    many = packed(
        tmp_path / "s003.zip", {"control.py": PLAIN} | {f"{i}.bin": each for i in range(6)}
    )
    assert "has more than 5 MiB in all: hand in what counts" in str(refused(many))
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
    assert "twice" in str(refused(tmp_path / "s001.zip", Rules(ratio=10_000)))


@pytest.mark.parametrize("content", [b"", b"PK\x05\x06", b"hello" * 100, b"PK\x03\x04" * 1000])
def test_what_is_no_zip(tmp_path, content):
    (tmp_path / "s001.zip").write_bytes(content)
    error = str(refused(tmp_path / "s001.zip"))
    assert error.startswith("s001.zip cannot be read as a zip (")
    assert error.endswith("): pack it again")


def test_a_zip_that_is_cut_off(tmp_path):
    content = packed(tmp_path / "s001.zip", {"control.py": PLAIN * 100}).read_bytes()
    for length in range(0, len(content), 7):
        (tmp_path / "s001.zip").write_bytes(content[:length])
        refused(tmp_path / "s001.zip")
