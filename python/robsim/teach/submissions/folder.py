"""Files of a folder: no link is followed, even if the folder changes meanwhile."""

from __future__ import annotations

import math
import os
import stat
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.names import Paths, checked_path, refusal_in
from robsim.teach.submissions.rules import Rules

_MOST_LEFTOVERS = 20  # leftovers for each file that counts
#: Suffixes of archives. The grader reads zips alone.
ARCHIVES = (".zip", ".7z", ".rar", ".tar", ".tgz", ".gz", ".bz2", ".xz")
FORMS = (".zip", ".py", ".ipynb")  # suffixes of submissions


_DOCUMENTS = (".pdf", ".doc", ".docx", ".odt", ".mp4", ".mov")  # for the teacher, of any size


def is_read(path: str) -> bool:
    """Return whether the content of a file counts; else it is taken as empty."""
    return not path.lower().endswith(_DOCUMENTS)


def size_text(size: int) -> str:
    if size >= 2**20:
        return f"{size / 2**20:.3g} MiB"
    return f"{size / 2**10:.3g} KiB" if size >= 2**10 else f"{size} bytes"


class Intake:
    """The files of a submission that have been read so far, within the limits of its rules."""

    def __init__(self, whole: str, rules: Rules) -> None:
        self.files: dict[str, bytes] = {}
        self.whole = whole
        self.rules = rules
        self.ratio = math.inf  # as in `Rules`, of a zip that a student has packed
        self._paths = Paths(whole)
        self._entries = 0
        self._size = 0

    def count_entry(self) -> None:
        self._entries += 1
        most = _MOST_LEFTOVERS * self.rules.files
        if self._entries > most:
            raise SubmissionError(
                f"{self.whole} has more than {most} files and folders: leave out unused ones"
            )

    def wants(self, path: str) -> bool:
        return checked_path(path, self.whole) is not None

    def most_of(self, path: str) -> int:
        # Outputs of a notebook do not count: pictures, mostly.
        return self.rules.size if path.endswith(".ipynb") else self.rules.file_size

    def check_size(self, path: str, size: int) -> None:
        most = self.most_of(path)
        if size > most:
            remedy = "clear its outputs" if path.endswith(".ipynb") else "make it smaller"
            raise refusal_in(self.whole, path, f"has more than {size_text(most)}: {remedy}")
        if self._size + size > self.rules.size:
            raise SubmissionError(
                f"{self.whole} has more than {size_text(self.rules.size)} in all: hand in only the "
                "required files",
                file=path,
            )

    def add(self, path: str, content: bytes) -> None:
        counted = checked_path(path, self.whole)
        if counted is None:
            return
        self.check_size(counted, len(content))
        if counted.lower().endswith(ARCHIVES):
            said = "is an archive inside the submission: put its files in its place"
            raise refusal_in(self.whole, counted, said)
        if len(self.files) >= self.rules.files:
            raise SubmissionError(
                f"{self.whole} has more than {self.rules.files} files: leave out unused ones"
            )
        self._paths.add(counted)
        self._size += len(content)
        self.files[counted] = content


# Windows has no descriptors of folders: there paths replace them, and links are checked first.
_BY_DESCRIPTOR = {os.open, os.stat} <= os.supports_dir_fd and os.scandir in os.supports_fd
_FLAGS = os.O_RDONLY | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
# A FIFO or a terminal that appears meanwhile cannot block the process.
_SAFE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0)
_KINDS = {
    stat.S_IFLNK: "a link: replace it by the file",
    stat.S_IFIFO: "a pipe: remove it",
    stat.S_IFSOCK: "a socket: remove it",
    stat.S_IFBLK: "a device: remove it",
    stat.S_IFCHR: "a device: remove it",
}
#: An open folder: its descriptor, or its path on a system without descriptors of folders.
_Folder = int | str
#: A path, and the descriptor of its start folder.
_Where = tuple[str, int | None]


