"""Attacks on the wire: messages that are none, not due, or say what cannot be."""

import textwrap

from red_team.attack import ITS_OWN, SHORT, attack, in_step_2, kind

# Where the numbers of an answer lie: see step_message.cpp. The pose, the covariance and the input
# are the last 14 numbers. The bodies are changed on their way.
_CHANGES = """
from robsim.teach.grading import robot_half as _robot_half
from robsim.teach.grading._wire import Channel, Kind
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


_READY = """
from robsim.teach.grading._wire import Ready
plain = Ready.to_bytes
def to_bytes(self, slots):
    body = bytearray(plain(self, slots))
{}
    return bytes(body)
Ready.to_bytes = to_bytes
cheat = honest
"""


def _answer(lines: str) -> str:
    body = textwrap.indent(lines, "    ")
    return f"{_CHANGES}\ndef change(channel, body):\n{body}\n    return bytes(body)"


answer = kind(_answer)
ready = kind(lambda lines: _READY.format(textwrap.indent(lines, "    ")))
speech = kind(lambda lines: in_step_2(f"one = wire()\n{lines}"))

WIRE = [
    speech("garbage", "sends random bytes", says="estimate_state at step 2: the worker has sent")(
        "one.sendall(os.urandom(4096))"
    ),
    speech(
        "a length of 2 GiB",
        "says that a message is longer than memory",
        says="a message of 2147483648 bytes|unexpected",
    )("one.sendall(struct.pack('<HHI', 4, 0, 1 << 31))"),
    speech("one byte at a time", "keeps a message going for ever", says="took longer")("""
one.sendall(struct.pack('<HHI', 4, 0, 9999))
while True: one.sendall(b'x'); time.sleep(0.01)
"""),
    speech("half a message", "ends in the middle of one", says="exit code 0")("""
one.sendall(struct.pack('<HHI', 4, 0, 9999) + b'x')
os._exit(0)
"""),
    speech("a pickle", "sends what runs code where it is unpickled")("""
import pickle
class Runs:
    def __reduce__(self): return os.system, ('touch {folder}/{token}',)
data = pickle.dumps(Runs())
one.sendall(struct.pack('<HHI', 4, 0, len(data)) + data)
"""),
    speech(
        "a message for the worker",
        "sends HELLO, STEP and END to the grader",
        says="unknown message|unknown kind|more than one",
    )("for kind in (1, 3, 5): one.sendall(struct.pack('<HHI', kind, 0, 0))"),
    speech(
        "READY once more",
        "says after the start that it fills other slots",
        says="unexpected|more than one|length",
    )("one.sendall(struct.pack('<HHI', 2, 0, 140) + bytes(140))"),
    answer(
        "an answer before it is asked",
        "sends the answer of the next step beside its own",
        says="more than one|must be that to this step",
    )("channel.send(Kind.ANSWER, bytes(body))"),
    answer(
        "an answer to another step", "answers a step that is over", says="must be that to this step"
    )("body[:8] = struct.pack('<q', 0)"),
    answer("an answer without an estimate", "says that nothing is done", says="there must be an")(
        "body[32:36] = struct.pack('<I', 0)"
    ),
    answer("stages that are not its own", "says what the controller gave, too", ITS_OWN)("""
parts, = struct.unpack('<I', body[36:40])
body[32:40] = struct.pack('<II', 15, parts | 512)
"""),
    answer("NaN on the wire", "estimates NaN behind the back of its own half", says="finite")(
        "body[-112:-104] = struct.pack('<d', float('nan'))"
    ),
    answer("infinity on the wire", "estimates a heading that is none", says="finite")(
        "body[-96:-88] = struct.pack('<d', float('inf'))"
    ),
    answer("a covariance that is none", "sends one that is not symmetric", says="symmetric")(
        "body[-80:-72] = struct.pack('<d', 5.0)"
    ),
    answer("a negative variance", "sends one that is below 0", says="covariance|variance")(
        "body[-88:-80] = struct.pack('<d', -5.0)"
    ),
    answer("an input of its own", "sends an input, which is not its to give", ITS_OWN)(
        "body[-16:] = struct.pack('<dd', 1e9, 1e9)"
    ),
    answer("4 billion states", "says that there are more numbers than follow", says="at most 1024")(
        "body[48:52] = struct.pack('<I', 2**32 - 1)"
    ),
    answer(
        "memory that is not there",
        "chooses memory for the next frame beyond all",
        says="memory of the next frame",
    )("body[52:56] = struct.pack('<I', 2**31)"),
    answer(
        "the frame before once more",
        "lets the next frame be drawn over the one that it looks at",
        ITS_OWN,
    )("body[52:56] = struct.pack('<I', 0)"),
    ready(
        "READY with other slots",
        "says at the start that it fills the controller, too",
        says="must not fill this slot",
    )('body[:4] = struct.pack("<I", (1 << len(slots)) - 1)'),
    ready(
        "READY with another model",
        "changes the model that all believe in, which is not its slot",
        says="must not change the model",
    )("""
import dataclasses
model = robsim.RobotModel(robsim.RobotParameters(mass=0.5))
body = plain(dataclasses.replace(self, model=model), slots)
"""),
    ready("READY with numbers that are none", "sends a model of NaN, and slots that there are not")(
        'body[-8:] = struct.pack("<d", float("nan"))'
    ),
    speech(
        "an error of its own",
        "says that the teacher's file is broken, in another step, slot and colour",
    )("""
import json
told = {'type': 'AssignmentError', 'message': '\\x1b[31mthe key is broken\\x00',
        'slot': 'evaluate_model', 'step': -5, 'file': '{secret}', 'line': 10**99}
data = json.dumps(told).encode()
one.sendall(struct.pack('<HHI', 6, 0, len(data)) + data)
time.sleep(9)
"""),
    speech(
        "an error that is none",
        "sends JSON of 5000 brackets as an error",
        says="malformed error",
    )("""
data = b'[' * 5000 + b']' * 5000
one.sendall(struct.pack('<HHI', 6, 0, len(data)) + data)
time.sleep(9)
"""),
    speech("closes its wire", "shuts its side, and continues", says="connection|ended|exited")("""
one.shutdown(socket.SHUT_RDWR)
time.sleep(600)
"""),
    attack(
        "reads its own questions",
        "has a thread that takes the grader's messages away",
        ITS_OWN,
        limits=SHORT | {"run": 1.0},
    )("""
def steal():
    one = wire()
    while True: os.read(one.fileno(), 4096)
def cheat(step):
    if once(step): threading.Thread(target=steal, daemon=True).start()
    return honest(step)
"""),
]
