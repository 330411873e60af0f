"""What a submission may weigh, counted while it is read."""

from __future__ import annotations

from robsim.base.text import quoted
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.names import Paths, checked_path
from robsim.teach.submissions.rules import Rules

_MOST_LEFTOVERS = 20  # times as many as files that count
_ARCHIVES = (".zip", ".7z", ".rar", ".tar", ".tgz", ".gz", ".bz2", ".xz")


def size_text(size: int) -> str:
    """Return a number of bytes for a message."""
    if size >= 2**20:
        return f"{size / 2**20:.3g} MiB"
    return f"{size / 2**10:.3g} KiB" if size >= 2**10 else f"{size} bytes"


class Intake:
    """The files of a submission that have been read so far, within the limits of its rules."""

    def __init__(self, whole: str, rules: Rules) -> None:
        self.files: dict[str, bytes] = {}
        self._whole = whole
        self._rules = rules
        self._paths = Paths(whole)
        self._entries = 0
        self._size = 0

    def count_entry(self) -> None:
        """Count an entry of a folder or an archive, whatever it is."""
        self._entries += 1
        most = _MOST_LEFTOVERS * self._rules.files
        if self._entries > most:
            raise SubmissionError(
                f"{self._whole} has more than {most} files and folders: hand in what counts"
            )

    def wants(self, path: str) -> bool:
        """Return whether a file or folder counts; raise SubmissionError for a bad name."""
        return checked_path(path, self._whole) is not None

    def most_of(self, path: str) -> int:
        """Return how many bytes a file may have."""
        # Outputs of a notebook do not count: pictures, mostly.
        return self._rules.size if path.endswith(".ipynb") else self._rules.file_size

    def check_size(self, path: str, size: int) -> None:
        """Raise SubmissionError for a file that is too large."""
        most = self.most_of(path)
        if size > most:
            remedy = "clear its outputs" if path.endswith(".ipynb") else "make it smaller"
            raise SubmissionError(
                f"{self._whole}: {quoted(path)} has more than {size_text(most)}: {remedy}",
                file=path,
            )
        if self._size + size > self._rules.size:
            raise SubmissionError(
                f"{self._whole} has more than {size_text(self._rules.size)} in all: hand in what "
                "counts",
                file=path,
            )

    def add(self, path: str, content: bytes) -> None:
        """Take a file; raise SubmissionError if it may not be there, or is too much."""
        counted = checked_path(path, self._whole)
        if counted is None:
            return
        self.check_size(counted, len(content))
        if counted.lower().endswith(_ARCHIVES):
            raise SubmissionError(
                f"{self._whole}: {quoted(counted)} is an archive inside the submission: put its "
                "files in its place",
                file=counted,
            )
        if len(self.files) >= self._rules.files:
            raise SubmissionError(
                f"{self._whole} has more than {self._rules.files} files: hand in what counts"
            )
        self._paths.add(counted)
        self._size += len(content)
        self.files[counted] = content
