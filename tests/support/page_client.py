"""A browser's side of the page, by hand: what a stranger or a slow reader may send, or not read."""

import json
import socket
import struct

HANDSHAKE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}
TEXT, BINARY, CLOSE = 1, 2, 8


def request(page, path, *, method="GET", body=b"", **headers):
    """The status of an answer, its headers and what follows."""
    with connected(page) as line:
        line.sendall(_request(page, method, path, headers) + body)
        return _answer(line)


def connected(page, **options):
    line = socket.create_connection(("127.0.0.1", page.port), timeout=300)
    for name, value in options.items():
        line.setsockopt(socket.SOL_SOCKET, getattr(socket, name), value)
    return line


def _request(page, method, path, headers):
    sent = {"Host": f"127.0.0.1:{page.port}", **headers}
    lines = [f"{method} {path} HTTP/1.1", *(f"{k}: {v}" for k, v in sent.items() if v is not None)]
    return "\r\n".join([*lines, "", ""]).encode("latin1")


def _answer(line):
    received = b""
    while b"\r\n\r\n" not in received:
        part = line.recv(65536)
        if not part:
            raise ConnectionError("no answer")
        received += part
    head, _, rest = received.partition(b"\r\n\r\n")
    status, *fields = head.decode().split("\r\n")
    headers = dict(field.split(": ", 1) for field in fields)
    while len(rest) < int(headers.get("Content-Length", 0)):
        rest += line.recv(65536)
    return int(status.split()[1]), headers, rest


def framed(data, kind=TEXT):
    """A message as it goes over the line, with a mask that changes nothing."""
    length = len(data)
    if length < 126:
        size = bytes([0x80 | length])
    elif length < 1 << 16:
        size = b"\xfe" + struct.pack(">H", length)
    else:
        size = b"\xff" + struct.pack(">Q", length)
    return bytes([0x80 | kind]) + size + bytes(4) + data


class Client:
    """An open line to a page: `say` and `hear`; the context closes it without a word."""

    def __init__(self, page, *, path=None, line=None, **headers):
        self.line = line or connected(page)
        path = path or f"/{page.secret}/socket"
        self.line.sendall(_request(page, "GET", path, HANDSHAKE | headers))
        self.status, self.headers, self._received = _answer(self.line)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.line.close()

    def say(self, **message):
        self.send(json.dumps({"id": "me", **message}).encode())

    def send(self, data, kind=TEXT):
        self.line.sendall(framed(data, kind))

    def hear(self, kind=None):
        """The next message (of a type): its head and its buffers; None = the line is closed."""
        while True:
            opcode, data = self._frame()
            if opcode == CLOSE:
                return None
            if opcode != BINARY:
                continue
            (length,) = struct.unpack_from("<I", data)
            head = json.loads(data[4 : 4 + length])
            if kind in (None, head["type"]):
                return head, _buffers(data, 4 + length, head["buffers"])

    def is_closed(self):
        """Wait until the other side has closed the line."""
        try:
            while self._frame()[0] != CLOSE:
                pass
        except (ConnectionError, EOFError):
            pass
        return True

    def _frame(self):
        first, second = self._take(2)
        length = second & 127
        if length > 125:
            length = int.from_bytes(self._take(2 if length == 126 else 8))
        return first & 15, self._take(length)

    def _take(self, count):
        while len(self._received) < count:
            part = self.line.recv(1 << 20)
            if not part:
                raise EOFError
            self._received += part
        taken, self._received = self._received[:count], self._received[count:]
        return taken


def greeted(page, **options):
    """A line whose view has said hello, and has room for frames."""
    client = Client(page, **options)
    client.say(type="hello", width=150)
    client.say(type="grant", upto=10**9, late=False)
    assert client.hear("setup")
    return client


def _buffers(data, at, lengths):
    found = []
    for length in lengths:
        found.append(data[at : at + length])
        at += length + -length % 4
    return found
