"""A robot definition: its geometry, its files, and that it is a value."""

import copy
import pickle
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from robsim import Simulation, load_robot
from robsim.vision import (
    BlobMarker,
    RobotDefinition,
    check_colors,
    robot_from_image,
    robot_names,
    save_robot,
)

pytestmark = pytest.mark.kernels

PICTURE = np.zeros((10, 20, 4), np.uint8)
EDGE = [[0, 0], [19, 0], [19, 9], [0, 9]]
RED = [[14, 6], [17, 6], [17, 9], [14, 9]]
BLUE = [[2, 6], [5, 6], [5, 9], [2, 9]]
WRONG = (TypeError, ValueError)

GOOD = {
    "name": "'toy'",
    "image": "'robot.png'",
    "size": "40.0",
    "alignment": "90",
    "centre": "[9.5, 4.5]",
    "outline": str(EDGE),
    "markers.right.color": "'red'",
    "markers.right.polygon": str(RED),
    "markers.left.color": "'blue'",
    "markers.left.polygon": str(BLUE),
}


def definition(**changed):
    values = {"name": "toy", "image": PICTURE, "size": 40.0, "alignment": 0.0}
    values |= {"outline": EDGE, "red": RED, "blue": BLUE} | changed
    red, blue = (BlobMarker(values.pop(color), color) for color in ("red", "blue"))
    return RobotDefinition(**({"markers": {"front": red, "back": blue}} | values))


def turned(alignment, size=40.0):
    """The same robot with another alignment, which gives its markers other roles."""
    markers = {"red": RED, "blue": BLUE}
    return robot_from_image(
        "toy", PICTURE, size=size, alignment=alignment, centre=(9.5, 4.5), outline=EDGE,
        markers=markers,
    )  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    """Write a robot's folder; what is None is left out."""

    def write(text=None, **changed):
        Image.fromarray(PICTURE).save(tmp_path / "robot.png")
        values = {key: v for key, v in (GOOD | changed).items() if v is not None}
        lines = "\n".join(f"{key} = {value}" for key, value in values.items())
        content = lines if text is None else text
        toml = tmp_path / "robot.toml"
        toml.write_bytes(content if isinstance(content, bytes) else content.encode())
        return tmp_path

    return write


# --- the lab robot


def test_the_lab_robot_has_the_geometry_of_the_manual():
    robot = load_robot()
    assert robot.name == "lab"
    markers = robot.marker_layout()
    assert markers.distance == pytest.approx(43, abs=1e-3)
    assert markers.offset == pytest.approx(14, abs=1e-3)
    np.testing.assert_allclose(markers.positions["right"], [-14, 21.5], atol=1e-3)
    np.testing.assert_allclose(markers.positions["left"], [-14, -21.5], atol=1e-3)
    assert markers.areas["right"] == pytest.approx(markers.areas["left"], rel=1e-6)
    assert 40 < robot.radius < 60


@pytest.mark.long
def test_the_markers_of_shipped_robots_are_seen():
    for name in robot_names():
        assert check_colors(load_robot(name)).ok


# --- geometry by hand: unit = 40/20 = 2 px, centre (9.5, 4.5)


@pytest.mark.parametrize(
    ("alignment", "points", "expected"),
    [
        # the picture shows it facing right: right in the picture is forward, down is right
        (0, [(12.5, 4.5), (9.5, 8.5), (10.5, 6.5)], [(6, 0), (0, 8), (2, 4)]),
        # facing up: up in the picture is forward, right is right
        (90, [(9.5, 1.5), (13.5, 4.5), (11.5, 3.5)], [(6, 0), (0, 8), (2, 4)]),
        (180, [(6.5, 4.5), (9.5, 0.5)], [(6, 0), (0, 8)]),
        (-90, [(9.5, 7.5), (5.5, 4.5)], [(6, 0), (0, 8)]),
    ],
)
def test_to_robot_frame(alignment, points, expected):
    robot = turned(alignment)
    np.testing.assert_allclose(robot.to_robot_frame(points), expected, atol=1e-12)
    # (0, 0) from (9.5, 4.5), times 2 px
    assert robot.radius == pytest.approx(2 * np.hypot(9.5, 4.5))


def test_centre_and_scale():
    robot = definition()
    np.testing.assert_array_equal(robot.to_robot_frame([[9.5, 4.5]]), [[0, 0]])
    moved = definition(centre=[0, 0])
    np.testing.assert_array_equal(moved.to_robot_frame([[1, 2]]), [[2, 4]])
    with pytest.raises(ValueError, match=r"\bpoints\b"):
        robot.to_robot_frame([[1, np.nan]])


def test_the_locator_of_the_toy():
    # alignment 90: markers at (15.5, 7.5) and (3.5, 7.5), 3 picture pixels square
    robot = turned(90)
    reversed_markers = {
        role: replace(marker, polygon=marker.polygon[::-1])
        for role, marker in robot.markers.items()
    }
    for one in (robot, replace(robot, markers=reversed_markers)):
        markers = one.marker_layout()
        np.testing.assert_allclose(markers.positions["right"], [-6, 12])
        np.testing.assert_allclose(markers.positions["left"], [-6, -12])
        assert (markers.distance, markers.offset) == pytest.approx((24, 6))
        assert (markers.areas["right"], markers.areas["left"]) == pytest.approx((36, 36))


