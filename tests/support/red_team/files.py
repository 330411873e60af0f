"""Attacks on files: those of the grader and of others, what is left behind, what fills a disk."""

from red_team.attack import ITS_OWN, SHORT, at_once, attack

_SAME_USER = "the process alone has the rights of the grader's user"

FILES = [
    at_once(
        "the teacher's files",
        "reads and changes a file of the grader's: a key, a test, marks",
        why=_SAME_USER,
    )("""
tries("a file of the grader's", lambda: open("{secret}").read())
tries("writing it", lambda: open("{secret}", "a").close())
tries("listing its folder", lambda: os.listdir("{folder}"))
"""),
    at_once(
        "links to the teacher's files",
        "makes a link to them in its own folder, and reads that",
        why=_SAME_USER,
    )("""
for make in (os.symlink, os.link):
    def act():
        make("{secret}", f"mine-{make.__name__}")
        return open(f"mine-{make.__name__}").read()
    tries(make.__name__, act)
"""),
    at_once(
        "files outside its folder",
        "leaves files in /tmp, /dev/shm, home, the folder of a submission",
        why=_SAME_USER,
    )("""
for folder in ("/tmp", "/dev/shm", "/var/tmp", "..", "{folder}", "/root"):
    path = os.path.join(folder, "{token}")
    tries(folder, lambda: open(path, "w").close())
"""),
    attack(
        "a second run",
        "leaves code that Python loads by itself, and looks for it when it is run again",
        why=_SAME_USER,
        runs_bare=False,
    )("""
import site
PLACES = (".", "..", os.path.dirname(robsim.__file__), *site.getsitepackages(), "{folder}")
NAMES = ("conftest.py", "sitecustomize.py", "usercustomize.py", "{token}.pth", "__pycache__/x.pyc")
def cheat(step):
    if once(step):
        if any(os.path.exists(os.path.join(f, "{token}")) for f in PLACES):
            reached("what an earlier run has left")
        for folder in PLACES[1:-1]:
            tries(folder, lambda: open(os.path.join(folder, "{token}"), "w").close())
        for name in NAMES:
            try:
                os.makedirs(os.path.dirname(name) or ".", exist_ok=True)
                open(name, "w").write("raise SystemExit(0)")
            except OSError:
                pass
        open("{token}", "w").close()
"""),
    attack(
        "results of its own",
        "writes results.json and a report, and ends with exit code 0",
        says=r"exited \(exit code 0\)",
    )("""
def cheat(step):
    if step.k == 5:
        for name in ("results.json", "report.xml", "marks.csv"):
            open(name, "w").write('{"score": 100}')
        print('{"score": 100, "status": "passed"}')
        print("robsim: 100 of 100 points")
        os._exit(0)
"""),
    at_once("a pipe that nobody writes to", "makes a FIFO and opens it", limits=SHORT)("""
os.mkfifo("fifo")
open("fifo").read()
"""),
    attack(
        "folders without end",
        "makes folders in folders, deeper than any path is long, with files at the end",
        ITS_OWN,
        says="wrote more than|closed its connection",
    )("""
for i in range(1100):
    os.mkdir("d")
    os.chdir("d")
for i in range(20):
    open(f"f{i}", "w").write("x" * 9999)
cheat = honest
"""),
    attack(
        "closed folders",
        "makes folders that nobody may look into, its own grader neither",
        ITS_OWN,
        says="wrote more than",
    )("""
for i in range(50):
    os.mkdir(f"d{i}", 0o300 if i % 2 else 0)
    if i % 2:
        open(f"d{i}/f", "w").write("x" * 9999)
cheat = honest
"""),
    at_once(
        "many files",
        "makes as many files as it can",
        says="wrote more than",
        limits={"folder_size": 4 << 20},
    )("""
for i in range(10**6):
    open(f"f{i}", "w").close()
"""),
    at_once("a large file", "writes, cuts and reserves more than it may")("""
with open("large", "wb") as file:
    tries("ftruncate", lambda: os.ftruncate(file.fileno(), 1 << 40))
    tries("fallocate", lambda: os.posix_fallocate(file.fileno(), 0, 1 << 30))
    file.write(b"x" * (8 << 20))
"""),
    attack(
        "open files", "opens as many as it can, removed at once", says="Too many open files|OSError"
    )("""
def cheat(step):
    files = []
    if once(step):
        while True:
            files.append(open(f"f{len(files)}", "w"))
            os.remove(files[-1].name)
"""),
    at_once(
        "closes its frames", "closes all descriptors that it has, and opens others in their place"
    )("""
os.closerange(3, 256)
for i in range(20):
    os.open("/dev/null", os.O_RDWR)
"""),
    at_once(
        "SysV and POSIX memory",
        "makes memory that outlives its process",
        why=_SAME_USER,
        runs_bare=False,
    )("""
tries("shmget", lambda: called(libc.shmget(0x7ED7EA, 4096, 0o1666)))
tries("semget", lambda: called(libc.semget(0x7ED7EA, 1, 0o1666)))
tries("msgget", lambda: called(libc.msgget(0x7ED7EA, 0o1666)))
tries("mq_open", lambda: called(libc.mq_open(b"/{token}", 0o102, 0o600, None)))
from multiprocessing import shared_memory
tries("shm_open", lambda: shared_memory.SharedMemory("{token}", True, 4096))
"""),
]
