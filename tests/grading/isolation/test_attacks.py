"""Layers of isolation against attacks, with all rights and with fewer."""

import ctypes
import json
import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

import graded
import robsim
from graded import layer
from robsim.teach import IsolationError, check_isolation, isolation

on_linux = pytest.mark.skipif(sys.platform != "linux", reason="layers are for Linux")
as_root = pytest.mark.skipif(
    sys.platform != "linux" or os.geteuid() != 0, reason="gives rights of root away"
)


# --- attacks


CALLS, FILES, MOUNTS, USER, PIDS, NETWORK = ALL = (
    *(layer.CALLS, layer.FILES, layer.MOUNTS, layer.USER, layer.PIDS, layer.NETWORK),
)


def only(*names):
    """The layers to leave out so that these alone are made."""
    return tuple(name for name in ALL if name not in names)


@pytest.fixture
def tried(worker):
    """Run a source whose last line prints what it reached; return the layers and the output."""

    def run(source, **options):
        with worker(source, **options) as (started, _):
            started.wait(300)
        return started.layers, started.output

    return run


# Prints that it has reached what it tried, or the number of the error.
def attempt(code):
    lines = "\n    ".join(code.strip().splitlines())
    return f"""
import os, socket, sys, ctypes, signal
libc = ctypes.CDLL(None, use_errno=True)
def call(*a):
    r = libc.syscall(*[ctypes.c_long(x) if isinstance(x, int) else x for x in a])
    if r < 0: raise OSError(ctypes.get_errno(), "")
    return r
try:
    {lines}
    print("reached")
except BaseException as error:
    # Python says ValueError where the kernel refuses a higher limit.
    number = 1 if isinstance(error, ValueError) else getattr(error, "errno", None)
    print("refused", number, type(error).__name__)
"""


GRADER = os.getpid()

BY_CALLS = {
    "fork": "os.fork() or os._exit(0)",
    "vfork by number": "call(58) or os._exit(0)",
    "clone of a process": "call(56, 17, 0, 0, 0, 0) or os._exit(0)",
    "clone with a namespace": "call(56, 0x10000100 | 17, 0, 0, 0, 0) or os._exit(0)",
    "clone3": "call(435, b'\\0' * 88, 88)",
    "x32": "call(0x40000000 | 39)",
    "execve": "os.execv('/bin/true', ['true'])",
    "signal": f"os.kill({GRADER}, 0)",
    "signal to a group": "os.killpg(os.getpgid(0), 0)",
    "signal to a thread": f"call(234, {GRADER}, {GRADER}, 0)",
    "signal by a descriptor": f"signal.pidfd_send_signal(os.pidfd_open({GRADER}), 0)",
    "signal by a file's owner": f"import fcntl; fcntl.fcntl(channel, fcntl.F_SETOWN, {GRADER})",
    "which signal": "import fcntl; fcntl.fcntl(channel, 10, 9)",
    "keys into a terminal": "import fcntl; fcntl.ioctl(0, 0x5412, b'x')",
    "trace": f"call(101, 0x4206, {GRADER}, 0, 0)",
    "a server": "socket.create_server(('127.0.0.1', 0))",
    "a packet": "socket.socket(socket.AF_INET, socket.SOCK_DGRAM)",
    "a socket by name": "socket.socket(socket.AF_UNIX)",
    "raw socket": "socket.socket(socket.AF_PACKET, socket.SOCK_RAW)",
    "netlink": "socket.socket(socket.AF_NETLINK, socket.SOCK_RAW)",
    "SysV memory": "call(29, 7, 4096, 0o1666)",
    "memfd": "os.memfd_create('x')",
    "message queue": "call(240, b'/robsim', 0o102, 0o600, 0)",
    "new user": "call(272, 0x10000000)",
    "mount": "call(165, 0, b'/', 0, 0, 0)",
    "watch of names": "call(294, 0)",
    "io_uring": "call(425, 8, b'\\0' * 120)",
    "bpf": "call(321, 0, b'\\0' * 72, 72)",
    "perf": "call(298, b'\\0' * 128, 0, -1, -1, 0)",
    "userfaultfd": "call(323, 1)",
    "keys": "call(250, 0, -3, 1)",
    "dumpable again": "assert libc.prctl(4, 1, 0, 0, 0) == 0 or call(157, 4, 1, 0, 0, 0) == 0",
    "death signal off": "call(157, 1, 0, 0, 0, 0)",
    "more memory": "import resource; resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))",
    "limits of others": f"import resource; resource.prlimit({GRADER}, resource.RLIMIT_AS, (1, 1))",
    "chmod": "os.chmod('.', 0o777)",
    "priority": "os.setpriority(os.PRIO_PROCESS, 0, 19)",
    "affinity": "os.sched_setaffinity(0, {0})",
}


