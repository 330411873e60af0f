"""Reading files within limits; writing them whole."""

from robsim.base.files.reading import (
    MOST_TOML,
    as_folder,
    as_path,
    content_of,
    open_file,
    parse_toml,
    read_text,
)
from robsim.base.files.writing import (
    PartialFile,
    copy_files,
    naming,
    open_whole,
    sync_folder,
    write_csv,
    write_new_files,
    write_whole,
)
from robsim.base.values import packed_arrays

__all__ = [
    "MOST_TOML",
    "PartialFile",
    "as_folder",
    "as_path",
    "content_of",
    "copy_files",
    "naming",
    "open_file",
    "open_whole",
    "packed_arrays",
    "parse_toml",
    "read_text",
    "sync_folder",
    "write_csv",
    "write_new_files",
    "write_whole",
]
