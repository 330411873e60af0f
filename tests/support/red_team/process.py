"""Attacks by processes: exits, signals, forks, threads, sockets, memory, time."""

from red_team.attack import ITS_OWN, SHORT, Attack, at_once, attack

_CAN = "any process may start others, and have sockets"

PROCESSES = [
    at_once("os._exit(0)", "ends as if all were well", says=r"exit code 0\)")("os._exit(0)"),
    Attack("os._exit(0) at the start", "ends when it is loaded", "os._exit(0)", says="exit code 0"),
    at_once("sys.exit", "ends Python in a call", says="SystemExit")("sys.exit(0)"),
    Attack("sys.exit at the start", "ends Python when it is loaded", "sys.exit(0)"),
    at_once(
        "exit from a thread",
        "ends the process from another thread while it is asked",
        says="exit code 0",
    )("""
threading.Timer(0.01, os._exit, (0,)).start()
time.sleep(10)
"""),
    at_once("null pointer", "crashes", says="SIGSEGV")("ctypes.string_at(0)"),
    at_once("abort", "aborts", says="SIGABRT|SIGSEGV")("os.abort()"),
    at_once("SIGKILL to itself", "kills itself", says="SIGKILL|took longer|PermissionError")("""
import signal
os.kill(os.getpid(), signal.SIGKILL)
time.sleep(10)
"""),
    at_once(
        "SIGSTOP to itself",
        "stops itself, so that it neither answers nor ends",
        says="took longer|PermissionError",
    )("""
import signal
os.kill(os.getpid(), signal.SIGSTOP)
time.sleep(10)
"""),
    at_once(
        "signals to its group",
        "signals the group and the session that it is in",
        says="SIGTERM|PermissionError",
    )("""
import signal
os.killpg(0, signal.SIGTERM)
time.sleep(10)
"""),
    at_once(
        "signals to its parent",
        "kills, stops and wakes the process that has started it, and the grader",
        why="processes of one user may signal each other",
        runs_bare=False,
    )("""
import signal
for number in (os.getppid(), {grader}):
    for sign in (signal.SIGKILL, signal.SIGSTOP, signal.SIGCHLD, signal.SIGUSR1):
        if number > 1:
            tries('a signal', lambda: os.kill(number, sign))
"""),
    attack(
        "signal handlers and timers",
        "raises exceptions wherever its process is, a thousand times a second",
        ITS_OWN,
    )("""
import signal
def interrupt(number, frame):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, interrupt)
signal.setitimer(signal.ITIMER_REAL, 0.05, 0.001)
cheat = honest
"""),
    at_once(
        "a fork that answers, too",
        "has two processes say things on one wire",
        ITS_OWN,
        why=_CAN,
        limits=SHORT | {"run": 3.0},
    )('tries("a process", os.fork)'),
    at_once("200 processes", "forks until it cannot", why=_CAN, says="took longer")("""
for i in range(200):
    try:
        if os.fork() == 0: time.sleep(600)
        reached('a process') if i == 0 else None
    except OSError: break
time.sleep(600)
"""),
    at_once("a daemon", "forks twice, leaves its session, and ignores signals", why=_CAN)("""
import signal
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        reached('a daemon')
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(600)
    os._exit(0)
time.sleep(0.1)
os._exit(0)
"""),
    at_once(
        "other programs", "runs a shell, and Python, in a process and in its own place", why=_CAN
    )("""
import subprocess
tries('a program', lambda: subprocess.run(['true'], timeout=5))
tries('a shell', lambda: os.posix_spawn('/bin/true', ['true'], {}))
os.execv('/bin/true', ['true'])
"""),
    attack(
        "threads that spin",
        "answers honestly, beside threads that use all the time there is",
        ITS_OWN,
        says="took longer|processor time",
        limits={"run": 1.5},
    )("""
def spin():
    while True: pass
def cheat(step):
    if once(step):
        for _ in range(4): threading.Thread(target=spin, daemon=True).start()
    return honest(step)
"""),
    attack(
        "processor time beside honest answers",
        "uses more of it than it may, in a thread that holds no lock",
        says="more than 1 s of processor time",
        limits={"cpu": 1.0},
    )("""
import hashlib
data = bytes(1 << 24)
def spin():
    while True: hashlib.sha256(data).digest()
def cheat(step):
    if step.k == 0: threading.Thread(target=spin, daemon=True).start()
    while time.process_time() < 0.1 * step.k: time.sleep(0.01)
    return honest(step)
"""),
    attack(
        "threads that outlive", "answers honestly, and leaves threads that do not end", ITS_OWN
    )("""
def cheat(step):
    if once(step): threading.Thread(target=time.sleep, args=(600,)).start()
    return honest(step)
"""),
    at_once("threads without end", "starts threads until it cannot")("""
while True: threading.Thread(target=time.sleep, args=(600,), daemon=True).start()
"""),
    at_once(
        "holds the interpreter",
        "sleeps in a call that lets no other thread run",
        says="took longer",
    )("ctypes.PyDLL(None).sleep(600)"),
    at_once("loops", "never answers", says="took longer")("while True: pass"),
    Attack(
        "loads without end",
        "is never loaded",
        "time.sleep(600)",
        says="loading the submission took longer",
        limits={"first_call": 0.5},
    ),
    attack("atexit", "hangs, prints and forks when Python ends", ITS_OWN)("""
import atexit
atexit.register(lambda: time.sleep(600))
atexit.register(lambda: reached("its own end"))
cheat = honest
"""),
    attack("__del__", "hangs when its objects go away", says="took longer")("""
class Stays:
    def __del__(self): time.sleep(600)
def cheat(step):
    if once(step): Stays()
"""),
    at_once("faulthandler", "lets a watchdog of Python's end the process with a report")("""
import faulthandler
faulthandler.dump_traceback_later(0.05, exit=True, file=sys.__stderr__)
time.sleep(600)
"""),
    at_once("bytes", "asks for 4 GiB", says="MemoryError|memory")("x = bytes(1 << 32)"),
    at_once(
        "arrays", "fills arrays until there is no memory", says="emory", limits={"memory": 1 << 28}
    )("""
x = []
while True: x.append(np.ones(1 << 22))
"""),
    at_once("mappings", "maps memory until there is none", says="emory")("""
import mmap
x = []
while True: x.append(mmap.mmap(-1, 1 << 26))
x[0][0]
"""),
    at_once(
        "memfd", "fills files in memory, which count to no mapping", says="Error|took longer"
    )("""
x = []
while True: x.append(os.memfd_create('x')); os.write(x[-1], bytes(1 << 20))
"""),
    at_once("limits", "raises its own limits")("""
import resource
for what in (resource.RLIMIT_AS, resource.RLIMIT_CPU, resource.RLIMIT_FSIZE):
    tries('a limit', lambda: resource.setrlimit(what, (-1, -1)))
"""),
    at_once("output without end", "prints until it is ended", says="took longer")(
        "while True: print('x' * 65536)"
    ),
    at_once("warnings as output", "warns and logs, in colours")("""
import logging, warnings
for i in range(2000): warnings.warn(f'\\x1b[2J{i}'); logging.error('\\x07%d', i)
"""),
    at_once("sockets", "opens sockets of all kinds", why=_CAN)("""
for family in ('INET', 'INET6', 'UNIX', 'NETLINK', 'PACKET', 'VSOCK', 'ALG'):
    for kind in ('STREAM', 'DGRAM', 'RAW', 'SEQPACKET'):
        number = getattr(socket, f'AF_{family}')
        tries(family, lambda: socket.socket(number, getattr(socket, f'SOCK_{kind}')))
"""),
    at_once(
        "a server on loopback",
        "connects to one of the grader's, and makes one of its own",
        why=_CAN,
    )("""
tries('a server', lambda: socket.create_server(('127.0.0.1', 0)))
address = ('127.0.0.1', {port})
tries('TCP', lambda: socket.create_connection(address, timeout=2))
def send():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.sendto(b'x', address)
tries('UDP', send)
"""),
    at_once(
        "abstract sockets",
        "takes the names by which graders say that a user is taken, and speaks to one",
        why=_CAN,
    )("""
def take(number):
    s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    s.bind(f'\\0robsim-worker-{number}')
for number in range(61100, 61105): tries('a name', lambda: take(number))
"""),
    at_once(
        "a socket pair that carries descriptors",
        "sends its wire to itself, and reads it from another thread",
        ITS_OWN,
        limits=SHORT,
    )("""
one, other = socket.socketpair()
socket.send_fds(one, [b"x"], [wire().fileno()])
_, (copy,), _, _ = socket.recv_fds(other, 1, 1)
threading.Thread(target=os.read, args=(copy, 99), daemon=True).start()
"""),
]