@on_linux
@pytest.mark.long
@pytest.mark.skipif(os.uname().machine != "x86_64", reason="by the numbers of x86-64")
@pytest.mark.parametrize("without", [(), only(CALLS)], ids=["all layers", "system calls alone"])
def test_calls_are_refused(tried, without):
    source = "\n".join(
        attempt(code) + f"print({name!r}, flush=True)" for name, code in BY_CALLS.items()
    )
    layers, output = tried(source, without=without)
    if not layers.holds(CALLS):
        pytest.skip(layers[CALLS].text)
    lines = output.splitlines()
    results = dict(zip(lines[1::2], lines[::2], strict=True))
    assert list(results) == list(BY_CALLS)
    assert results.pop("clone3").startswith("refused 38 ")  # so that libc takes clone
    assert {name: t for name, t in results.items() if not t.startswith("refused 1 ")} == {}


HONEST = """
import threading, tempfile, math, time, os, resource
import numpy as np
done = []
threads = [threading.Thread(target=done.append, args=(i,)) for i in range(8)]
[t.start() for t in threads]; [t.join() for t in threads]
assert len(done) == 8
a = np.random.default_rng(1).normal(size=(300, 300)); np.linalg.svd(a)
with tempfile.NamedTemporaryFile() as file:
    file.write(b"x"); file.flush()
np.save("mine.npy", a); assert np.load("mine.npy").shape == a.shape
os.mkdir("d"); os.rename("mine.npy", "d/mine.npy"); os.remove("d/mine.npy"); os.rmdir("d")
resource.getrlimit(resource.RLIMIT_AS); os.cpu_count(); os.sched_getaffinity(0); time.sleep(0.01)
import fractions, decimal, statistics, html.parser, concurrent.futures
with concurrent.futures.ThreadPoolExecutor(2) as pool: assert sum(pool.map(abs, [-1, 2])) == 3
import robsim.estimation.reference, scipy.linalg, pandas, matplotlib.pyplot as plt
plt.plot([1, 2]); plt.savefig("a.png"); pandas.DataFrame({"a": [1]}).describe()
open(os.devnull, "w").write("x")
np.random.default_rng().random()
sim = __import__("robsim").Simulation(control=lambda step: (1, 1), seed=1)
assert len(sim.run(20)) == 20
print("fine")
"""


@on_linux
@pytest.mark.long
def test_honest_code_runs(tried):
    assert tried(HONEST)[1].endswith("fine\n")


@on_linux
@pytest.mark.parametrize("without", [(), only(FILES)], ids=["all layers", "files alone"])
def test_files_are_closed(tried, without, tmp_path):
    secret = tmp_path / "truth.txt"
    secret.write_text("truth")
    secret.chmod(0o666)
    tmp_path.chmod(0o777)
    codes = [
        f"open({str(secret)!r}).read()",
        f"open({str(secret)!r}, 'a')",
        f"os.truncate({str(secret)!r}, 0)",
        f"os.remove({str(secret)!r})",
        f"os.rename({str(secret)!r}, 'mine')",
        f"os.link({str(secret)!r}, 'mine')",
        f"os.symlink({str(secret)!r}, 'mine'); open('mine').read()",
        f"os.listdir({str(tmp_path)!r})",
        f"open({str(tmp_path / 'new')!r}, 'w')",
        "os.mkfifo('fifo')",
        "open('/dev/shm/robsim-left', 'w')",
        "open('/etc/passwd').read()",
        f"open('/proc/{GRADER}/mem', 'rb')",
        f"open('/proc/{GRADER}/environ', 'rb')",
        f"open('/proc/{GRADER}/cmdline', 'rb')",
        f"os.listdir('/proc/{GRADER}/fd')",
        "open('/proc/self/mem', 'rb')",
        "os.execv('/bin/true', ['true'])",
        f"open({__file__!r}).read()",
    ]
    source = "\n".join(attempt(code) for code in codes)
    layers, output = tried(source, without=without)
    if not layers.holds(FILES):
        pytest.skip(layers[FILES].text)
    lines = output.splitlines()
    assert [c for c, line in zip(codes, lines, strict=True) if "refused" not in line] == []
    assert secret.read_text() == "truth"
    assert os.listdir(tmp_path) == ["truth.txt"]


