"""Files of a zip: what it says of itself is not believed."""

from __future__ import annotations

import io
import stat
import struct
import zipfile
import zlib

from robsim.base.text import quoted
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.folder import Intake
from robsim.teach.submissions.names import refusal_in
from robsim.teach.submissions.rules import Rules

_ENTRY = b"PK\x01\x02"  # begins each entry of the list of contents
_MOST_PER_FILE = 20  # entries, folders and leftovers counted, for each file that is allowed
_OVERHEAD = 2**20  # bytes
_CHUNK = 2**16
_SMALL = 2**16  # bytes that no ratio matters for
_BROKEN = (
    *(zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, RuntimeError),
    *(OverflowError, LookupError, MemoryError),
)


def most_of_archive(rules: Rules) -> int:
    return rules.size + _OVERHEAD


def read_archive(content: bytes, whole: str, rules: Rules, intake: Intake) -> None:
    # Python reads the whole list of contents before it tells anything of it.
    if content.count(_ENTRY) > _MOST_PER_FILE * rules.files:
        raise SubmissionError(f"{whole} has too many files: hand in what counts")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            for entry in archive.infolist():
                intake.count_entry()
                _take(archive, entry, whole, rules, intake)
    except _BROKEN as error:
        said = quoted(str(error))[1:-1]
        raise SubmissionError(
            f"{whole} cannot be read as a zip ({said or type(error).__name__}): pack it again"
        ) from None


def _take(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, whole: str, rules: Rules, intake: Intake
) -> None:
    # `filename` ends at a null character.
    name = entry.orig_filename
    if not intake.wants(name):
        return
    _check_kind(entry, whole, name)
    if entry.is_dir() or name.endswith(("/", "\\")):
        return
    intake.add(name, _content(archive, entry, whole, rules, intake))


def _check_kind(entry: zipfile.ZipInfo, whole: str, name: str) -> None:
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if kind == stat.S_IFLNK:
        problem = "is a link: put the file itself in its place"
    elif kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        problem = "is no file, but a device or a pipe: remove it"
    elif entry.flag_bits & 1:
        problem = "is encrypted: pack it without a password"
    elif entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        problem = "is compressed in an unusual way: pack it as an ordinary zip"
    else:
        return
    raise refusal_in(whole, name, problem)


def _content(
    archive: zipfile.ZipFile, entry: zipfile.ZipInfo, whole: str, rules: Rules, intake: Intake
) -> bytes:
    """Return what is in a file, as far as it is allowed: its size is counted while it is read."""
    name = entry.orig_filename
    most = max(_SMALL, rules.ratio * entry.compress_size)
    parts, size = [], 0
    with archive.open(entry) as stream:
        while part := stream.read(_CHUNK):
            size += len(part)
            intake.check_size(name, size)
            if size > most:
                said = "times larger than packed: hand it in without the zip, or make it smaller"
                raise refusal_in(whole, name, f"is more than {rules.ratio} {said}")
            parts.append(part)
    return b"".join(parts)
