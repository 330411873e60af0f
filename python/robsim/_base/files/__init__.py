"""Reading and writing files."""

from robsim._base.files.reading import as_folder, as_path, content_of, read_toml
from robsim._base.files.writing import copy_files, naming, temporary_path, write_whole

__all__ = [
    "as_folder",
    "as_path",
    "content_of",
    "copy_files",
    "naming",
    "read_toml",
    "temporary_path",
    "write_whole",
]
