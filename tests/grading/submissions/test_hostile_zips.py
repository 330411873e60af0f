"""Zips that are made to harm who opens them: refused in words, and nothing else happens."""

import io
import os
import random
import re
import stat
import struct
import zipfile

import pytest

from submissions import CONTROL, PLAIN, Rules, packed, read_submission, refused


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
    "characters in its name that cannot be seen": [
        *("a\nb.py", "a\x1b[31m.py", "\u202eyp.lortnoc", "a\u200b.py", "a\u00a0.py"),
        "a\ufffe.py",
    ],
    "has the name of a device": ["con.py", "x/AUX", "lpt1.tar.py"],
    "ends in a space or a dot": ["a /b.py", "a./b.py"],
    "in its name": ["a\\x.py", "what?.py", "ab:stream.py"],
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


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_file_that_is_there_twice(tmp_path):
    for name, again in (("control.py", "control.py/x"), ("\u00e4.py", "a\u0308.py")):
        for second in (name, again):
            files = {"control.py": PLAIN, entry(name): "", entry(second): "other"}
            error = refused(packed(tmp_path / "s001.zip", files))
            assert f"'{name}' is there twice" in str(error)


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
