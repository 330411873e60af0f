"""Attacks by what a function returns that is called with arrays, and by what it says beside."""

from red_team.attack import ITS_OWN, Attack

# The bodies of results are changed on their way: a number of arrays; kind, axes and shape of each;
# their bytes.
_CHANGES = """
from robsim.grading._wire import Channel, Kind
send = Channel.send
def changed(self, kind, *parts, **options):
    if kind == Kind.RESULT:
        parts = change(self, bytearray(b"".join(bytes(part) for part in parts))),
    send(self, kind, *parts, **options)
Channel.send = changed
fit = honest_fit
"""


def result(*lines: str) -> str:
    body = "\n".join(f"    {line}" for line in lines)
    return f"{_CHANGES}\ndef change(channel, body):\n{body}\n    return bytes(body)\n"


def returns(*lines: str) -> str:
    body = "\n".join(f"    {line}" for line in lines)
    return f"def fit(phi, y):\n    theta = honest_fit(phi, y)\n{body}\n"


CALLS = [
    Attack("honest function", "fits as it should", "fit = honest_fit", ITS_OWN),
    Attack(
        "objects for numbers",
        "returns objects that say that they are equal to all",
        returns(
            "class Equal:",
            "    def __eq__(self, other): return True",
            "    def __sub__(self, other): return 0.0",
            "return np.array([Equal()] * 3, object)",
        ),
        says="must be an array of real numbers, got one of object",
    ),
    Attack(
        "texts and complex numbers",
        "returns what compares in some other way",
        returns("return theta.astype(complex) if y[0] > 0 else theta.astype(str)"),
        says="must be an array of real numbers, got one of (complex128|<U32)",
    ),
    Attack(
        "a class that says what it is",
        "returns an array with methods of its own",
        returns(
            "class Equal(np.ndarray):",
            "    def __eq__(self, other): reached('a comparison')",
            "    def __array_ufunc__(self, *a, **k): return self",
            "    def __array_function__(self, *a, **k): return True",
            "return np.zeros(3).view(Equal)",
        ),
    ),
    Attack(
        "an array that ends Python",
        "raises SystemExit when it is asked for its numbers",
        returns(
            "class Ends:",
            "    def __array__(self, *a, **k): raise SystemExit(0)",
            "return Ends()",
        ),
        says="SystemExit",
    ),
    Attack(
        "a huge result",
        "returns 200 MiB",
        returns("return np.zeros((5000, 5000))"),
        says="may have 64 MiB in all, got 190 MiB",
    ),
    Attack(
        "a result of another shape",
        "returns the numbers three times over",
        returns("return np.stack([theta] * 3)"),
        says=r"must be an array of shape \(3,\), got \(3, 3\)",
    ),
    Attack("NaN for numbers", "returns NaN", returns("return theta * np.nan"), says="all finite"),
    Attack(
        "NaN behind its back",
        "changes the numbers on the wire",
        result("body[-8:] = struct.pack('<d', float('nan'))"),
        says="all finite",
    ),
    Attack(
        "a shape that is not there",
        "says on the wire that there are 2**62 numbers",
        result("body[6:14] = struct.pack('<Q', 2**62)"),
        says="longer than its message",
    ),
    Attack(
        "four billion arrays",
        "says on the wire that there are as many",
        result("body[:4] = struct.pack('<I', 2**32 - 1)"),
        says="heads are not there",
    ),
    Attack(
        "a kind that there is not",
        "says on the wire that there are objects",
        result("body[4] = 9"),
        says="of a kind that there is not",
    ),
    Attack(
        "no numbers of an endless shape",
        "says on the wire that one axis is 0 and another one endless",
        result("body[4:30] = struct.pack('<BBQQQ', 0, 3, 0, 2**60, 2**60)", "del body[30:]"),
        says="of a shape that cannot be|of shape",
    ),
    Attack(
        "a pickle for a result",
        "sends what runs code where it is unpickled",
        "import pickle\nclass Runs:\n    def __reduce__(self):\n"
        "        return os.system, ('touch {folder}/{token}',)\n"
        + result("body = pickle.dumps(Runs())"),
        says="the worker has sent",
    ),
    Attack(
        "results before they are asked",
        "sends the results of all calls at once",
        result("send(channel, Kind.RESULT, bytes(body))"),
        says="more than one|RESULT|closed|not due|ended by itself|finite",
    ),
    Attack(
        "a late result",
        "answers a call after its time, while the next one runs",
        returns("if phi[0, 0] > 0: time.sleep(9)", "return theta"),
        says="fit took longer than 0.4 s",
    ),
    Attack(
        "a result by a thread",
        "has a thread that sends results of its own",
        "spoken = threading.Event()\ndef speak():\n    one = wire()\n    while True:\n"
        "        one.sendall(struct.pack('<HHIIBB3Qddd', 8, 0, 54, 1, 0, 1, 3, 0, 0, 9, 9, 9))\n"
        "        spoken.set()\n"
        + returns(
            "threading.Thread(target=speak, daemon=True).start()", "spoken.wait()", "return theta"
        ),
        says="more than one|must be|shape|longer|fill|heads",
    ),
    Attack(
        "an answer to a step",
        "sends ANSWER and READY where a result is due",
        returns("one = wire()", "one.sendall(struct.pack('<HHI', 4, 0, 0))", "return theta"),
        says="not due|more than one",
    ),
    Attack(
        "what is true",
        "looks for what the grader compares with",
        returns(
            "for value in gc.get_objects():",
            "    if type(value).__name__ in ('Submission', 'Task', 'Scenario', 'Key', 'Wanted'):",
            "        reached(type(value).__name__)",
            "return theta",
        ),
        ITS_OWN,
    ),
]

#: Before the code of each: what an honest one returns.
HONEST_FIT = """
def honest_fit(phi, y):
    return np.linalg.lstsq(phi, y, rcond=None)[0]

"""