# Prints its findings: a folder of the grader's, processes, other workers.
LOOK = """
import ctypes, json, os
def tried(act, *what):
    try: return act(*what)
    except OSError as error: return type(error).__name__
def watch(folder):
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.inotify_add_watch(libc.inotify_init1(0), folder.encode(), 0x100) < 0:
        raise OSError(ctypes.get_errno(), "")
open("mine", "w").write(open(os.devnull).read())
home, above = os.getcwd(), os.path.dirname(os.getcwd())
print(json.dumps({
    "folder": [tried(act, FOLDER) for act in (os.stat, os.listdir, watch)],
    "processes": sorted(os.listdir("/proc")),
    "writes": [tried(os.mkdir, folder) for folder in ("/new", above + "/new", JSON + "/new")],
    "workers": [os.listdir(home), [name for name in os.listdir(above) if name[:7] == "robsim-"]],
    "home": home,
}))
"""


@on_linux
def test_there_are_no_names_but_those_that_are_granted(worker, tried, tmp_path):
    tmp_path.chmod(0o777)
    alone = only(MOUNTS, NETWORK)  # other users than root get both by one call
    known = f"FOLDER, JSON = {str(tmp_path)!r}, {str(Path(json.__file__).parent)!r}"
    stays = "open('theirs', 'w').close()\nchannel.sendall(b'x')\nchannel.recv(1)"
    with worker(stays) as (_, other):
        other.recv(1)
        layers, output = tried(known + LOOK, without=alone)
    assert "robsim-grading" not in Path("/proc/self/mountinfo").read_text()
    if not layers.holds(MOUNTS):
        pytest.skip(layers[MOUNTS].text)
    found = json.loads(output)
    assert found["folder"] == ["FileNotFoundError"] * 3
    assert found["processes"] == ["cpuinfo", "meminfo"]
    assert found["writes"] == ["OSError"] * 3  # on mounts for reading
    assert found["workers"] == [["mine"], [os.path.basename(found["home"])]]


@on_linux
def test_a_package_behind_links_is_found(tmp_path):
    package = tmp_path / "real" / "behind_links"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(
        "def run(channel, memory):\n from behind_links.late import word\n channel.sendall(word)"
    )
    (package / "late.py").write_text("word = b'found'")
    (tmp_path / "link").symlink_to("real")
    ours, theirs = socket.socketpair()
    with ours, theirs:
        options = {"entry": "behind_links:run", "modules": (), "path": (str(tmp_path / "link"),)}
        with isolation.start_worker(channel=theirs, **options) as started:
            assert started.wait(300).exited, started.output
        assert ours.recv(9, socket.MSG_DONTWAIT) == b"found"


@on_linux
def test_what_is_hidden_cannot_be_read(tried):
    package = Path(robsim.__file__).parent
    folder, file = package / "estimation/reference", package / "estimation/evaluation/errors.py"
    source = "\n".join(
        attempt(f"open({str(path)!r}, 'rb').read(1)")
        for path in (folder / "__init__.py", file, package / "control" / "__init__.py")
    )
    layers, output = tried(source + "import robsim.teach.doctor", hidden=[str(folder), str(file)])
    if not layers.holds(FILES):
        pytest.skip(layers[FILES].text)
    hidden, also, beside = output.splitlines()[:3]
    assert "refused 13" in hidden
    assert "refused 13" in also
    assert beside == "reached"


@on_linux
def test_the_network_is_closed(tried):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        code = f"socket.create_connection(('127.0.0.1', {port}), timeout=300)"
        for alone in (CALLS, NETWORK):
            layers, output = tried(attempt(code), without=only(alone))
            assert "refused" in output or not layers.holds(alone)


@on_linux
def test_the_memory_of_the_grader_is_closed(tried):
    secret = ctypes.create_string_buffer(b"truth")
    where = ctypes.addressof(secret)
    opened = f"f = open('/proc/{GRADER}/mem', 'rb'); f.seek({where}); f.read(5)"
    copied = f"""
to = ctypes.create_string_buffer(5)
import struct
a = struct.pack('QQ', ctypes.addressof(to), 5); b = struct.pack('QQ', {where}, 5)
if libc.process_vm_readv({GRADER}, a, 1, b, 1, 0) < 0: raise OSError(ctypes.get_errno(), '')
"""
    for alone in (CALLS, USER, PIDS, FILES):
        _, output = tried(attempt(opened) + attempt(copied), without=only(alone))
        assert output.count("refused") == 2, (alone, output)


