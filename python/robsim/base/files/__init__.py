"""Reading files within limits; writing them whole."""

from robsim.base.files.arrays import packed_arrays
from robsim.base.files.copies import copy_files, write_new_files
from robsim.base.files.reading import (
    MOST_TOML,
    as_folder,
    as_path,
    content_of,
    parse_toml,
    read_text,
    read_toml,
)
from robsim.base.files.tables import write_csv
from robsim.base.files.writing import PartialFile, naming, open_whole, sync_folder, write_whole

__all__ = [
    "MOST_TOML",
    "PartialFile",
    "as_folder",
    "as_path",
    "content_of",
    "copy_files",
    "naming",
    "open_whole",
    "packed_arrays",
    "parse_toml",
    "read_text",
    "read_toml",
    "sync_folder",
    "write_csv",
    "write_new_files",
    "write_whole",
]
