"""What robsim has written, of each kind and version, is read for ever, number by number."""

import json
import shutil
from pathlib import Path

import pytest

from kept_files import EXPECTED, KINDS, digest

VERSIONS = sorted((Path(__file__).parents[1] / "data").glob("[0-9]*"))


@pytest.mark.filterwarnings("ignore:store .* was created with numpy")  # with another one than here
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("version", VERSIONS, ids=lambda folder: folder.name)
def test_a_file_of_an_earlier_version_is_read_as_it_was(version, kind, tmp_path):
    folder = shutil.copytree(version, tmp_path / version.name)
    found = json.loads(json.dumps(digest(KINDS[kind](folder))))
    expected = json.loads((version / EXPECTED).read_text())[kind]
    if kind == "trace":  # later columns are not in it
        found = {name: found.get(name) for name in expected}
    assert found == expected


def test_there_are_files_of_each_version():
    assert VERSIONS
    for folder in VERSIONS:
        assert json.loads((folder / EXPECTED).read_text()).keys() == KINDS.keys()
