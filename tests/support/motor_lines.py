"""Lines of the protocol to a robot, written by what its page says and by none of our code."""

import binascii
import re
import socket
from pathlib import Path

import robsim

PAGE = Path(robsim.__file__).parent / "lab/motors/PROTOCOL.md"


def line(words):
    text = words.encode() + b" "
    return text + b"*%04X\n" % binascii.crc_hqx(text, 0)


def drive_line(number, u1=1.0, u2=2.0, ttl=60000):
    return line(f"u {number} {u1:.4f} {u2:.4f} {ttl}")


def stop_line(number, ttl=60000):
    return line(f"s {number} {ttl}")


def example(language):
    """The example of the page in a language."""
    return re.search(rf"```{language}\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]


class Sender:
    """A socket that sends bytes to a receiver."""

    def __init__(self, port):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", port))
        self.socket.settimeout(300)

    def send(self, *texts):
        for text in texts:
            self.socket.send(text)

    def answer(self):
        return self.socket.recv(2048)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.socket.close()
