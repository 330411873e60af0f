"""A line that keeps what it is sent, in place of a browser."""

from robsim.gui._link import Link
from waiting import wait_for


class Watcher(Link):
    """A view of a panel without a browser."""

    def __init__(self, view):
        super().__init__()
        self.view = view
        self.messages = []
        view.connect(self)
        self.say("hello", width=100)

    def transmit(self, head, buffers):
        self.messages.append(dict(head))

    def say(self, kind, **fields):
        self.view.receive(self, {"type": kind, "id": "here", **fields})

    def settle(self):
        """Wait until all that was said is done, and answered."""
        done = []
        self.view.post(
            lambda: self.view.driver.call(lambda: self.view.post(lambda: done.append(1)))
        )
        wait_for(lambda: done)

    def of(self, kind):
        return [message for message in list(self.messages) if message["type"] == kind]

    def newest(self, kind):
        return self.of(kind)[-1]

    def notes(self):
        return [message["text"] for message in self.of("note")]
