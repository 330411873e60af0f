"""Attacks by what a function returns that is called with arrays, and by what it says beside."""

import textwrap

from red_team.attack import ITS_OWN, Attack, kind

# The bodies of results are changed on their way: a number of arrays; kind, axes and shape of each;
# their bytes.
_CHANGES = """
from robsim.teach.grading._wire import Channel, Kind
send = Channel.send
def changed(self, kind, *parts, **options):
    if kind == Kind.RESULT:
        parts = change(self, bytearray(b"".join(bytes(part) for part in parts))),
    send(self, kind, *parts, **options)
Channel.send = changed
fit = honest_fit
"""


def _result(lines: str) -> str:
    body = textwrap.indent(lines, "    ")
    return f"{_CHANGES}\ndef change(channel, body):\n{body}\n    return bytes(body)"


def _returns(lines: str) -> str:
    return f"def fit(phi, y):\n    theta = honest_fit(phi, y)\n{textwrap.indent(lines, '    ')}"


result, returns = kind(_result), kind(_returns)

CALLS = [
    Attack("honest function", "fits as it should", "fit = honest_fit", ITS_OWN),
    returns(
        "objects for numbers",
        "returns objects that say that they are equal to all",
        says="must be an array of real numbers, got one of object",
    )("""
class Equal:
    def __eq__(self, other): return True
    def __sub__(self, other): return 0.0
return np.array([Equal()] * 3, object)
"""),
    returns(
        "texts and complex numbers",
        "returns what compares in some other way",
        says="must be an array of real numbers, got one of (complex128|<U32)",
    )("return theta.astype(complex) if y[0] > 0 else theta.astype(str)"),
    returns("a class that says what it is", "returns an array with methods of its own")("""
class Equal(np.ndarray):
    def __eq__(self, other): reached('a comparison')
    def __array_ufunc__(self, *a, **k): return self
    def __array_function__(self, *a, **k): return True
return np.zeros(3).view(Equal)
"""),
    returns(
        "an array that ends Python",
        "raises SystemExit when it is asked for its numbers",
        says="SystemExit",
    )("""
class Ends:
    def __array__(self, *a, **k): raise SystemExit(0)
return Ends()
"""),
    returns("a huge result", "returns 200 MiB", says="at most 64 MiB in all, got 190 MiB")(
        "return np.zeros((5000, 5000))"
    ),
    returns(
        "a result of another shape",
        "returns the numbers three times over",
        says=r"must be an array of shape \(3,\), got \(3, 3\)",
    )("return np.stack([theta] * 3)"),
    returns("NaN for numbers", "returns NaN", says="all finite")("return theta * np.nan"),
    result("NaN behind its back", "changes the numbers on the wire", says="all finite")(
        "body[-8:] = struct.pack('<d', float('nan'))"
    ),
    result(
        "a shape that is not there",
        "says on the wire that there are 2**62 numbers",
        says="longer than its message",
    )("body[6:14] = struct.pack('<Q', 2**62)"),
    result("four billion arrays", "says on the wire that there are as many", says="missing heads")(
        "body[:4] = struct.pack('<I', 2**32 - 1)"
    ),
    result(
        "a kind that there is not",
        "says on the wire that there are objects",
        says="unknown type",
    )("body[4] = 9"),
    result(
        "no numbers of an endless shape",
        "says on the wire that one axis is 0 and another one endless",
        says="invalid shape|of shape",
    )("""
body[4:30] = struct.pack('<BBQQQ', 0, 3, 0, 2**60, 2**60)
del body[30:]
"""),
    result(
        "a pickle for a result",
        "sends what runs code where it is unpickled",
        says="the worker has sent",
    )("""
import pickle
class Runs:
    def __reduce__(self): return os.system, ('touch {folder}/{token}',)
body = pickle.dumps(Runs())
"""),
    result(
        "results before they are asked",
        "sends the results of all calls at once",
        says="more than one|RESULT|closed|unexpected|exited|finite",
    )("send(channel, Kind.RESULT, bytes(body))"),
    returns(
        "a late result",
        "answers a call after its time, while the next one runs",
        says="fit took longer than 0.4 s",
    )("""
if phi[0, 0] > 0: time.sleep(9)
return theta
"""),
    returns(
        "a result by a thread",
        "has a thread that sends results of its own",
        says="more than one|must be|shape|longer|fill|heads",
    )("""
spoken = threading.Event()
def speak():
    one = wire()
    while True:
        one.sendall(struct.pack('<HHIIBB3Qddd', 8, 0, 54, 1, 0, 1, 3, 0, 0, 9, 9, 9))
        spoken.set()
threading.Thread(target=speak, daemon=True).start()
spoken.wait()
return theta
"""),
    returns(
        "an answer to a step",
        "sends ANSWER and READY where a result is due",
        says="unexpected|more than one",
    )("""
one = wire()
one.sendall(struct.pack('<HHI', 4, 0, 0))
return theta
"""),
    returns("what is true", "looks for what the grader compares with", ITS_OWN)("""
for value in gc.get_objects():
    if type(value).__name__ in ('Submission', 'Task', 'Scenario', 'Key', 'Wanted'):
        reached(type(value).__name__)
return theta
"""),
]

#: Before the code of each: what an honest one returns.
HONEST_FIT = """
def honest_fit(phi, y):
    return np.linalg.lstsq(phi, y, rcond=None)[0]

"""
