"""Names of files in a submission: forbidden ones, and ignored ones."""

from __future__ import annotations

import os
import re
import unicodedata

from robsim.base.text import one_line, quoted
from robsim.teach.errors import SubmissionError

# Learning platforms put a student's whole name in front of a file name.
_LONGEST_PART, _LONGEST, _DEEPEST = 150, 250, 8
_MOST_BYTES = 240  # of a name; systems take 255
_FORBIDDEN = frozenset('<>:"|?*')
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³])(\..*)?", re.IGNORECASE)
_DRIVE = re.compile(r"[A-Za-z]:")
# Leftovers of tools next to their users' files; hidden files are also ignored.
_LEFTOVERS = frozenset({"__macosx", "__pycache__", "thumbs.db", "desktop.ini", "venv"})
RENAME = "rename it with plain letters, digits and _"


def checked_path(name: str, whole: str) -> str | None:
    """Return the path of a file in a submission, or None for a file of tools.

    Raise SubmissionError if the path leads out of the submission, or if a system forbids it.
    """
    if "\0" in name:
        raise refusal_in(whole, name, f"has a null character in its name: {RENAME}")
    if name.startswith(("/", "\\")) or _DRIVE.match(name):
        said = "is an absolute path: pack only the folder"
        raise refusal_in(whole, name, said)
    parts = [part for part in re.split(r"[\\/]", name) if part not in ("", ".")]  # of old zips
    if ".." in parts:
        raise refusal_in(whole, name, "leads out of the folder: pack only the folder")
    if any(part.startswith(".") or part.lower() in _LEFTOVERS for part in parts):
        return None
    if len(name) > _LONGEST or len(parts) > _DEEPEST:
        said = "has too long a path: shorten it, and put it near the top"
        raise refusal_in(whole, name, said)
    parts = [unicodedata.normalize("NFC", part) for part in parts]
    for part in parts:
        if problem := problem_of(part):
            raise refusal_in(whole, name, f"{problem}: {RENAME}")
    return "/".join(parts)


def problem_of(part: str) -> str | None:
    """Return the reason why some system refuses a name; None = no reason."""
    if len(part) > _LONGEST_PART or len(os.fsencode(part)) > _MOST_BYTES:
        return "has too long a name"
    if not part.isprintable():
        return "has invisible characters in its name"
    if strange := sorted(_FORBIDDEN & set(part)):
        return f"has {strange[0]} in its name, which some systems refuse"
    if part != part.strip() or part.endswith("."):
        return "has a name that ends in a space or a dot"
    if _DEVICE.fullmatch(part):
        return "has the name of a device under Windows"
    return None


class Paths:
    """The paths of a submission so far; no two are equal on any system."""

    def __init__(self, whole: str) -> None:
        self._whole = whole
        self._known: dict[str, tuple[str, bool]] = {}  # the path, and whether it is a folder

    def add(self, path: str) -> None:
        parts = path.split("/")
        for end in range(1, len(parts) + 1):
            new = "/".join(parts[:end]), end < len(parts)
            known = self._known.setdefault(same_for_all(new[0]), new)
            if known is not new and not (known == new and new[1]):
                said = f"and {quoted(known[0])} are one file on some systems: rename one of them"
                twice = "occurs twice: keep one of them"
                raise refusal_in(self._whole, new[0], twice if known[0] == new[0] else said)


def same_for_all(path: str) -> str:
    """Return the common form of paths that are one file on some systems."""
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", path).casefold())


def refusal(place: str, said: str, line: int | None = None) -> SubmissionError:
    """Return the error of a file or a cell: its place, and then the rest of the sentence."""
    at = place if line is None else f"{place}, line {line}"
    return SubmissionError(f"{at}{said}", file=place, line=line)


def refusal_in(whole: str, path: str, said: str) -> SubmissionError:
    """Return the error of a file in a submission, or of the whole submission."""
    at = whole if path == whole else f"{whole}: {quoted(path)}"
    return SubmissionError(f"{at} {said}", file=one_line(path[:_LONGEST]))
