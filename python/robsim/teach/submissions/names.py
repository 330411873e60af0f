"""Names of files in a submission: which are refused, and which are passed over."""

from __future__ import annotations

import re
import unicodedata

from robsim.base.text import one_line, quoted
from robsim.teach.errors import SubmissionError

# Learning platforms put a student's whole name before that of a file.
_LONGEST_PART, _LONGEST, _DEEPEST = 150, 250, 8
_FORBIDDEN = frozenset('<>:"|?*\\')
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³])(\..*)?", re.IGNORECASE)
_DRIVE = re.compile(r"[A-Za-z]:")
# What tools leave beside the files of their users; hidden files are passed over, too.
_LEFTOVERS = frozenset({"__macosx", "__pycache__", "thumbs.db", "desktop.ini", "venv"})
RENAME = "rename it with plain letters, digits and _"


def checked_path(name: str, whole: str) -> str | None:
    """Return the path of a file in a submission, or None for a file of tools.

    Raise SubmissionError if the path leads out of the submission, or if a system forbids it.
    """
    if "\0" in name:
        raise _refused(whole, name, "has a null character in its name", RENAME)
    if name.startswith(("/", "\\")) or _DRIVE.match(name):
        raise _refused(
            whole, name, "is an absolute path", "pack the folder itself, and nothing else"
        )
    parts = [part for part in name.split("/") if part not in ("", ".")]
    if ".." in parts or ".." in re.split(r"[\\/]", name):
        raise _refused(whole, name, "leads out of the folder", "pack the folder itself")
    if any(part.startswith(".") or part.lower() in _LEFTOVERS for part in parts):
        return None
    if len(name) > _LONGEST or len(parts) > _DEEPEST:
        raise _refused(whole, name, "has too long a path", "give it a shorter one, near the top")
    parts = [unicodedata.normalize("NFC", part) for part in parts]
    for part in parts:
        if problem := _problem(part):
            raise _refused(whole, name, problem, RENAME)
    return "/".join(parts)


def _problem(part: str) -> str | None:
    if len(part) > _LONGEST_PART:
        return "has too long a name"
    if not part.isprintable():
        return "has characters in its name that cannot be seen"
    if strange := sorted(_FORBIDDEN & set(part)):
        return f"has {strange[0]} in its name, which not every system takes"
    if part != part.strip() or part.endswith("."):
        return "has a name that ends in a space or a dot"
    if _DEVICE.fullmatch(part):
        return "has the name of a device under Windows"
    return None


class Paths:
    """The paths that a submission has so far; no two are one on any system."""

    def __init__(self, whole: str) -> None:
        self._whole = whole
        self._files: dict[str, str] = {}
        self._folders: dict[str, str] = {}

    def add(self, path: str) -> None:
        parts = path.split("/")
        for end in range(1, len(parts)):
            folder = "/".join(parts[:end])
            key = _same_for_all(folder)
            if (other := self._files.get(key)) is None:
                other = self._folders.setdefault(key, folder)
            if other != folder or key in self._files:
                raise self._twice(folder, other)
        key = _same_for_all(path)
        taken = self._files.get(key) or self._folders.get(key)
        if taken is not None:
            raise self._twice(path, taken)
        self._files[key] = path

    def _twice(self, path: str, other: str) -> SubmissionError:
        if path == other:
            return _refused(self._whole, path, "is there twice", "keep one of them")
        problem = f"and {quoted(other)} are one file on some systems"
        return _refused(self._whole, path, problem, "rename one of them")


def _same_for_all(path: str) -> str:
    return unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", path).casefold())


def _refused(whole: str, name: str, problem: str, remedy: str) -> SubmissionError:
    file = one_line(name[:_LONGEST])
    return SubmissionError(f"{whole}: {quoted(name)} {problem}: {remedy}", file=file)
