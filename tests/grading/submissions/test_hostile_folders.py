"""Folders with what is no file of theirs: never followed, never waited for."""

import os
import socket
import sys

import pytest

from robsim.teach.submissions import folder as reader
from submissions import CONTROL, PLAIN, Rules, packed, read_submission, refused, write

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs links, pipes and sockets")

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


def test_links_are_not_followed(mine, tmp_path):
    for target in ("../secret.py", "/etc/passwd", "nothing", "helper.py", "."):
        (mine / "helper.py").symlink_to(target)
        assert told(mine, "s001: 'helper.py' is a link").file == "helper.py"
        (mine / "helper.py").unlink()
    write(tmp_path / "other", helper=SECRET)
    (mine / "lib").symlink_to(tmp_path / "other", target_is_directory=True)
    told(mine, "s001: 'lib' is a link")


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


def test_pipes_keep_nobody(mine, tmp_path):
    os.mkfifo(mine / "helper.py")
    told(mine, "s001: 'helper.py' is a pipe")
    os.mkfifo(tmp_path / "s002.py")
    told(tmp_path / "s002.py", "s002.py is a pipe")


def test_sockets_are_refused(mine, monkeypatch):
    monkeypatch.chdir(mine)  # its path may be too long for a socket
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("helper.py")
        told(mine, "s001: 'helper.py' is a socket")


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


def test_a_file_that_grows_is_cut_off(mine, monkeypatch):
    """It is small when it is looked at, and has no end when it is read."""
    with (mine / "hole.bin").open("wb") as file:
        file.truncate(2**40)
    told(mine, "s001: 'hole.bin' has more than 1 MiB")
    monkeypatch.setattr(reader.Intake, "check_size", lambda self, path, size: sizes.append(size))
    sizes = []
    read_submission(mine, CONTROL)
    assert max(size for size in sizes if size < 2**40) == 2**20 + 1


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


def test_names_that_are_no_text(mine):
    try:
        os.mkdir(os.fsencode(mine) + b"/\xff")
    except OSError:
        pytest.skip("the file system refuses such a name")
    told(mine, "'\\udcff' has characters in its name that cannot be seen")


def test_a_file_that_may_not_be_read(mine, monkeypatch):
    real = os.open

    def denied(path, flags, *others, **options):
        if os.path.basename(path) == "control.py":  # as for a user without privileges
            raise PermissionError(13, "Permission denied")
        return real(path, flags, *others, **options)

    monkeypatch.setattr(reader.os, "open", denied)
    told(mine, "'control.py' cannot be read")


def test_no_descriptor_is_left_open(mine):
    before = len(os.listdir("/proc/self/fd")) if sys.platform == "linux" else 0
    os.mkfifo(mine / "helper.py")
    for _ in range(5):
        refused(mine)
    after = len(os.listdir("/proc/self/fd")) if sys.platform == "linux" else 0
    assert after == before
