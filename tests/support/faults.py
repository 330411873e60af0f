"""Writers of the package, each of whose calls fails in turn, or whose process is killed there.

A program of its own, which the tests start with faults.c preloaded:
``python faults.py FOLDER errors|kills [WRITER ...]``. It prints what was tried, and raises an
AssertionError at the first fault that leaves something else than the old or the new.
"""

import ctypes
import errno
import itertools
import os
import sys
import tempfile
import traceback
from functools import cache, partial
from pathlib import Path

import numpy as np

import robsim
from robsim import vision as imaging
from robsim import vision as robots

TRACE = robsim.Simulation(seed=1).run(6)


def pictures(i):
    return [np.full((16, 32, 3), 100 * i + 10 * k, np.uint8) for k in range(3)]


def video_level(file):
    frames = [frame.image for frame in robsim.Recording(file)]
    assert len(frames) == 3
    return int(frames[0].mean() > 50)


def square(left, top, side):
    return [(left, top), (left + side, top), (left + side, top + side), (left, top + side)]


@cache
def robot(i):
    return robots.RobotDefinition(
        name="mine",
        image=np.full((20, 40, 4), 200 + i, np.uint8),
        size=100.0 + i,
        alignment=0.0,
        outline=[(0, 0), (39, 0), (39, 19), (0, 19)],
        markers={
            "front": robots.BlobMarker(square(22, 4, 10), "red"),
            "back": robots.BlobMarker(square(4, 4, 10), "blue"),
        },
    )


def store_robot(i):
    robots.add_robot("mine", robot(i), overwrite=True, ignore_colors=True)


def rotate_robot(i):
    if i == 0:
        store_robot(0)
    elif rotated() == 0:
        robots.rotate_robot("mine", 90)


def rotated():
    return [0.0, 90.0].index(robots.load_robot("mine").alignment)


def remove_robot(i):
    if i == 0:
        store_robot(0)
    elif "mine" in robots.robot_names():
        robots.remove_robot("mine")


def is_removed():
    if "mine" in robots.robot_names():
        robots.load_robot("mine")
        return 0
    return 1


def versions(write, read, name):
    """The writer of a file of this name, whose content is that of one of two versions."""
    return lambda folder, i: write(folder / name, i), lambda folder: read(folder / name)


def of_robots(write, read):
    """The writer of what a user keeps of robots, in a folder."""

    def there(work, folder, *version):
        os.environ["ROBSIM_DATA"] = str(folder)
        return work(*version)

    return partial(there, write), partial(there, read)


# name -> (write version 0 or 1 into a folder, tell which version is there)
WRITERS = {
    "trace": versions(
        lambda file, i: TRACE[: 3 + i].save(file),
        lambda file: len(robsim.Trace.load(file)) - 3,
        "run.npz",
    ),
    "csv": versions(
        lambda file, i: TRACE[: 3 + i].to_csv(file),
        lambda file: file.read_text().count("\n") - 4,
        "run.csv",
    ),
    "mp4": versions(lambda f, i: imaging.save_video(f, pictures(i), fps=5), video_level, "v.mp4"),
    "robot": of_robots(store_robot, lambda: [robot(0), robot(1)].index(robots.load_robot("mine"))),
    "rotated robot": of_robots(rotate_robot, rotated),
    "removed robot": of_robots(remove_robot, is_removed),
}

# Calls that may fail without harm: at worst, a hidden file waits for the next writer.
HARMLESS = ("close", "unlink", "rmdir", "open", "mkdir")


def visible(folder):
    return sorted(
        str(file.relative_to(folder))
        for file in folder.rglob("*")
        if file.is_file() and not any(part[0] == "." for part in file.relative_to(folder).parts)
    )


def hidden(folder):
    return set(folder.rglob(".*"))


def descriptors():
    """Those that are open, but for the one of this listing."""
    return {
        name for name in os.listdir("/proc/self/fd") if os.path.lexists(f"/proc/self/fd/{name}")
    }


class Faults:
    """The library that is preloaded."""

    def __init__(self):
        self._library = ctypes.CDLL(None)
        self._library.fault_failed.restype = ctypes.c_char_p

    def arm(self, folder, number, error):
        self._library.fault_arm(str(folder).encode(), ctypes.c_long(number), error)

    def disarm(self):
        """Return the call that failed, or an empty text."""
        self._library.fault_disarm()
        return self._library.fault_failed().decode()


def check(name, folder, call, old_files):
    """What must hold after every fault, and after the next writer."""
    write, read = WRITERS[name]
    version = read(folder)
    assert version in (0, 1), (name, call, version)
    names = {file.replace("robot-2.png", "robot.png") for file in visible(folder)}
    assert names <= {file.replace("robot-2.png", "robot.png") for file in old_files}, (name, call)
    for i in (0, 1):
        write(folder, i)
        assert read(folder) == i, (name, call)
    return version


def fail_each(name, folder, faults, error):
    """Let each call of a writer fail in turn; return how many there were."""
    write, read = WRITERS[name]
    for number in itertools.count(1):
        write(folder, 0)
        assert read(folder) == 0
        old_files, hidden_before, before = visible(folder), hidden(folder), descriptors()
        faults.arm(folder, number, error)
        raised = None
        try:
            write(folder, 1)
        except (OSError, ValueError) as caught:  # a reader's ValueError has the OSError in it
            raised = caught
        call = faults.disarm()
        del_tracebacks(raised)
        assert descriptors() == before, (name, call, number, "descriptors")
        if not call:
            assert raised is None, (name, raised)
            break
        assert raised is not None or call in HARMLESS, (name, call, number, "not told")
        if isinstance(raised, OSError):
            assert ".robsim-part" not in str(raised), (name, call, str(raised))
        if call not in HARMLESS and name != "removed robot":  # which is hidden first
            assert hidden(folder) <= hidden_before, (name, call, "left behind")
        version = check(name, folder, call, old_files)
        assert raised is not None or version == 1, (name, call, number, "neither told nor done")
    return number - 1


def del_tracebacks(error):
    while error is not None:
        error.__traceback__ = None
        error = error.__cause__ or error.__context__


def killed_at(faults, folder, number, work):
    """Do work in a child, kill it at one of its calls; return whether there was one."""
    child = os.fork()
    if child == 0:
        try:
            faults.arm(folder, number, 0)
            work()
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    assert os.WIFSIGNALED(status) or status == 0, number
    return os.WIFSIGNALED(status)


def kill_each(name, folder, faults):
    """Kill a child at each call of a writer in turn; return how many there were."""
    write, _ = WRITERS[name]
    for number in itertools.count(1):
        write(folder, 0)
        old_files = visible(folder)
        if not killed_at(faults, folder, number, lambda: write(folder, 1)):
            break
        check(name, folder, number, old_files)
    return number - 1


def main(parent, kind, *names):
    faults = Faults()
    for name in names:
        folder = Path(tempfile.mkdtemp(dir=parent))
        if kind == "kills":
            count = kill_each(name, folder, faults)
        else:
            count = fail_each(name, folder, faults, errno.ENOSPC)
        assert count > 5, (name, count)
        print(f"{name}: {count}")


if __name__ == "__main__":
    main(*sys.argv[1:])
