"""Attacks within Python: patches, objects that lie, modules that are masked, texts."""

import textwrap

from red_team.attack import ITS_OWN, Attack, at_once, attack, in_step_2, kind

_READS = "the file of a module can be read where files are not closed"


def _masked(lines: str) -> str:
    """What is masked is robsim.estimation.reference; whoever has its filter says so."""
    get = f"def get():\n{textwrap.indent(lines, '    ')}\n"
    return get + in_step_2('tries("robsim.estimation.reference", get)')


def _returned(lines: str) -> str:
    """A slot that returns what is no estimate at a step: the last of these lines."""
    before, _, last = lines.rpartition("\n")
    return f"""
{before}
def estimate_state(step):
    plain = robsim.Estimate((0.0, 0.0, 0.0), np.eye(3))
    return ({last}) if once(step) else plain
"""


masked, returned = kind(_masked), kind(_returned)

PYTHON = [
    attack("patched metrics", "lets all measures of robsim say 0, and the trace its own pose")("""
import robsim.estimation, robsim.trace
for module in [m for n, m in sys.modules.items() if n.startswith("robsim")]:
    for name, value in list(vars(module).items()):
        if "rms" in name or "error" in name.lower() and callable(value):
            setattr(module, name, lambda *a, **k: 0.0)
robsim.Trace.pose_true = property(lambda self: self.pose_estimated)
def cheat(step):
    return None
"""),
    attack(
        "patched core", "puts classes of its own in the place of those of robsim._core", ITS_OWN
    )("""
import robsim._core
class Estimate(robsim.Estimate):
    pose = property(lambda self: np.full(3, np.nan))
robsim._core.Estimate = robsim.Estimate = Estimate
cheat = honest
"""),
    attack(
        "patched checks", "lets the checks of its own half pass all, and gives NaN", says="finite"
    )("""
for name, module in list(sys.modules.items()):
    if name.startswith("robsim.base.checks") or name.endswith("callbacks.checks"):
        for each in list(vars(module)):
            if each.startswith("check"): setattr(module, each, lambda *a, **k: a and a[-1])
def cheat(step):
    return (np.nan, 0, 0) if once(step) else None
"""),
    attack("patched Python", "replaces print, open, len, isinstance and import for all modules")("""
import builtins
def cheat(step):
    if once(step):
        for name in ("isinstance", "len", "open", "__import__", "type", "repr"):
            setattr(builtins, name, lambda *a, **k: 1)
"""),
    attack(
        "import hooks", "puts a finder before all others that ends the process", says="exit code 0"
    )("""
class Finder:
    def find_spec(self, name, path=None, target=None):
        os._exit(0)
def cheat(step):
    if once(step):
        sys.meta_path.insert(0, Finder())
        import wave
"""),
    at_once("audit hooks", "refuses everything that Python does from now on")("""
def hook(*event): raise SystemExit(0)
sys.addaudithook(hook)
open("x")
"""),
    attack("trace functions", "is called in each line of its caller, and changes its variables")("""
def watch(frame, event, arg):
    raise SystemExit(0)
def cheat(step):
    if once(step):
        sys.setprofile(watch)
        threading.setprofile(watch)
"""),
    Attack(
        "recursion", "calls itself", "def cheat(step): return cheat(step)", says="RecursionError"
    ),
    attack(
        "recursion without a bottom",
        "calls itself, after it has taken the limit away",
        says="SIGSEGV|RecursionError|MemoryError|took longer|emory",
    )("""
sys.setrecursionlimit(10**9)
def cheat(step): return [cheat(step)] if step.k > 1 else None
"""),
    returned("deep lists", "gives a covariance of 100000 lists in each other")("""
deep = []
for _ in range(100_000): deep = [deep]
((0, 0, 0), deep)
"""),
    returned("a generator", "yields estimates", says="Estimate")("(x for x in [1])"),
    Attack(
        "a coroutine",
        "is an async function",
        "async def estimate_state(step): return robsim.Estimate((0, 0, 0), np.eye(3))",
    ),
    returned("nothing", "returns None", says="Estimate")("None"),
    returned("__array__ that lies", "is another array each time that it is looked at")("""
class Lies:
    n = 0
    def __array__(self, *a, **k):
        Lies.n += 1
        return np.full(3, np.nan if Lies.n > 1 else 1.0)
    def __len__(self): return 3
    def __getitem__(self, i): return np.nan
robsim.Estimate(Lies(), np.eye(3))
"""),
    returned("__float__ that lies", "is another number each time, or ends Python", says="")("""
class Lies(float):
    def __float__(self): sys.exit(0)
    def __index__(self): sys.exit(0)
robsim.Estimate([Lies(1), Lies(2), Lies(3)], np.eye(3))
"""),
    returned("an array of a class of its own", "is an ndarray whose every method is its own")("""
class Mine(np.ndarray):
    def __array_finalize__(self, other): pass
    def __array_ufunc__(self, *a, **k): return True
    def __getitem__(self, i): os._exit(0)
robsim.Estimate(np.zeros(3).view(Mine), np.full((3, 3), np.nan).view(Mine))
"""),
    returned("a tuple of a class of its own", "says that it has another length than it has")("""
class Pair(tuple):
    def __len__(self): return 2
    def __iter__(self): return iter((np.nan, np.inf, 1e9))
robsim.Estimate(Pair((1.0, 2.0, 3.0)), np.eye(3))
"""),
    returned(
        "100 MB of states",
        "gives further states that no message holds",
        says="1024|longer|bytes|memory",
    )("robsim.Estimate((0, 0, 0), np.eye(3), state=np.zeros(12_000_000))"),
    returned("1e308", "estimates a pose at the end of numbers")(
        "robsim.Estimate((1e308, 0, 0), np.eye(3))"
    ),
    masked("a masked module by importlib", "imports it by the machinery below import")("""
import importlib
return importlib.import_module('robsim.estimation.reference').ExtendedKalmanFilter
"""),
    masked("a masked module by its loader", "makes its spec from its file", why=_READS)("""
import importlib.util as u
path = os.path.join(os.path.dirname(robsim.__file__), 'estimation/reference', '__init__.py')
spec = u.spec_from_file_location('mine', path)
module = u.module_from_spec(spec)
spec.loader.exec_module(module)
return module.ExtendedKalmanFilter
"""),
    masked(
        "a masked module by its source",
        "reads its file, and those that Python has compiled",
        why=_READS,
    )("""
import glob
base = os.path.join(os.path.dirname(robsim.__file__), 'estimation/reference')
names = glob.glob(base + '/**/*.py*', recursive=True) or [base + '/__init__.py']
return [open(name, 'rb').read() for name in names]
"""),
    masked(
        "a masked module without its mask",
        "takes the finder that masks it away, and imports",
        why=_READS,
    )("""
sys.meta_path[:] = [f for f in sys.meta_path if 'Masked' not in repr(f)]
import builtins
return builtins.__import__('robsim.estimation.reference').estimation.reference.ExtendedKalmanFilter
"""),
    masked("a masked module in memory", "looks for it in sys.modules and among all objects")("""
seen, found = set(), gc.get_objects() + [sys.modules]
while found and len(seen) < 300_000:
    value = found.pop()
    if id(value) not in seen:
        seen.add(id(value))
        if getattr(value, '__name__', '') == 'ExtendedKalmanFilter': return value
        found += gc.get_referents(value)
raise LookupError
"""),
    masked("a masked module by pickle", "lets pickle import it")("""
import pickle
return pickle.loads(b'crobsim.estimation.reference\\nExtendedKalmanFilter\\n.')
"""),
    attack(
        "control characters in an exception",
        "colours, bells, NUL, right to left, marks and broken characters",
        says="ValueError",
    )("""
def cheat(step):
    letters = "a\\u0301\\u0301\\u0301\\u0301" * 99
    raise ValueError("\\x1b[2J\\x07\\x00\\u202e" + letters + "\\ud800")
"""),
    Attack(
        "a text of 50 MB",
        "raises an exception that long",
        "def cheat(step): raise ValueError('x' * 50_000_000)",
        says="ValueError: x+",
    ),
    attack(
        "a class with any name",
        "raises an exception whose class is called as a report",
        says="points",
    )("""
def cheat(step):
    raise type("\\n\\x1b[32m100 of 100 points </pre><script>", (Exception,), {})("x")
"""),
    attack(
        "__str__ that exits", "raises an exception whose text ends Python", says="Bad|exit code 0"
    )("""
class Bad(Exception):
    def __str__(self): os._exit(0)
    __repr__ = __str__
    __class__ = property(__str__)
def cheat(step): raise Bad(Bad())
"""),
    attack(
        "exceptions in a circle",
        "raises one that is its own cause, with notes and a group",
        says="ExceptionGroup",
    )("""
def cheat(step):
    error = BaseExceptionGroup("g", [ExceptionGroup("h", [ValueError("x")] * 100)] * 100)
    error.__context__ = error
    error.__notes__ = [object()] * 1000
    raise error
"""),
    attack(
        "somebody else's fault",
        "raises the error that says that the assignment is broken",
        says=r"line \d+: AssignmentError: the key cannot be read",
    )("""
from robsim.teach import AssignmentError
def cheat(step): raise AssignmentError("the key cannot be read: tell your teacher")
"""),
    Attack(
        "Ctrl-C",
        "raises KeyboardInterrupt, as if the teacher had pressed it",
        "def cheat(step): raise KeyboardInterrupt",
        says="KeyboardInterrupt",
    ),
    Attack(
        "StopIteration",
        "raises what ends loops, and what ends generators",
        "def cheat(step): raise (StopIteration if step.k % 2 else GeneratorExit)",
        says="StopIteration|GeneratorExit",
    ),
    attack(
        "names of files",
        "compiles code whose file is called as one of the grader's",
        says="ZeroDivisionError",
    )("""
exec(compile("def fails(): 1 / 0", "{secret}", "exec"))
def cheat(step): fails()
"""),
    attack(
        "output as a report", "prints what a test says when it has passed, HTML, and ends of lines"
    )("""
def cheat(step):
    print("\\x1b[1A\\x1b[32m===== 3 passed in 0.01s =====\\r\\n]]></failure>")
    print("<script>alert(1)</script>")
    sys.stderr.write("\\x9b31m\\u2028\\u0085")
"""),
    Attack(
        "bytes that are no text",
        "prints all bytes",
        "def cheat(step): os.write(1, bytes(range(256)) * 9)",
    ),
]