# --- folders


def test_a_written_robot_is_loaded_back(folder):
    robot = load_robot(folder())
    assert (robot.name, robot.size, robot.alignment) == ("toy", 40.0, 90)
    np.testing.assert_array_equal(robot.image, PICTURE)
    np.testing.assert_array_equal(robot.centre, [9.5, 4.5])
    np.testing.assert_array_equal(robot.outline, EDGE)
    np.testing.assert_array_equal(robot.markers["right"].polygon, RED)
    np.testing.assert_array_equal(robot.markers["left"].polygon, BLUE)
    assert load_robot(str(folder())).name == "toy"
    np.testing.assert_array_equal(load_robot(folder(centre=None)).centre, [9.5, 4.5])
    sim = Simulation(robot=folder(), area=(200, 100))
    assert sim.markers.distance == pytest.approx(24)


def refuses(path, key):
    """The error names the file and, as a whole word, the key."""
    with pytest.raises(ValueError, match=re.escape(str(path / "robot.toml"))) as caught:
        load_robot(path)
    message = str(caught.value).replace(str(path), "")
    assert re.search(rf"\b{key}\b", message), message


NO_POLYGONS = ("1", "[]", "[[1, 2], [3, 4], [5]]", "[['1', '6'], ['3', '6'], ['3', '8']]")


@pytest.mark.parametrize(
    ("key", "values"),
    {
        "name": (None, "1"),
        "size": (None, "0.99", "10000.1", "'40'", "1" + "0" * 400),
        "alignment": (None, "nan"),
        "centre": ("[1]", "['1', '2']"),
        "outline": (None, *NO_POLYGONS),
        "maximum_blobs": ("0", "100001", "1.5"),
        "Size": ("1",),
        "markers.right.polygon": (None, *NO_POLYGONS, str(BLUE)),
        "image": (None, "1", "'no.png'", "'robot.toml'", "'..'", "'../robot.png'", "'/etc/passwd'"),
    }.items(),
)
def test_a_wrong_key_or_value_of_a_file_is_named(folder, key, values):
    said = {"markers.right.polygon": "(markers|right marker)", "image": "(image|toml)"}
    for value in values:
        refuses(folder(**{key: value}), said.get(key, key))


def test_a_file_that_is_none(folder):
    nested = "outline = " + "[" * 10_000
    for text in ("", "name = ", b"\xff\xfe", nested):
        refuses(folder(text=text), "")
    for name in ("a/robot.png", "./robot.png", "C:robot.png", "..\\\\robot.png"):
        refuses(folder(image=f'"{name}"'), "image must be the name of a file next to")
    for key, values in {"size": (1, 10_000), "maximum_blobs": (1, 100_000)}.items():
        for value in values:
            assert getattr(load_robot(folder(**{key: value})), key) == value


def png(width, height):
    """The bytes of a PNG file that claims to be so large."""
    header = b"IHDR" + width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"\x08\6\0\0\0"
    parts = [header, b"IDAT" + zlib.compress(b"\0" * 100), b"IEND"]
    chunks = [
        (len(part) - 4).to_bytes(4, "big") + part + zlib.crc32(part).to_bytes(4, "big")
        for part in parts
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def test_a_broken_picture_names_both_files(folder):
    path = folder()
    bomb = png(60_000, 60_000)
    for content in (b"", b"hello", png(20, 10)[:60], png(200, 100), png(0, 0), bomb):
        (path / "robot.png").write_bytes(content)
        refuses(path, "robot.png")


def test_an_unknown_robot():
    for robot in ("no such robot", "", "..", "/", "\0", "lab/robot.toml"):
        with pytest.raises(ValueError, match=r"known: .*lab"):
            load_robot(robot)
    with pytest.raises(TypeError, match=r"\brobot\b"):
        load_robot(3)


# --- what is wrong with a definition


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("image", (None, PICTURE[..., :3], PICTURE[:0], PICTURE.astype(float))),
        ("size", (0.99, 10_000.1, np.nan)),
        ("alignment", (-np.inf,)),
        ("centre", ((1,), (np.nan, 1))),
        ("red", ([], EDGE[:2], [[1, 2], [2, 3], [3, 4]], np.full((3, 2), np.nan))),
        ("outline", (None, EDGE[:2], [[0, 0], [1e7, 0], [0, 1e7]])),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_wrong_value_is_named(name, values):
    said = "polygon" if name == "red" else name
    for value in values:
        with pytest.raises(WRONG, match=rf"^{said} must "):
            definition(**{name: value})


def circle(points):
    angle = 2 * np.pi * np.arange(points) / points
    return np.column_stack((3 * np.cos(angle) + 14, 3 * np.sin(angle) + 4.5))


FRONT = "front marker (red) must"
NOTCHED = [[0, 0], [7, 0], [10, 8], [13, 0], [19, 0], [19, 9], [0, 9]]
FAR = [[100, 0], [110, 0], [110, 10], [105, 12], [100, 10]]
ACROSS = [[5, 1], [16, 1], [16, 5], [5, 5]]  # from one side of the notch to the other
BEYOND = [[0, 0], [19, 0], [24.5, 5], [19, 9], [0, 9]]


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"red": [[14, 6], [17, 9], [17, 6], [14, 9]]}, [FRONT, "itself", "(14, 6) to (17, 9)"]),
        ({"outline": [[0, 0], [19, 9], [19, 0], [0, 9]]}, ["outline must not intersect itself"]),
        ({"blue": [[8, 2], [11, 2], [11, -8]]}, ["blue", "outside is (11, -8), by up to 8.0 px"]),
        ({"red": FAR}, ["(100, 0), (110, 0), (110, 10) and 2 more, by up to 91.0"]),
        ({"outline": NOTCHED, "centre": [3, 3], "red": ACROSS}, [FRONT, "(10, 1), by up"]),
        ({"centre": [9.5, 12]}, ["centre must lie", "outside is (9.5, 12), by up to 3.0 px"]),
        ({"outline": BEYOND}, ["20 x 10 px: outside is (24.5, 5), by up to 5.0 px"]),
        ({"red": EDGE}, ["front marker (red) and back marker (blue) must not overlap"]),
        ({"centre": [9, 30], "red": [[2, 2], [4, 2], [4, -9]]}, ["centre must", FRONT]),
        ({"red": circle(1001)}, ["got 1001"]),
    ],
)
def test_polygons_that_do_not_fit(changed, says):
    with pytest.raises(ValueError, match="must") as caught:
        definition(**changed)
    for words in says:
        assert words in str(caught.value)