@on_linux
def test_own_numbers_and_a_user_hold_a_bomb(tried):
    source = """
import os, time
count = 0
for _ in range(200):
    try:
        if os.fork() == 0: time.sleep(600)
        count += 1
    except OSError:
        break
print(count)
"""
    layers, output = tried(source, without=(CALLS,), threads=8)
    if not layers.holds(USER):
        pytest.skip(layers[USER].text)
    assert int(output) < 8


@on_linux
def test_the_check_tries_all_and_says_what_held():
    report = check_isolation()
    assert "isolation: process" in str(report)
    tried = {
        "files": {
            "read a file",
            "change a file",
            "write outside its folder",
            "read a hidden file",
            "watch a folder",
        },
        "processes": {"signal the grader"},
        "network": {"connect", "send a packet"},
        "the grader's memory": {"open the grader's memory", "trace the grader"},
    }
    assert set(report.closed) == set(tried)
    for what, names in tried.items():
        assert all(report.attempts[name][0] for name in names) or not report.closed[what]
    assert report.attempts["copy the grader's memory"][0]
    has_mounts = (MOUNTS, True) in [layer[:2] for layer in report.layers]
    assert ("find a file" in report.attempts) == has_mounts
    assert report.attempts.get("find a file", [True])[0]
    assert bool(report) == report.strict == (report.verdict == "closed")
    bare = check_isolation(isolation="process")
    assert not bare
    # An attempt on a missing file would be no attempt.
    assert not any(bare.attempts[name][0] for name in tried["files"])
    assert not bare.attempts["start a process"][0]
    assert bare.verdict.startswith("open: files, processes, network")


@on_linux
def test_the_line_of_all_workers_is_the_same():
    """Each worker may have another user."""
    lines = {layer.Layers((layer.Layer(USER, True, number),)).line for number in ("60600", "60601")}
    assert lines == {"isolation: own user"}


@on_linux
def test_strict_is_refused_where_something_is_open(worker):
    for left_out in ((CALLS,), (CALLS, NETWORK), ALL):
        with (
            pytest.raises(IsolationError, match="'strict'"),
            worker("print(1)", isolation="strict", without=(*left_out, NETWORK, FILES)),
        ):
            pass


@on_linux
def test_all_layers_hold_on_a_machine_that_has_them(tried):
    layers, _ = tried("print(1)", isolation="auto")
    assert layers.holds(FILES) == (graded.landlock.landlock_abi() > 0)
    if os.uname().machine in ("x86_64", "aarch64"):
        assert layers.holds(CALLS)
    if all(layers.closed.values()):
        assert layers.certain_end


# --- graders with fewer rights


# The rights that root has in a container as Docker starts it, by their numbers.
CONTAINER = (0, 1, 3, 4, 5, 6, 7, 8, 10, 13, 18, 27, 29, 31)

CHECK = """
import struct, sys
from robsim.teach.isolation._layers import calls
keep = set(map(int, sys.argv[1:]))
for number in range(41):
    if number not in keep:
        calls.prctl(calls.PR_CAPBSET_DROP, number)
mask = sum(1 << number for number in keep)
words = (mask & 0xFFFFFFFF, mask & 0xFFFFFFFF, 0, mask >> 32, mask >> 32, 0)
calls._libc.capset(struct.pack("<Ii", 0x20080522, 0), struct.pack("<6I", *words))
assert not calls.has_capability(21)
from robsim.teach import check_isolation
import json
report = check_isolation()
print(json.dumps([report.layers, report.attempts, report.closed]))
"""


@pytest.mark.long
@as_root
@pytest.mark.parametrize("rights", [CONTAINER, ()], ids=["a container", "root without rights"])
def test_what_holds_without_the_right_to_administer(rights):
    command = [sys.executable, "-c", CHECK, *map(str, rights)]
    run = subprocess.run(command, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    layers, attempts, closed = json.loads(run.stdout.splitlines()[-1])
    held = {name for name, holds, _ in layers if holds}
    assert not held & {"own mounts", "own network", "own process numbers"}
    if not rights:
        assert "user" not in held
    if {"files", "system calls"} <= held:
        assert all(closed.values())
        assert all(refused for refused, _ in attempts.values()), attempts
