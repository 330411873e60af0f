"""Python source of a submission, checked without running it."""

from __future__ import annotations

import ast
import codecs
import re
import symtable
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from robsim.base.text import one_line, quoted
from robsim.simulation.callback_folder import misspelled
from robsim.simulation.slots import SLOTS
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.names import refusal

# Memory and time of Python's own parser: 1 kB a word at worst, and the square of a dotted name.
_MOST_WORDS = 250_000
_WORD = re.compile(r"\d[\w.]*+|\w++|[^\w\s]")
_LONG_CHAIN = re.compile(r"(?<!\w)(?:\w++[\s\\]*+\.[\s\\]*+){64}")
_CODING = re.compile(rb"[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)")
# A text in ASCII, with a line break for codings that have escapes.
_PLAIN = bytes(range(32, 93)) + b"n" + bytes(range(93, 127))
_LOCK = threading.Lock()  # filters of warnings belong to all threads


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress warnings about a submission's code inside; Python repeats them in its run."""
    with _LOCK, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def decoded(content: bytes, place: str) -> str:
    """Return the text of a Python file in its coding (PEP 263); raise SubmissionError."""
    coding = _coding(content, place)
    offset, problem = content.find(b"\0"), "a null character"
    if offset < 0:
        try:
            text = content.decode("utf-8-sig" if coding == "utf-8" else coding)
        except UnicodeDecodeError as error:
            offset, problem = error.start, f"the byte 0x{content[error.start]:02x}"
        else:
            return text.replace("\r\n", "\n").replace("\r", "\n")
    line = content.count(b"\n", 0, offset) + 1
    said = f": it is not {coding.upper()} text, it has {problem}: save it as UTF-8 text"
    raise refusal(place, said, line)


def _coding(content: bytes, place: str) -> str:
    for number, line in enumerate(content.split(b"\n", 2)[:2], 1):
        if found := _CODING.match(line):
            name = found[1].decode("ascii", "replace")
            with suppress(LookupError, UnicodeError):  # unknown coding, or no text
                if _PLAIN.decode(name) == _PLAIN.decode("ascii"):
                    return codecs.lookup(name).name
            said = f"{quoted(name)}: save it as UTF-8 text, and delete this line"
            raise refusal(place, f": it declares the coding {said}", number)
        if line.strip() and not line.lstrip().startswith(b"#"):
            break
    return "utf-8"


def check_extent(text: str, place: str) -> None:
    words = sum(1 for _ in _WORD.finditer(text))
    if words > _MOST_WORDS:
        raise refusal(
            place,
            f" has {words} words and signs, more than the allowed {_MOST_WORDS}: put large tables "
            "into another file, such as .npy or .csv",
        )
    if chain := _LONG_CHAIN.search(text):
        line = text.count("\n", 0, chain.start()) + 1
        raise refusal(place, ": it has a name with more than 64 dots: shorten it", line)


def check_source(content: bytes, place: str) -> None:
    text = decoded(content, place)
    check_extent(text, place)
    compiled(text, text, place)


def compiled(code: str | ast.Module, text: str, place: str, flags: int = 0) -> Any:
    """Return the result of `compile` for a text or its tree; raise SubmissionError."""
    try:
        with quiet():
            return compile(code, place, "exec", flags, dont_inherit=True)
    except (SyntaxError, ValueError, OverflowError, RecursionError, MemoryError) as error:
        raise _not_python(error, text, place) from None


def statements_of(content: bytes, place: str) -> list[ast.stmt]:
    text = decoded(content, place)
    body: list[ast.stmt] = compiled(text, text, place, ast.PyCF_ONLY_AST).body
    return body


def _not_python(error: BaseException, text: str, place: str) -> SubmissionError:
    if not isinstance(error, SyntaxError):
        return refusal(place, " is nested too deeply for Python: split its long expressions")
    lines = text.split("\n")
    line = min(max(error.lineno or 1, 1), len(lines))
    shown = lines[line - 1].strip()
    said = quoted(str(error.msg))[1:-1]
    return refusal(place, f": {said}" + (f": {quoted(shown)}" if shown else ""), line)


def imported_words(content: bytes) -> set[str]:
    lines = content.decode("utf-8", "replace").replace("\\\n", " ").splitlines()
    return {
        word
        for line in lines
        if "import" in line or "from" in line
        for word in re.findall(r"\w+", line)
    }


def slots_of_module(text: str, file: str, slots: tuple[str, ...]) -> tuple[str, ...]:
    """Return the slots and functions of a file; raise SubmissionError if it has no slot."""
    with quiet():
        table = symtable.symtable(text, file, "exec")
    defined = {s.get_name() for s in table.get_symbols() if s.is_assigned() or s.is_imported()}
    found = tuple(slot for slot in slots if slot in defined)
    if not found:
        raise no_slot(one_line(file), defined, slots)
    return found


def no_slot(place: str, defined: set[str], slots: tuple[str, ...]) -> SubmissionError:
    """Return the error for a file or notebook without any slot or function of the assignment."""
    wanted = " or ".join(
        f"{name}({SLOTS[name].argument if name in SLOTS else '...'})" for name in slots
    )
    hints = [
        f"; is {one_line(name)} meant to be {slot}?"
        for name, slot in sorted(misspelled(defined).items())
        if slot in slots
    ]
    first = next(iter(slots))
    lacks = "fills no slot" if first in SLOTS else "defines no required function"
    said = f"define {wanted}, or write {first} = ... for an object that can be called"
    return refusal(place, f" {lacks}: {said}" + "".join(hints[:3]))
