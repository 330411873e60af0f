"""The grader's zygotes: started for the first worker, replaced when they die."""

from __future__ import annotations

import atexit
import json
import os
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import asdict, dataclass

from robsim.teach.errors import GraderError
from robsim.teach.isolation._processes import scratch
from robsim.teach.isolation._processes.environment import command_for, environment_for
from robsim.teach.isolation.limits import Request

assert sys.platform != "win32"

_START = 60.0  # s, maximum for the imports of a zygote
_END = 10.0  # s, maximum for the removal of its workers and folders


@dataclass(frozen=True)
class ZygoteSetup:
    """The setup of a zygote: its modules, their folders, and the layers to leave out."""

    modules: tuple[str, ...]
    path: tuple[str, ...]
    shut: bool
    network: bool  # keep it


class ZygoteProcess:
    """A zygote from the grader's side."""

    def __init__(self, setup: ZygoteSetup) -> None:
        self._base = scratch.Base()
        self.base = self._base.path
        try:
            self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            with theirs:
                self._process = _started(theirs.fileno(), self.base)
            self._prepare(setup)
        except BaseException:
            self.close()
            raise

    def _prepare(self, setup: ZygoteSetup) -> None:
        self._control.settimeout(_START)
        try:
            self._control.send(json.dumps({**asdict(setup), "base": self.base}).encode())
            answer = json.loads(self._control.recv(1 << 16) or b"{}")
        except TimeoutError:
            answer = {"failed": f"not ready within {_START:g} s"}
        except OSError as error:
            answer = {"failed": str(error)}
        self._control.settimeout(None)
        if "ready" not in answer:
            reason = answer.get("failed", "it exited without a message")
            raise GraderError(f"the process that starts workers failed to start: {reason}")

    @property
    def process(self) -> int:
        return self._process.pid

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    @property
    def answers(self) -> bool:
        """Whether its connection is open."""
        try:
            return self.alive and bool(self._control.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT))
        except BlockingIOError:
            return True
        except OSError:
            return False

    def ask(self, request: Request, descriptors: list[int]) -> None:
        """Request a worker, from any thread; raise OSError if the zygote has ended."""
        message = json.dumps(request.to_message()).encode()
        socket.send_fds(self._control, [message], descriptors)

    def end_user(self, user: int) -> None:
        """End all processes of a user: workers of a killed zygote may be left.

        Raise ConnectionError if this zygote is killed meanwhile.
        """
        self._control.settimeout(_END)
        self._control.send(json.dumps({"end user": user}).encode())
        if not self._control.recv(1):
            raise ConnectionResetError("the process that starts workers has ended")
        self._control.settimeout(None)

    def kill(self) -> None:
        """Kill a hanging zygote at once; its workers end, too."""
        self._process.kill()

    def let_go(self) -> None:
        """Release it without ending it, in a forked process."""
        self._control.close()
        self._base.let_go()

    def close(self) -> None:
        """End the zygote, its workers, and all their folders."""
        if hasattr(self, "_control"):
            self._control.close()
        if hasattr(self, "_process"):
            try:
                self._process.wait(_END)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._base.remove()


def _started(descriptor: int, base: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command_for("robsim.teach.isolation._processes.zygote:main", descriptor),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        pass_fds=[descriptor],
        env=environment_for(base),
        cwd="/",
        start_new_session=True,  # Ctrl-C is for the grader
    )


_zygotes: dict[ZygoteSetup, ZygoteProcess] = {}
_lost_users: list[int] = []
_lock = threading.Lock()


def zygote_for(setup: ZygoteSetup) -> ZygoteProcess:
    """Return the zygote of a setup; start one if it is missing or was killed."""
    with _lock:
        zygote = _zygotes.get(setup)
        if zygote is None or not zygote.alive:
            if zygote is not None:
                zygote.close()
            zygote = _zygotes[setup] = ZygoteProcess(setup)
        _end_lost_users(zygote)
        return zygote


def _end_lost_users(zygote: ZygoteProcess) -> None:
    if sys.platform != "linux":
        return
    from robsim.teach.isolation._layers import users

    while _lost_users:
        user = _lost_users[-1]
        zygote.end_user(user)
        _lost_users.pop()
        users.give_back(user)


def retire(setup: ZygoteSetup) -> None:
    """End a zygote that does not answer, unless a living one has replaced it."""
    with _lock:
        zygote = _zygotes.get(setup)
        if zygote is not None and not zygote.answers:
            del _zygotes[setup]
            zygote.close()


def lose_user(user: int) -> None:
    """Let the next zygote end all processes of a user whose worker's zygote was killed."""
    with _lock:
        _lost_users.append(user)


def close_zygotes() -> None:
    """End all zygotes of this process with their workers; the next worker gets a new one."""
    with _lock:
        while _zygotes:
            _, zygote = _zygotes.popitem()
            zygote.close()


def _forget_zygotes() -> None:
    """Forget the parent's zygotes in a forked process."""
    global _lock
    _lock = threading.Lock()
    for zygote in _zygotes.values():
        with suppress(OSError):
            zygote.let_go()
    _zygotes.clear()
    _lost_users.clear()


atexit.register(close_zygotes)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_zygotes)
