"""Sessions of format 1, whose markers are called red and blue, can be read."""

import shutil

import numpy as np
import pytest
import tomlkit

import robsim
from robsim.trace import Session
from sessions import record

pytest.importorskip("cv2")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    folder = tmp_path_factory.mktemp("session") / "run"
    record(folder, 2).close()
    setup = folder / "setup.toml"
    setup.write_text(setup.read_text().replace("format = 2", "format = 1"))
    rows = folder / "steps.csv"  # whose last column, of the headings, came later
    rows.write_text("".join(line.rpartition(",")[0] + "\n" for line in rows.read_text().split()))
    return folder


@pytest.fixture
def read_with(recorded, tmp_path):
    """Read the session with a text before and one behind its set-up."""

    def read(before="", behind=""):
        folder = tmp_path / str(len([*tmp_path.iterdir()]))
        shutil.copytree(recorded, folder)
        setup = folder / "setup.toml"
        setup.write_text(f"{before}\n{setup.read_text()}\n{behind}")
        return Session(folder)

    return read


def old_table(layout, first, second):
    """The table of a layout as sessions of format 1 have it."""
    table = {"distance_tolerance": 0.2, "maximum_blobs": 7}
    for old, role in (("red", first), ("blue", second)):
        table[old] = layout.positions[role].tolist()
        table[f"{old}_area"] = layout.areas[role]
        table[f"{old}_polygon"] = layout.polygons[role].tolist()
    return table | {"colors": [layout.colors[first], layout.colors[second]]}


@pytest.mark.parametrize(
    ("name", "first", "second"), [("lab", "right", "left"), ("sheep", "back", "front")]
)
def test_markers_of_a_session_of_before_get_their_roles(read_with, name, first, second):
    layout = robsim.load_robot(name).marker_layout()
    table = tomlkit.dumps({"markers": old_table(layout, first, second)})
    read = read_with(behind=table).markers
    assert (read.distance_tolerance, read.maximum_blobs) == (0.2, 7)
    assert read.colors == layout.colors
    for role in layout.roles:
        np.testing.assert_array_equal(read.positions[role], layout.positions[role])
        np.testing.assert_array_equal(read.polygons[role], layout.polygons[role])
        assert read.areas[role] == layout.areas[role]
