"""The writing of files: links, modes, devices, faults."""

import importlib.util
import os
import re
import shutil
import stat
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

import robsim
import surroundings
from robsim import vision as imaging
from robsim.base.files import copy_files, open_whole, write_whole
from sizes import thorough

COMPILER = shutil.which("cc") or shutil.which("gcc")
on_posix = pytest.mark.skipif(os.name == "nt", reason="links, modes and pipes of POSIX")
with_compiler = pytest.mark.skipif(
    not (COMPILER and sys.platform == "linux"), reason="needs a C compiler"
)


# --- links, modes, devices and pipes


PACKAGE = Path(robsim.__file__).resolve().parent
PICTURE = np.full((8, 16, 3), 7, np.uint8)
TRACE = robsim.Simulation(seed=1).run(2)


def names(folder):
    return sorted(file.name for file in folder.iterdir())


def mode(file):
    return stat.S_IMODE(os.stat(file).st_mode)


# Functions that write a file of their suffix.
SAVERS = {
    ".npz": lambda file: TRACE.save(file),
    ".csv": lambda file: TRACE.to_csv(file),
    ".png": lambda file: imaging.save_image(file, PICTURE),
    ".webp": lambda file: imaging.Clip([PICTURE], fps=5).save(file),
    ".mkv": lambda file: imaging.save_video(file, [PICTURE], fps=5),
    ".toml": lambda file: robsim.Scenario().save(file),
}


@pytest.fixture(params=SAVERS)
def saver(request):
    if request.param == ".mkv":
        pytest.importorskip("cv2")
    return request.param, SAVERS[request.param]


@on_posix
def test_a_link_stays_one_and_leads_to_the_new_content(tmp_path, saver):
    suffix, save = saver
    (tmp_path / "there").mkdir()
    target = tmp_path / "there" / f"real{suffix}"
    link, second = tmp_path / "a", tmp_path / f"b{suffix}"
    link.symlink_to(Path("there") / target.name)
    second.symlink_to(link)
    for _ in range(2):  # at first, the link leads nowhere
        save(second)
        assert [link.is_symlink(), second.is_symlink(), target.is_symlink()] == [1, 1, 0]
        assert names(tmp_path / "there") == [target.name]
        assert target.stat().st_size > 10


@on_posix
def test_a_new_file_has_the_mode_of_the_umask_and_an_old_one_its_own(tmp_path, saver):
    suffix, save = saver
    file = tmp_path / f"run{suffix}"
    before = os.umask(0o027)
    try:
        save(file)
        assert mode(file) == 0o640
        for given in (0o600, 0o666, 0o755):
            file.chmod(given)
            save(file)
            assert mode(file) == given
    finally:
        os.umask(before)


@on_posix
def test_a_pipe_is_written_into(tmp_path, saver):
    suffix, save = saver
    pipe, got = tmp_path / f"pipe{suffix}", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    save(pipe)
    reader.join(300)
    save(tmp_path / f"file{suffix}")
    assert pipe.is_fifo()
    expected = (tmp_path / f"file{suffix}").read_bytes()
    assert len(got[0]) == len(expected)
    assert got[0] == expected or suffix == ".mkv"  # which has a random number in it


@on_posix
def test_a_device_stays_one(tmp_path):
    write_whole(Path("/dev/null"), b"content")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    link = tmp_path / "full"
    link.symlink_to("/dev/full")
    with pytest.raises(OSError, match="No space left") as caught:
        write_whole(link, b"content")
    assert caught.value.filename == str(link)


@on_posix
def test_a_name_may_be_as_long_as_the_system_allows(tmp_path, saver):
    suffix, save = saver
    for length in (222, 255):
        file = tmp_path / ((length - len(suffix)) * "x" + suffix)
        save(file)
        assert names(tmp_path) == [file.name]
        file.unlink()
    with pytest.raises(OSError, match="File name too long") as caught:
        write_whole(tmp_path / (256 * "x"), b"")
    assert caught.value.filename == str(tmp_path / (256 * "x"))


@on_posix
def test_where_no_file_can_be(tmp_path, saver):
    suffix, save = saver
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    (tmp_path / "file").write_text("")
    for file in (folder, *(tmp_path / parent / f"run{suffix}" for parent in ("gone", "file"))):
        with pytest.raises((OSError, ValueError)) as caught:
            save(file)
        assert str(file) in str(caught.value)
    assert names(folder) == []


@on_posix
@pytest.mark.skipif(os.name == "posix" and os.getuid() == 0, reason="root may write everywhere")
def test_a_file_that_is_protected_is_not_replaced(tmp_path):
    file = tmp_path / "mine"
    file.write_text("old")
    file.chmod(0o400)
    with pytest.raises(PermissionError):
        write_whole(file, b"new")
    assert file.read_text() == "old"


@on_posix
def test_an_exception_leaves_the_old_content(tmp_path):
    file = tmp_path / "run.csv"
    write_whole(file, b"old")

    def stopped():
        with open_whole(file) as stream:
            stream.write(b"ne")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert file.read_bytes() == b"old"
    assert names(tmp_path) == ["run.csv"]