def _where(folder: _Folder, name: str) -> _Where:
    return (name, folder) if isinstance(folder, int) else (os.path.join(folder, name), None)


@contextmanager
def _opened_folder(path: str, start: int | None = None) -> Iterator[_Folder]:
    if sys.platform == "win32" or not _BY_DESCRIPTOR:
        yield path
        return
    descriptor = os.open(path, _FLAGS | _SAFE | os.O_DIRECTORY, dir_fd=start)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def kind_of(path: str, whole: str) -> int:
    with _told(whole, whole):
        return _kind(os.lstat(path), whole, whole)


def read_file(path: str, whole: str, most: int) -> bytes:
    with _told(whole, whole):
        return _content((path, None), whole, whole, most)


def read_folder(path: str, intake: Intake) -> None:
    with _told(intake.whole, intake.whole), _opened_folder(path) as folder:
        _read(folder, "", intake)


def lone_zip(path: str, intake: Intake) -> str | None:
    """Return the name of a folder's only zip, if the folder has nothing else to grade.

    Platforms pack an uploaded zip in this way. None = no such zip.
    """
    with _told(intake.whole, intake.whole), _opened_folder(path) as folder:
        return lone_zip_of(_names(folder, intake), intake)


def lone_zip_of(names: Mapping[str, bool], intake: Intake) -> str | None:
    """Return the result of `lone_zip`; `names` maps each name to True for a folder."""
    found = [
        name
        for name, is_folder in names.items()
        if (is_folder or name.lower().endswith(FORMS)) and intake.wants(name)
    ]
    is_zip = len(found) == 1 and found[0].lower().endswith(FORMS[0]) and not names[found[0]]
    return found[0] if is_zip else None


def _read(folder: _Folder, prefix: str, intake: Intake) -> None:
    whole = intake.whole
    for name in sorted(_names(folder, intake)):
        path = f"{prefix}{name}"
        if not intake.wants(path):
            continue
        with _told(whole, path):
            where = _where(folder, name)
            status = os.stat(where[0], dir_fd=where[1], follow_symlinks=False)
            if _kind(status, whole, path) == stat.S_IFDIR:
                with _opened_folder(*where) as inner:
                    _read(inner, f"{path}/", intake)
            elif not is_read(path):
                intake.add(path, b"")
            else:
                intake.check_size(path, status.st_size)
                intake.add(path, _content(where, whole, path, intake.most_of(path) + 1))


def _names(folder: _Folder, intake: Intake) -> dict[str, bool]:
    """Return the names in a folder, and whether they are folders."""
    names = {}
    with os.scandir(folder) as entries:
        for entry in entries:
            intake.count_entry()
            names[entry.name] = entry.is_dir(follow_symlinks=False)
    return names


def _kind(status: os.stat_result, whole: str, path: str) -> int:
    kind = stat.S_IFMT(status.st_mode)
    if getattr(status, "st_reparse_tag", 0):  # a junction, of Windows
        kind = stat.S_IFLNK
    if kind not in (stat.S_IFREG, stat.S_IFDIR):
        raise refusal_in(whole, path, f"is {_KINDS.get(kind, 'no file: remove it')}")
    return kind


def _content(where: _Where, whole: str, path: str, most: int) -> bytes:
    descriptor = os.open(where[0], _FLAGS | _SAFE, dir_fd=where[1])
    with open(descriptor, "rb") as file:
        if _kind(os.fstat(descriptor), whole, path) != stat.S_IFREG:
            raise refusal_in(whole, path, "changed while it was read")
        return file.read(most)


@contextmanager
def _told(whole: str, path: str) -> Iterator[None]:
    """Name the file in errors of the system."""
    try:
        yield
    except OSError as error:
        if isinstance(error, FileNotFoundError):
            problem = "is missing"
        elif isinstance(error, PermissionError):
            problem = "cannot be read: give the permission to read it (chmod -R u+rX)"
        else:
            problem = f"cannot be read: {error.strerror}"
        raise refusal_in(whole, path, problem) from None