def test_polygons_that_just_fit():
    assert definition(outline=[[-1.4, 0], [20.4, 0], [20.4, 10.4], [-1.4, 10.4]]).radius > 0
    assert definition(red=[[14, 6], [19.9, 6], [19.9, 9], [14, 9]]).radius > 0
    beside = definition(red=[[5, 6], [8, 6], [8, 9], [5, 9]])  # a common edge
    assert beside.marker_layout().distance == pytest.approx(6)
    twice = definition(red=[RED[0], *RED, RED[0]])
    np.testing.assert_array_equal(twice.markers["front"].polygon, RED)
    assert len(definition(red=circle(1000)).markers["front"].polygon) == 1000


# --- a value: equal by content, unchangeable, read once


def test_equal_by_content():
    robot, same = definition(), definition(image=np.zeros((10, 20, 4), np.uint8), size=40)
    assert robot == same
    assert hash(robot) == hash(same)
    assert robot != "toy"
    image = PICTURE.copy()
    image[3, 4, 1] = 1
    for changed in (
        {"name": "other"},
        {"image": image},
        {"size": 41.0},
        {"alignment": 1.0},
        {"outline": [[0, 0], [19, 0], [19, 9.1], [0, 9]]},
        {"blue": [[2, 6], [5, 6], [5, 8]]},
        {"centre": [9, 4]},
        {"maximum_blobs": 8},
        {"markers": {**robot.markers, "front": BlobMarker(RED, "green")}},
    ):
        assert robot != definition(**changed), changed
    for copied in (copy.deepcopy(robot), pickle.loads(pickle.dumps(robot)), replace(robot)):
        assert (copied, hash(copied), copied.radius) == (robot, hash(robot), robot.radius)
    assert replace(robot, size=20).radius == pytest.approx(robot.radius / 2)


def test_nobody_can_change_it():
    image = np.zeros((10, 20, 4), np.uint8, order="F")
    robot = definition(image=image)
    image[:] = 9
    assert robot == definition()
    with pytest.raises(AttributeError):
        robot.size = 5
    for kept in (robot, pickle.loads(pickle.dumps(robot))):
        for array in (
            kept.image,
            kept.centre,
            kept.outline,
            *(one.polygon for one in kept.markers.values()),
        ):
            assert array.flags.c_contiguous
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1
            with pytest.raises(ValueError, match="WRITEABLE"):
                array.setflags(write=True)


def test_a_robot_is_loaded_once(monkeypatch):
    robot = load_robot("lab")
    monkeypatch.setattr("robsim.base.files.codec.load_table", pytest.fail)
    for name in ("lab", "LAB", None):
        assert load_robot(name) is robot
        assert Simulation(robot=name).robot is robot
    assert Simulation(robot=definition()).robot == definition()


def test_files_that_have_changed_are_read_again(tmp_path):
    save_robot(tmp_path, definition())
    robot = load_robot(tmp_path)
    assert load_robot(tmp_path) is robot
    toml = tmp_path / "robot.toml"
    toml.write_text(toml.read_text().replace("size = 40.0", "size = 400.0"))
    assert load_robot(tmp_path).size == 400
    assert robot.size == 40
    Image.fromarray(np.full((10, 20, 4), 77, np.uint8)).save(tmp_path / "robot.png")
    assert (load_robot(tmp_path).image == 77).all()
    assert not robot.image.any()
    (tmp_path / "robot.png").unlink()
    refuses(tmp_path, "robot.png")
