"""The command ``robsim gui`` without a folder or options of a run: the start page.

Few modules are loaded before the page appears, and the rest afterwards.
"""

from __future__ import annotations

from robsim.cli import errors
from robsim.cli.outcome import keep_run, show_panel


def gui(port: int = 0, no_browser: bool = False) -> None:
    """Open the start page in the browser.

    Each card opens the panel with a run.

    --port N: Port of the page on this machine. [default: any that is free]
    --no-browser: Only print the address, and open no browser.

    Example: robsim gui
    """
    from robsim.gui.start.host import Start

    with errors.report_errors(None), Start(keep_run) as opened:
        show_panel(opened, port, is_wanted=not no_browser)
        if opened.panel is not None:
            keep_run(opened.panel)
