"""An error that ended a run, as it is shown: whose, where, the line, the user's part of the way."""

from __future__ import annotations

import traceback
from contextlib import suppress
from typing import Any

from robsim.base.source_line import SourceLine
from robsim.base.text import printable, said_by
from robsim.simulation.callbacks.errors import FailedCallback, callback_of, traceback_line
from robsim.simulation.slots import SLOTS

_LONGEST = 4000  # characters of a text
_MOST_FRAMES = 20


def trouble_of(error: BaseException) -> dict[str, Any]:
    """Return the field ``error`` of the message ``state``."""
    failed = callback_of(error)
    told = {
        "slot": failed.slot if failed else None,
        "k": failed.k if failed else None,
        "text": said_by(error),
        "file": None,
        "line": None,
        "code": None,
        "traceback": "",
    }
    with suppress(Exception):  # what an exception holds may be anything, such as notes = 5
        told |= _told_by(error, failed)
    return told


def _told_by(error: BaseException, failed: FailedCallback | None) -> dict[str, Any]:
    source = _source_of(error, failed)
    return {
        "text": _shortened(_text_of(error, failed, source)),
        "file": source.file if source else None,
        "line": source.number if source else None,
        "code": _code_of(error, source),
        "traceback": _shortened(_traceback_of(error)),
    }


def _source_of(error: BaseException, failed: FailedCallback | None) -> SourceLine | None:
    if failed is not None and failed.source is not None:
        return failed.source
    if isinstance(error, SyntaxError) and error.filename:
        return SourceLine(error.filename, error.lineno or 1, "<module>")
    return None


def _code_of(error: BaseException, source: SourceLine | None) -> str | None:
    if isinstance(error, SyntaxError) and error.text:  # of a file that could not be loaded
        return _shortened(error.text.strip())
    return _shortened(source.text) if source else None


def _text_of(error: BaseException, failed: FailedCallback | None, source: SourceLine | None) -> str:
    """Return kind and message, and the notes, without what only says where it was.

    The kind has no module before it, as Python would put it there.
    """
    where = f"in the callback {failed.slot} {failed.when}" if failed else None
    if failed is not None and failed.slot not in SLOTS:
        where = f"in {failed.slot} {failed.when}"
    notes = [note for note in getattr(error, "__notes__", []) if note != where]
    said = _last_lines(error)
    kind = f"{type(error).__module__}.{type(error).__qualname__}"
    if said.startswith(kind):
        said = type(error).__name__ + said.removeprefix(kind)
    if where:
        said = said.replace(f": {where}: ", ": ", 1)
    if source:
        said = said.removesuffix(f"\n  {traceback_line(source)}")
        if isinstance(error, SyntaxError) and source.file == error.filename:
            said = said.rpartition("\n")[2]
    return "\n".join([said, *map(str, notes)])


def _traceback_of(error: BaseException) -> str:
    """Return the traceback without the frames of robsim and of installed packages; maybe empty."""
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if SourceLine(frame.filename, frame.lineno or 1, frame.name).is_users
    ]
    if not frames:
        return ""
    return "".join([*traceback.format_list(frames[-_MOST_FRAMES:]), _last_lines(error)])


def _last_lines(error: BaseException) -> str:
    kind = traceback.TracebackException(type(error), error, None)
    kind.__notes__ = None
    return "".join(kind.format_exception_only()).rstrip()


def _shortened(text: str) -> str:
    return printable(text if len(text) <= _LONGEST else text[:_LONGEST] + " ...")
