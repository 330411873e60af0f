"""A zip that is the same for the same files."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

from robsim.base.files import write_whole

_MADE = (1980, 1, 1, 0, 0, 0)  # the first moment that a zip can have
_REGULAR = 0o100000


def write_zip(
    path: Path, files: Mapping[str, bytes], *, modes: Mapping[str, int] | None = None
) -> None:
    """Write files by their paths to a zip, whole or not at all.

    Parameters
    ----------
    path : Path
        The zip; an old one is replaced.
    files : mapping of str to bytes
        The files.
    modes : mapping of str to int, optional
        Who may do what with some of them. Default: all may read.
    """
    import zipfile

    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _MADE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3  # Unix, whose modes these are
            entry.external_attr = (_REGULAR | (modes or {}).get(name, 0o644)) << 16
            archive.writestr(entry, files[name])
    write_whole(path, content.getvalue())
