"""Attacks by processes: exits, signals, forks, threads, sockets, memory, time."""

from red_team.attack import ITS_OWN, LAYERS, SHORT, Attack

_CAN = "any process may start others, and have sockets"


def at_once(*lines: str) -> str:
    body = "\n".join(f"        {line}" for line in lines)
    return f"\ndef cheat(step):\n    if once(step):\n{body}\n"


PROCESSES = [
    Attack(
        "os._exit(0)", "ends as if all were well", at_once("os._exit(0)"), says=r"exit code 0\)"
    ),
    Attack("os._exit(0) at the start", "ends when it is loaded", "os._exit(0)", says="exit code 0"),
    Attack("sys.exit", "ends Python in a call", at_once("sys.exit(0)"), says="SystemExit"),
    Attack("sys.exit at the start", "ends Python when it is loaded", "sys.exit(0)"),
    Attack(
        "exit from a thread",
        "ends the process from another thread while it is asked",
        at_once("threading.Timer(0.01, os._exit, (0,)).start()", "time.sleep(10)"),
        says="exit code 0",
    ),
    Attack("null pointer", "crashes", at_once("ctypes.string_at(0)"), says="SIGSEGV"),
    Attack("abort", "aborts", at_once("os.abort()"), says="SIGABRT|SIGSEGV"),
    Attack(
        "SIGKILL to itself",
        "kills itself",
        at_once("import signal", "os.kill(os.getpid(), signal.SIGKILL)", "time.sleep(10)"),
        says="SIGKILL|took longer|PermissionError",
    ),
    Attack(
        "SIGSTOP to itself",
        "stops itself, so that it neither answers nor ends",
        at_once("import signal", "os.kill(os.getpid(), signal.SIGSTOP)", "time.sleep(10)"),
        says="took longer|PermissionError",
    ),
    Attack(
        "signals to its group",
        "signals the group and the session that it is in",
        at_once("import signal", "os.killpg(0, signal.SIGTERM)", "time.sleep(10)"),
        says="SIGTERM|PermissionError",
    ),
    Attack(
        "signals to its parent",
        "kills, stops and wakes the process that has started it, and the grader",
        at_once(
            "import signal",
            "for number in (os.getppid(), {grader}):",
            "    for sign in (signal.SIGKILL, signal.SIGSTOP, signal.SIGCHLD, signal.SIGUSR1):",
            "        if number > 1:",
            "            tries('a signal', lambda: os.kill(number, sign))",
        ),
        held_by=LAYERS,
        why="processes of one user may signal each other",
        runs_bare=False,
    ),
    Attack(
        "signal handlers and timers",
        "raises exceptions wherever its process is, a thousand times a second",
        """
import signal
def interrupt(number, frame):
    raise KeyboardInterrupt
signal.signal(signal.SIGALRM, interrupt)
signal.setitimer(signal.ITIMER_REAL, 0.05, 0.001)
cheat = honest
""",
        ITS_OWN,
        says=".",
    ),
    Attack(
        "a fork that answers, too",
        "has two processes say things on one wire",
        """
def cheat(step):
    if once(step):
        tries("a process", os.fork)
    return honest(step)
""",
        ITS_OWN,
        LAYERS,
        _CAN,
        limits=SHORT | {"run": 3.0},
    ),
    Attack(
        "200 processes",
        "forks until it cannot",
        at_once(
            "for i in range(200):",
            "    try:",
            "        if os.fork() == 0: time.sleep(600)",
            "        reached('a process') if i == 0 else None",
            "    except OSError: break",
            "time.sleep(600)",
        ),
        held_by=LAYERS,
        why=_CAN,
        says="took longer",
    ),
    Attack(
        "a daemon",
        "forks twice, leaves its session, and ignores signals",
        at_once(
            "import signal",
            "if os.fork() == 0:",
            "    os.setsid()",
            "    if os.fork() == 0:",
            "        reached('a daemon')",
            "        signal.signal(signal.SIGTERM, signal.SIG_IGN)",
            "        time.sleep(600)",
            "    os._exit(0)",
            "time.sleep(0.1)",
            "os._exit(0)",
        ),
        held_by=LAYERS,
        why=_CAN,
    ),
    Attack(
        "other programs",
        "runs a shell, and Python, in a process and in its own place",
        at_once(
            "import subprocess",
            "tries('a program', lambda: subprocess.run(['true'], timeout=5))",
            "tries('a shell', lambda: os.posix_spawn('/bin/true', ['true'], {}))",
            "os.execv('/bin/true', ['true'])",
        ),
        held_by=LAYERS,
        why=_CAN,
    ),
    Attack(
        "threads that spin",
        "answers honestly, beside threads that use all the time there is",
        """
def spin():
    while True: pass
def cheat(step):
    if once(step):
        for _ in range(4): threading.Thread(target=spin, daemon=True).start()
    return honest(step)
""",
        ITS_OWN,
        says="took longer|processor time",
        limits={"run": 1.5},
    ),
    Attack(
        "processor time beside honest answers",
        "uses more of it than it may, in a thread that holds no lock",
        """
import hashlib
data = bytes(1 << 24)
def spin():
    while True: hashlib.sha256(data).digest()
def cheat(step):
    if step.k == 0: threading.Thread(target=spin, daemon=True).start()
    while time.process_time() < 0.1 * step.k: time.sleep(0.01)
    return honest(step)
""",
        says="more than 1 s of processor time",
        limits={"cpu": 1.0},
    ),
    Attack(
        "threads that outlive",
        "answers honestly, and leaves threads that do not end",
        """
def cheat(step):
    if once(step): threading.Thread(target=time.sleep, args=(600,)).start()
    return honest(step)
""",
        ITS_OWN,
    ),
    Attack(
        "threads without end",
        "starts threads until it cannot",
        at_once(
            "while True: threading.Thread(target=time.sleep, args=(600,), daemon=True).start()"
        ),
    ),
    Attack(
        "holds the interpreter",
        "sleeps in a call that lets no other thread run",
        at_once("ctypes.PyDLL(None).sleep(600)"),
        says="took longer",
    ),
    Attack("loops", "never answers", at_once("while True: pass"), says="took longer"),
    Attack(
        "loads without end",
        "is never loaded",
        "time.sleep(600)",
        says="loading the submission took longer",
        limits={"first_call": 0.5},
    ),
    Attack(
        "atexit",
        "hangs, prints and forks when Python ends",
        """
import atexit
atexit.register(lambda: time.sleep(600))
atexit.register(lambda: reached("its own end"))
cheat = honest
""",
        ITS_OWN,
    ),
    Attack(
        "__del__",
        "hangs when its objects go away",
        """
class Stays:
    def __del__(self): time.sleep(600)
def cheat(step):
    if once(step): Stays()
""",
        says="took longer",
    ),
    Attack(
        "faulthandler",
        "lets a watchdog of Python's end the process with a report",
        at_once(
            "import faulthandler",
            "faulthandler.dump_traceback_later(0.05, exit=True, file=sys.__stderr__)",
            "time.sleep(600)",
        ),
    ),
    Attack("bytes", "asks for 4 GiB", at_once("x = bytes(1 << 32)"), says="MemoryError|memory"),
    Attack(
        "arrays",
        "fills arrays until there is no memory",
        at_once("x = []", "while True: x.append(np.ones(1 << 22))"),
        says="emory",
        limits={"memory": 1 << 28},
    ),
    Attack(
        "mappings",
        "maps memory until there is none",
        at_once("import mmap", "x = []", "while True: x.append(mmap.mmap(-1, 1 << 26))", "x[0][0]"),
        says="emory",
    ),
    Attack(
        "memfd",
        "fills files in memory, which count to no mapping",
        at_once(
            "x = []", "while True: x.append(os.memfd_create('x')); os.write(x[-1], bytes(1 << 20))"
        ),
        says="Error|took longer",
    ),
    Attack(
        "limits",
        "raises its own limits",
        at_once(
            "import resource",
            "for what in (resource.RLIMIT_AS, resource.RLIMIT_CPU, resource.RLIMIT_FSIZE):",
            "    tries('a limit', lambda: resource.setrlimit(what, (-1, -1)))",
        ),
    ),
    Attack(
        "output without end",
        "prints until it is ended",
        at_once("while True: print('x' * 65536)"),
        says="took longer",
    ),
    Attack(
        "warnings as output",
        "warns and logs, in colours",
        at_once(
            "import logging, warnings",
            "for i in range(2000): warnings.warn(f'\\x1b[2J{i}'); logging.error('\\x07%d', i)",
        ),
    ),
    Attack(
        "sockets",
        "opens sockets of all kinds",
        at_once(
            "for family in ('INET', 'INET6', 'UNIX', 'NETLINK', 'PACKET', 'VSOCK', 'ALG'):",
            "    for kind in ('STREAM', 'DGRAM', 'RAW', 'SEQPACKET'):",
            "        number = getattr(socket, f'AF_{family}')",
            "        tries(family, lambda: socket.socket(number, getattr(socket, f'SOCK_{kind}')))",
        ),
        held_by=LAYERS,
        why=_CAN,
    ),
    Attack(
        "a server on loopback",
        "connects to one of the grader's, and makes one of its own",
        at_once(
            "tries('a server', lambda: socket.create_server(('127.0.0.1', 0)))",
            "address = ('127.0.0.1', {port})",
            "tries('TCP', lambda: socket.create_connection(address, timeout=2))",
            "def send():",
            "    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:",
            "        s.sendto(b'x', address)",
            "tries('UDP', send)",
        ),
        held_by=LAYERS,
        why=_CAN,
    ),
    Attack(
        "abstract sockets",
        "takes the names by which graders say that a user is taken, and speaks to one",
        at_once(
            "def take(number):",
            "    s = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)",
            "    s.bind(f'\\0robsim-worker-{number}')",
            "for number in range(61100, 61105): tries('a name', lambda: take(number))",
        ),
        held_by=LAYERS,
        why=_CAN,
    ),
    Attack(
        "a socket pair that carries descriptors",
        "sends its wire to itself, and reads it from another thread",
        """
def cheat(step):
    if once(step):
        one, other = socket.socketpair()
        socket.send_fds(one, [b"x"], [wire().fileno()])
        _, (copy,), _, _ = socket.recv_fds(other, 1, 1)
        threading.Thread(target=os.read, args=(copy, 99), daemon=True).start()
    return honest(step)
""",
        ITS_OWN,
        says=".",
        limits=SHORT,
    ),
]
