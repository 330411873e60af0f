"""Files of a zip, without trust in its own list of sizes and kinds."""

from __future__ import annotations

import io
import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from dataclasses import replace
from pathlib import Path, PurePosixPath

from robsim.base.files.reading import regular
from robsim.base.text import quoted
from robsim.teach.errors import SubmissionError
from robsim.teach.submissions.folder import Intake, is_read, lone_zip_of
from robsim.teach.submissions.names import refusal_in
from robsim.teach.submissions.rules import Rules

_ENTRY = b"PK\x01\x02"  # begins each entry of the list of contents
_MOST_LISTED = 2**24  # bytes of the list of contents of a class: some 80 000 files
_MOST_PER_FILE = 20  # entries, folders and leftovers counted, for each allowed file
_OVERHEAD = 2**20  # bytes
_CHUNK = 2**16
_SMALL = 2**16  # bytes below which any ratio is allowed
_UTF8 = 0x800  # a flag of an entry
_BROKEN = (
    *(zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError, RuntimeError),
    *(OverflowError, LookupError, MemoryError),
)
#: The zip of a class, and its entries with their places.
_Listed = tuple[zipfile.ZipFile, list[tuple[zipfile.ZipInfo, str]]]
_OUTERMOST: ContextVar[_ClassZips | None] = ContextVar("_OUTERMOST", default=None)


def most_of_archive(rules: Rules) -> int:
    return rules.size + _OVERHEAD


def read_archive(content: bytes, intake: Intake) -> None:
    # Python reads the whole list of contents before it reports any entry.
    if content.count(_ENTRY) > _MOST_PER_FILE * intake.rules.files:
        raise SubmissionError(f"{intake.whole} has too many files: leave out unused ones")
    intake.ratio = intake.rules.ratio
    with _told(intake.whole), zipfile.ZipFile(io.BytesIO(content)) as archive:
        for entry in archive.infolist():
            _take(archive, entry, _path_of(entry), intake)


class _Bounded(io.BufferedReader):
    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > _MOST_LISTED:
            raise ValueError("it has too many files")
        return super().read(size)


@contextmanager
def _class_zip(path: Path) -> Iterator[zipfile.ZipFile]:
    with _Bounded(open(path, "rb", 0, opener=regular)) as file, zipfile.ZipFile(file) as archive:
        yield archive


class _ClassZips(ExitStack):
    """Zips of classes with their lists of contents, open from their first use on."""

    def __init__(self) -> None:
        super().__init__()
        self._listed: dict[Path, _Listed] = {}

    def listed(self, path: Path) -> _Listed:
        if path not in self._listed:
            archive = self.enter_context(_class_zip(path))
            entries = [(entry, _place_of(entry)) for entry in archive.infolist()]
            self._listed[path] = archive, entries
        return self._listed[path]


@contextmanager
def class_zips() -> Iterator[_ClassZips]:
    """Yield the zips of classes; the outermost context keeps them open for all inside it.

    So their lists of contents are read once, not for each student.
    """
    if (outer := _OUTERMOST.get()) is not None:
        yield outer
        return
    with _ClassZips() as zips:
        token = _OUTERMOST.set(zips)
        try:
            yield zips
        finally:
            _OUTERMOST.reset(token)


def paths_in(path: Path) -> list[str]:
    """Return all files and empty folders ("a/") in the zip of a class; SubmissionError: broken."""
    with _told(path.name), class_zips() as zips:
        paths = [place for _, place in zips.listed(path)[1]]
    filled = {f"{folder}/" for path in paths for folder in PurePosixPath(path).parents}
    return [path for path in paths if path not in filled]


def read_from_class(path: Path, files: Sequence[tuple[str, str]], intake: Intake) -> Intake:
    """Return the files of a submission in the zip of a class; see `open_submission` for `files`."""
    whole, rules = intake.whole, intake.rules
    with _told(whole), class_zips() as zips:
        archive, entries = zips.listed(path)
        found = [
            (entry, name + place[len(start) :])
            for entry, place in entries
            for start, name in files
            if place == start or (start.endswith("/") and place.startswith(start))
        ]
        packed = lone_zip_of({name.partition("/")[0]: "/" in name for _, name in found}, intake)
        if packed is None:
            for entry, name in found:
                _take(archive, entry, name, intake)
            return intake
        entry = {name: entry for entry, name in found}[packed]
        _check_kind(entry, whole, packed)
        wide = replace(rules, size=most_of_archive(rules), file_size=most_of_archive(rules))
        content = _content(archive, entry, packed, Intake(whole, wide))
    inner = Intake(packed, rules)
    read_archive(content, inner)
    return inner


@contextmanager
def _told(whole: str) -> Iterator[None]:
    try:
        yield
    except _BROKEN as error:
        said = quoted(str(error))[1:-1]
        raise SubmissionError(
            f"{whole} cannot be read as a zip ({said or type(error).__name__}): pack it again"
        ) from None


def _path_of(entry: zipfile.ZipInfo) -> str:
    name = entry.orig_filename  # `filename` ends at a null character
    if not entry.flag_bits & _UTF8:  # some tools write UTF-8 without the flag
        with suppress(UnicodeError):
            return name.encode("cp437").decode()
    return name


def _place_of(entry: zipfile.ZipInfo) -> str:
    return _path_of(entry).replace("\\", "/").removeprefix("./").lstrip("/")


def _take(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, name: str, intake: Intake) -> None:
    intake.count_entry()
    if not intake.wants(name):
        return
    _check_kind(entry, intake.whole, name)
    if not (entry.is_dir() or name.endswith(("/", "\\"))):
        intake.add(name, _content(archive, entry, name, intake) if is_read(name) else b"")


def _check_kind(entry: zipfile.ZipInfo, whole: str, name: str) -> None:
    kind = stat.S_IFMT(entry.external_attr >> 16)
    if kind == stat.S_IFLNK:
        problem = "is a link: replace it by the file"
    elif kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        problem = "is a device or a pipe, no file: remove it"
    elif entry.flag_bits & 1:
        problem = "is encrypted: pack it without a password"
    elif entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        problem = "is compressed in an unusual way: pack it as an ordinary zip"
    else:
        return
    raise refusal_in(whole, name, problem)


def _content(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, name: str, intake: Intake) -> bytes:
    """Return the content of a file, within the limits: its size is counted while it is read."""
    ratio = intake.ratio
    content = bytearray()
    with archive.open(entry) as stream:
        while part := stream.read(_CHUNK):
            content += part
            intake.check_size(name, len(content))
            if len(content) > max(_SMALL, ratio * entry.compress_size):
                said = "times larger than packed: hand it in without the zip, or make it smaller"
                raise refusal_in(intake.whole, name, f"is more than {ratio} {said}")
    return bytes(content)
