"""Somebody between a client at 127.0.0.2 and a camera that is served at 127.0.0.1.

What the camera answers (GVCP) and what it sends (GVSP) is changed on the way.
"""

import contextlib
import select
import socket
import struct
import threading

ADDRESS = "127.0.0.2"
URL = f"gige://{ADDRESS}"
PORT = 3956
DISCOVERY, WRITE_REGISTER, READ_MEMORY = 0x02, 0x82, 0x84
STREAM_PORT, STREAM_ADDRESS = 0xD00, 0xD18  # registers
LEADER = 1  # first packet of a frame


def same(*packet):
    """Return a packet as it is."""
    return packet[-1]


@contextlib.contextmanager
def between(answer=same, sent=same):
    """Change packets: ``answer(command, address, packet)`` and ``sent(packet)`` return them.

    None is no packet at all.
    """
    ends = threading.Event()
    with contextlib.ExitStack() as stack:
        ours, theirs, stream = (
            stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(3)
        )
        ours.bind((ADDRESS, PORT))
        theirs.connect(("127.0.0.1", PORT))
        stream.bind(("127.0.0.1", 0))
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)  # more than a frame
        thread = threading.Thread(target=_pass_on, args=(ours, theirs, stream, answer, sent, ends))
        thread.start()
        try:
            yield
        finally:
            ends.set()
            thread.join()


def _pass_on(ours, theirs, stream, answer, sent, ends):
    client, asked, target = None, {}, None
    while not ends.is_set():
        for ready in select.select([ours, theirs, stream], [], [], 0.05)[0]:
            with contextlib.suppress(ConnectionError):
                if ready is ours:
                    packet, client = ours.recvfrom(65536)
                    command, number = struct.unpack(">2xH2xH", packet[:8])
                    address = struct.unpack(">I", packet[8:12])[0] if len(packet) >= 12 else None
                    asked[number] = command, address
                    if (command, address) == (WRITE_REGISTER, STREAM_PORT):
                        target = client[0], struct.unpack(">2xH", packet[12:16])[0]
                        own = struct.pack(">HH", 0, stream.getsockname()[1])
                        packet = packet[:12] + (own if target[1] else bytes(4))
                    elif (command, address) == (WRITE_REGISTER, STREAM_ADDRESS):
                        packet = packet[:12] + socket.inet_aton("127.0.0.1")
                    theirs.send(packet)
                elif ready is theirs:
                    packet = theirs.recv(65536)
                    question = asked.get(struct.unpack(">H", packet[6:8])[0], (None, None))
                    packet = answer(*question, packet)
                    if packet is not None:
                        ours.sendto(packet, client)
                else:
                    packet = sent(stream.recv(65536))
                    if packet is not None and target is not None and target[1]:
                        stream.sendto(packet, target)
