"""A panel in the browser, until its last page is closed."""

from __future__ import annotations

import getpass
import os
import socket
import sys
from typing import TYPE_CHECKING

from robsim.cli import errors

if TYPE_CHECKING:
    from robsim.gui.hosted import HostedPanel
    from robsim.gui.hosts.page import Page

_PATIENCE = 3.0  # s that the last page may be away, such as while it is loaded anew


def show_panel(opened: HostedPanel, port: int = 0, *, is_wanted: bool = True) -> None:
    """Tell the address of a panel, and show it until its last page is closed, or Ctrl-C.

    Parameters
    ----------
    opened : HostedPanel
        The panel.
    port : int
        Port of its page on this machine; 0 = any that is free.
    is_wanted : bool
        Whether a browser is to be started.
    """
    page = opened._serve(port)
    _tell(page, is_shown=is_wanted and page.open(), is_wanted=is_wanted)
    _wait(page)


def _tell(page: Page, *, is_shown: bool, is_wanted: bool) -> None:
    errors.say(f"the panel is at {page.url}")
    if is_wanted and not is_shown:
        errors.print_note("no browser could be started: open this address in one")
    if not is_shown and "SSH_CONNECTION" in os.environ:
        login = f"{getpass.getuser()}@{socket.gethostname()}"
        errors.print_note(
            "to see it on the machine before you, type there: "
            f"ssh -N -L {page.port}:127.0.0.1:{page.port} {login}; then open the address there"
        )
    errors.say("Ctrl-C ends it")
    sys.stdout.flush()


def _wait(page: Page) -> None:
    try:
        page.wait(_PATIENCE)
    except KeyboardInterrupt:
        errors.print_note("ended")
    else:
        errors.say("its last page was closed: ended")
