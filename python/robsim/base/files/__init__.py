"""Reading files within limits; writing them whole."""

from robsim.base.files.reading import as_folder as as_folder
from robsim.base.files.reading import as_path as as_path
from robsim.base.files.reading import content_of as content_of
from robsim.base.files.reading import open_file as open_file
from robsim.base.files.reading import parse_toml as parse_toml
from robsim.base.files.reading import read_text as read_text
from robsim.base.files.writing import PartialFile as PartialFile
from robsim.base.files.writing import copy_files as copy_files
from robsim.base.files.writing import naming as naming
from robsim.base.files.writing import open_whole as open_whole
from robsim.base.files.writing import sync_folder as sync_folder
from robsim.base.files.writing import write_csv as write_csv
from robsim.base.files.writing import write_new_files as write_new_files
from robsim.base.files.writing import write_whole as write_whole
from robsim.base.values import packed_arrays as packed_arrays