@on_posix
def test_content_is_on_the_disk_before_it_has_its_name_and_the_name_after_it(tmp_path, monkeypatch):
    calls = []
    sync, replace = os.fsync, os.replace

    def noted_sync(descriptor):
        is_folder = stat.S_ISDIR(os.fstat(descriptor).st_mode)
        calls.append("fsync of the folder" if is_folder else "fsync")
        sync(descriptor)

    def noted_replace(*paths):
        calls.append("replace")
        replace(*paths)

    monkeypatch.setattr(os, "fsync", noted_sync)
    monkeypatch.setattr(os, "replace", noted_replace)
    write_whole(tmp_path / "file", b"content")
    assert calls == ["fsync", "replace", "fsync of the folder"]


@on_posix
def test_a_copy_takes_the_place_of_nothing_that_is_there(tmp_path):
    source = tmp_path / "source"
    source.write_text("ours")
    assert copy_files([source], tmp_path / "new") == [tmp_path / "new/source"]
    (tmp_path / "new/source").write_text("theirs")
    with pytest.raises(FileExistsError):
        copy_files([source], tmp_path / "new")
    assert (tmp_path / "new/source").read_text() == "theirs"
    assert names(tmp_path / "new") == ["source"]


@on_posix
@pytest.mark.long
def test_two_processes_write_into_one_folder_and_lose_nothing(tmp_path):
    program = (
        "import sys; from pathlib import Path; from robsim.base.files import write_whole\n"
        "for i in range(100): write_whole(Path(sys.argv[1]) / f'{sys.argv[2]}{i % 3}', b'x')"
    )
    commands = [[sys.executable, "-c", program, str(tmp_path), name] for name in ("a", "b")]
    runs = [subprocess.Popen(command) for command in commands]
    assert [run.wait(300) for run in runs] == [0, 0]
    assert names(tmp_path) == ["a0", "a1", "a2", "b0", "b1", "b2"]


# --- nobody writes in another way


# What writes otherwise: the writer itself; in memory for it; into a temporary folder or a pipe; to
# where a killed run must leave what it had.
OTHERS = (
    *("base/files/", "base/values.py", "notebooks/"),
    *("teach/grading/", "teach/isolation/", "teach/submissions/"),
    *("teach/assignments/rehearsal.py", "teach/assignments/making.py"),
    *("teach/assignments/_own_tests/child.py", "teach/assignments/packing/gradescope.py"),
    *("campaigns/engines/processes.py", "cli/results.py", "cli/simulated/run.py"),
    *("gui/panels/still_picture.py", "vision/imaging/video.py"),
    *("plotting/beside.py", "plotting/style.py", "trace/sessions/writer.py"),
    "trace/_trace_file.py",
)
WRITES = re.compile(
    r"""open\([^)\n]*["'][rbt+]*[wax][bt+]*["']|\b(write_(text|bytes)|(save(fig|txt|z\w*)|tofile)|"""
    r"""imwrite|VideoWriter|mkstemp|NamedTemporaryFile|ZipFile|symlink_to|touch|fdopen)\("""
    r"""|shutil\.copy|O_CREAT|O_WRONLY"""
)


@on_posix
@pytest.mark.long
def test_every_file_is_written_by_the_one_writer():
    texts = {str(f.relative_to(PACKAGE)): f.read_text() for f in PACKAGE.rglob("*.py")}
    code = {name: re.sub(r"(?m)^ *(>>>|\.\.\.) .*", "", text) for name, text in texts.items()}
    found = [name for name, text in code.items() if WRITES.search(text)]
    assert [name for name in found if not name.startswith(OTHERS)] == []


# --- faults


SUPPORT = Path(__file__).parents[1] / "support"


def survived(folder, kind, *writers):
    """Try the faults of a kind on some writers, in a process of its own."""
    library = folder / "faults.so"
    source = str(SUPPORT / "faults.c")
    command = [COMPILER, "-shared", "-fPIC", "-Wall", "-Werror", "-o", str(library), source, "-ldl"]
    subprocess.run(command, check=True)
    if surroundings.ADDRESS_SANITIZER:
        pytest.skip("the sanitizer must be loaded first")
    environment = {**os.environ, "LD_PRELOAD": str(library), "OPENBLAS_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(sys.path)
    program = [sys.executable, "-W", "error", str(SUPPORT / "faults.py"), str(folder), kind]
    done = subprocess.run([*program, *writers], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert {line.split(": ")[0] for line in done.stdout.splitlines()} == set(writers)


@pytest.mark.slow
@with_compiler
@pytest.mark.parametrize("kind", ["errors", "kills"])
def test_every_writer_survives_all_of_it(tmp_path, kind):
    video = ("mp4",) if importlib.util.find_spec("cv2") else ()
    writers = ("csv", "robot", "removed robot", *thorough(("trace", "rotated robot", *video), ()))
    survived(tmp_path, kind, *writers)
