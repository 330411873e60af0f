"""Attacks on the wire: messages that are none, not due, or say what cannot be."""

from red_team.attack import ITS_OWN, SHORT, Attack

# Where the numbers of an answer lie: see step_message.cpp. The pose, the covariance and the input
# are the last 14 numbers. The bodies are changed on their way.
_CHANGES = """
from robsim.grading import _robot_half
from robsim.grading._wire import Channel, Kind
exchange = Channel.exchange
answers = []
def changed(self, kind, *parts, **options):
    if kind == Kind.ANSWER:
        answers.append(bytes(parts[0]))
        if len(answers) == 3:
            parts = change(self, bytearray(parts[0])),
    return exchange(self, kind, *parts, **options)
Channel.exchange = changed
cheat = honest
"""


def answer(code: str) -> str:
    body = "\n".join(f"    {line}" for line in code.strip().splitlines())
    return f"{_CHANGES}\ndef change(channel, body):\n{body}\n    return bytes(body)\n"


def speech(*lines: str) -> str:
    body = "\n".join(f"        {line}" for line in lines)
    return f"\ndef cheat(step):\n    if once(step):\n        one = wire()\n{body}\n"


WIRE = [
    Attack(
        "garbage",
        "sends random bytes",
        speech("one.sendall(os.urandom(4096))"),
        says="estimate_state at step 2: the worker has sent",
    ),
    Attack(
        "a length of 2 GiB",
        "says that a message is longer than memory",
        speech("one.sendall(struct.pack('<HHI', 4, 0, 1 << 31))"),
        says="a message of 2147483648 bytes|not due",
    ),
    Attack(
        "one byte at a time",
        "keeps a message going for ever",
        speech(
            "one.sendall(struct.pack('<HHI', 4, 0, 9999))",
            "while True: one.sendall(b'x'); time.sleep(0.01)",
        ),
        says="took longer",
    ),
    Attack(
        "half a message",
        "ends in the middle of one",
        speech("one.sendall(struct.pack('<HHI', 4, 0, 9999) + b'x')", "os._exit(0)"),
        says="exit code 0",
    ),
    Attack(
        "a pickle",
        "sends what runs code where it is unpickled",
        speech(
            "import pickle",
            "class Runs:",
            "    def __reduce__(self): return os.system, ('touch {folder}/{token}',)",
            "data = pickle.dumps(Runs())",
            "one.sendall(struct.pack('<HHI', 4, 0, len(data)) + data)",
        ),
    ),
    Attack(
        "a message for the worker",
        "sends HELLO, STEP and END to the grader",
        speech("for kind in (1, 3, 5): one.sendall(struct.pack('<HHI', kind, 0, 0))"),
        says="of a kind that there is not|more than one",
    ),
    Attack(
        "READY once more",
        "says after the start that it fills other slots",
        speech("one.sendall(struct.pack('<HHI', 2, 0, 140) + bytes(140))"),
        says="not due|more than one|length",
    ),
    Attack(
        "an answer before it is asked",
        "sends the answer of the next step beside its own",
        answer("channel.send(Kind.ANSWER, bytes(body))"),
        says="more than one|must be that to this step",
    ),
    Attack(
        "an answer to another step",
        "answers a step that is over",
        answer("body[:8] = struct.pack('<q', 0)"),
        says="must be that to this step",
    ),
    Attack(
        "an answer without an estimate",
        "says that nothing is done",
        answer("body[32:36] = struct.pack('<I', 0)"),
        says="there must be an",
    ),
    Attack(
        "stages that are not its own",
        "says what the controller gave, too",
        answer(
            "parts, = struct.unpack('<I', body[36:40])\n"
            "body[32:40] = struct.pack('<II', 15, parts | 512)"
        ),
        ITS_OWN,
    ),
    Attack(
        "NaN on the wire",
        "estimates NaN behind the back of its own half",
        answer("body[-112:-104] = struct.pack('<d', float('nan'))"),
        says="finite",
    ),
    Attack(
        "infinity on the wire",
        "estimates a heading that is none",
        answer("body[-96:-88] = struct.pack('<d', float('inf'))"),
        says="finite",
    ),
    Attack(
        "a covariance that is none",
        "sends one that is not symmetric",
        answer("body[-80:-72] = struct.pack('<d', 5.0)"),
        says="symmetric",
    ),
    Attack(
        "a negative variance",
        "sends one that is below 0",
        answer("body[-88:-80] = struct.pack('<d', -5.0)"),
        says="covariance|variance",
    ),
    Attack(
        "an input of its own",
        "sends an input, which is not its to give",
        answer("body[-16:] = struct.pack('<dd', 1e9, 1e9)"),
        ITS_OWN,
    ),
    Attack(
        "4 billion states",
        "says that there are more numbers than follow",
        answer("body[48:52] = struct.pack('<I', 2**32 - 1)"),
        says="at most 1024",
    ),
    Attack(
        "memory that is not there",
        "chooses memory for the next frame beyond all",
        answer("body[52:56] = struct.pack('<I', 2**31)"),
        says="memory of the next frame",
    ),
    Attack(
        "the frame before once more",
        "lets the next frame be drawn over the one that it looks at",
        answer("body[52:56] = struct.pack('<I', 0)"),
        ITS_OWN,
    ),
    Attack(
        "READY with other slots",
        "says at the start that it fills the controller, too",
        """
from robsim.grading._wire import Ready
plain = Ready.to_bytes
def to_bytes(self, slots):
    body = bytearray(plain(self, slots))
    body[:4] = struct.pack("<I", (1 << len(slots)) - 1)
    return bytes(body)
Ready.to_bytes = to_bytes
cheat = honest
""",
        says="must not fill this slot",
    ),
    Attack(
        "READY with another model",
        "changes the model that all believe in, which is not its slot",
        """
import dataclasses
from robsim.grading._wire import Ready
plain = Ready.to_bytes
def to_bytes(self, slots):
    model = robsim.RobotModel(robsim.RobotParameters(mass=0.5))
    return plain(dataclasses.replace(self, model=model), slots)
Ready.to_bytes = to_bytes
cheat = honest
""",
        says="must not change the model",
    ),
    Attack(
        "READY with numbers that are none",
        "sends a model of NaN, and slots that there are not",
        """
from robsim.grading._wire import Ready
plain = Ready.to_bytes
def to_bytes(self, slots):
    body = bytearray(plain(self, slots))
    body[-8:] = struct.pack("<d", float("nan"))
    return bytes(body)
Ready.to_bytes = to_bytes
cheat = honest
""",
    ),
    Attack(
        "an error of its own",
        "says that the teacher's file is broken, in another step, slot and colour",
        speech(
            "import json",
            "told = {'type': 'AssignmentError', 'message': '\\x1b[31mthe key is broken\\x00',",
            "        'slot': 'evaluate_model', 'step': -5, 'file': '{secret}', 'line': 10**99}",
            "data = json.dumps(told).encode()",
            "one.sendall(struct.pack('<HHI', 6, 0, len(data)) + data)",
            "time.sleep(9)",
        ),
    ),
    Attack(
        "an error that is none",
        "sends JSON of 5000 brackets as an error",
        speech(
            "data = b'[' * 5000 + b']' * 5000",
            "one.sendall(struct.pack('<HHI', 6, 0, len(data)) + data)",
            "time.sleep(9)",
        ),
        says="an error that is none",
    ),
    Attack(
        "closes its wire",
        "shuts its side, and goes on",
        speech("one.shutdown(socket.SHUT_RDWR)", "time.sleep(600)"),
        says="closed its connection|ended",
    ),
    Attack(
        "reads its own questions",
        "has a thread that takes the grader's messages away",
        """
def steal():
    one = wire()
    while True: os.read(one.fileno(), 4096)
def cheat(step):
    if once(step): threading.Thread(target=steal, daemon=True).start()
    return honest(step)
""",
        ITS_OWN,
        says=".",
        limits=SHORT | {"run": 1.0},
    ),
]
