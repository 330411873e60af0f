import re
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from robsim import Simulation, load_robot
from robsim.robots import RobotDefinition, check_colors, robot_names
from robsim.robots._definition import from_colors
from robsim.robots._lookup import as_robot
from robsim.vision import MarkerLayout

pytestmark = pytest.mark.kernels

PICTURE = np.zeros((10, 20, 4), np.uint8)
EDGE = [[0, 0], [19, 0], [19, 9], [0, 9]]
RED = [[14, 6], [17, 6], [17, 9], [14, 9]]
BLUE = [[2, 6], [5, 6], [5, 9], [2, 9]]

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
    """Its red marker is its front one, or what another alignment makes of it."""
    values = {"name": "toy", "image": PICTURE, "size": 40.0, "alignment": 0.0}
    values |= {"outline": EDGE, "red": RED, "blue": BLUE} | changed
    markers = {color: values.pop(color) for color in ("red", "blue")}
    if "alignment" in changed:
        return from_colors(markers, **values)
    return RobotDefinition(markers={"front": markers["red"], "back": markers["blue"]}, **values)


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


def inside(polygon, points):
    """Even-odd rule."""
    x, y = np.asarray(points).T
    count = np.zeros(len(points), int)
    for (ax, ay), (bx, by) in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        crosses = (ay > y) != (by > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            count += crosses & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return count % 2 == 1


# --- the robot that ships with robsim


def test_the_lab_robot_ships():
    assert "lab" in robot_names()
    robot = load_robot()
    assert robot.name == "lab"
    assert robot.image.dtype == np.uint8
    assert robot.image.shape[2] == 4
    assert repr(robot).startswith("RobotDefinition(name='lab'")


def test_the_lab_robot_has_the_geometry_of_the_manual():
    robot = load_robot("lab")
    markers = robot.marker_layout()
    assert markers.distance == pytest.approx(43, abs=1e-3)
    assert markers.offset == pytest.approx(14, abs=1e-3)
    np.testing.assert_allclose(markers.positions["right"], [-14, 21.5], atol=1e-3)
    np.testing.assert_allclose(markers.positions["left"], [-14, -21.5], atol=1e-3)
    assert markers.areas["right"] == pytest.approx(markers.areas["left"], rel=1e-6)
    assert 40 < robot.radius < 60


@pytest.mark.parametrize("marker", ["right", "left"])
def test_the_markers_lie_within_the_outline(marker):
    robot = load_robot()
    assert inside(robot.outline, robot.markers[marker]).all()


@pytest.mark.parametrize("marker", ["right", "left"])
def test_the_picture_shows_the_marker_where_the_polygon_is(marker):
    robot = load_robot()
    u, v = robot.markers[marker].mean(axis=0).round().astype(int)
    red, green, blue, alpha = robot.image[v, u].astype(int)
    assert alpha == 255
    strong, weak = (red, blue) if marker == "right" else (blue, red)
    assert strong > 1.5 * weak
    assert strong > 1.5 * green


# --- geometry by hand: unit = 40/20 = 2 px, centre (9.5, 4.5)


@pytest.mark.parametrize(
    ("alignment", "point", "forward", "right"),
    [
        # the picture shows it facing right: right in the picture is forward, down is right
        (0, (12.5, 4.5), 6, 0),
        (0, (9.5, 8.5), 0, 8),
        (0, (10.5, 6.5), 2, 4),
        # facing up: up in the picture is forward, right is right
        (90, (9.5, 1.5), 6, 0),
        (90, (13.5, 4.5), 0, 8),
        (90, (11.5, 3.5), 2, 4),
        # facing left
        (180, (6.5, 4.5), 6, 0),
        (180, (9.5, 0.5), 0, 8),
        # facing down
        (-90, (9.5, 7.5), 6, 0),
        (-90, (5.5, 4.5), 0, 8),
    ],
)
def test_to_robot_frame(alignment, point, forward, right):
    robot = definition(alignment=alignment)
    np.testing.assert_allclose(robot.to_robot_frame([point]), [[forward, right]], atol=1e-12)


def test_centre_and_unit():
    robot = definition()
    np.testing.assert_array_equal(robot.centre, [9.5, 4.5])
    assert robot.unit == 2
    np.testing.assert_array_equal(robot.to_robot_frame([[9.5, 4.5]]), [[0, 0]])
    moved = definition(centre=[0, 0])
    np.testing.assert_array_equal(moved.to_robot_frame([[1, 2]]), [[2, 4]])


@pytest.mark.parametrize("alignment", [0, 30, 90])
def test_radius_is_the_farthest_corner(alignment):
    # (0, 0) from (9.5, 4.5), times 2 px
    robot = definition(alignment=alignment)
    assert robot.radius == pytest.approx(2 * np.hypot(9.5, 4.5))


def test_the_locator_of_the_toy():
    # alignment 90: markers at (15.5, 7.5) and (3.5, 7.5), 3 picture pixels square
    markers = definition(alignment=90).marker_layout()
    np.testing.assert_allclose(markers.positions["right"], [-6, 12])
    np.testing.assert_allclose(markers.positions["left"], [-6, -12])
    assert (markers.distance, markers.offset) == pytest.approx((24, 6))
    assert (markers.areas["right"], markers.areas["left"]) == pytest.approx((36, 36))


SIDE = st.floats(2, 40)
PLACE = st.tuples(st.floats(-200, 200), st.floats(-200, 200))


def star(corners, place):
    """A polygon without crossings around the place, counted from the angle 0."""
    angles = 2 * np.pi * np.arange(len(corners)) / len(corners)
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    return np.array(place) + np.array(corners)[:, None] * rays


def triangles(polygon, around):
    """Centroid and area, as the sum of the triangles around a place inside."""
    a, b = polygon - around, np.roll(polygon, -1, axis=0) - around
    areas = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    return around + (areas[:, None] * (a + b) / 3).sum(axis=0) / areas.sum(), areas.sum()


@pytest.mark.long
@settings(max_examples=150)
@given(
    red=st.lists(SIDE, min_size=3, max_size=8),
    blue=st.lists(SIDE, min_size=3, max_size=8),
    place=PLACE,
    apart=st.floats(100, 300),
    clockwise=st.booleans(),
)
def test_the_locator_of_random_markers(red, blue, place, apart, clockwise):
    red_place = np.array(place)
    blue_place = red_place - (0, apart)
    markers = {"right": star(red, red_place), "left": star(blue, blue_place)}
    red_centroid, area_right = triangles(markers["right"], red_place)
    blue_centroid, area_left = triangles(markers["left"], blue_place)
    if clockwise:
        markers = {name: polygon[::-1] for name, polygon in markers.items()}
    markers = MarkerLayout.from_markers(markers)
    np.testing.assert_allclose(markers.positions["right"], red_centroid, atol=1e-8)
    np.testing.assert_allclose(markers.positions["left"], blue_centroid, atol=1e-8)
    assert markers.distance == pytest.approx(np.linalg.norm(red_centroid - blue_centroid))
    assert markers.areas["right"] == pytest.approx(area_right)
    assert markers.areas["left"] == pytest.approx(area_left)
    assert markers.offset == pytest.approx(-(red_centroid + blue_centroid)[0] / 2, abs=1e-8)


@pytest.mark.long
@settings(max_examples=60)
@given(alignment=st.floats(-360, 360), size=st.floats(1, 500))
def test_alignment_turns_and_size_scales(alignment, size):
    # distances in picture pixels stay what they are, times the unit
    robot = definition(alignment=alignment, size=size)
    points = robot.to_robot_frame([[9.5, 4.5], [12.5, 8.5]])
    assert np.linalg.norm(points[1] - points[0]) == pytest.approx(5 * size / 20)
    turn = np.arctan2(points[1, 1], points[1, 0]) - np.arctan2(4, 3)
    assert np.exp(1j * turn) == pytest.approx(np.exp(1j * np.deg2rad(alignment)))


# --- folders


def test_a_written_robot_is_loaded_back(folder):
    robot = load_robot(folder())
    assert (robot.name, robot.size, robot.alignment) == ("toy", 40.0, 90)
    np.testing.assert_array_equal(robot.image, PICTURE)
    np.testing.assert_array_equal(robot.centre, [9.5, 4.5])
    np.testing.assert_array_equal(robot.outline, EDGE)
    np.testing.assert_array_equal(robot.markers["right"], RED)
    np.testing.assert_array_equal(robot.markers["left"], BLUE)
    assert load_robot(str(folder())).name == "toy"
    np.testing.assert_array_equal(load_robot(folder(centre=None)).centre, [9.5, 4.5])


def test_an_opaque_or_grey_picture_will_do(folder):
    path = folder()
    Image.fromarray(np.full((10, 20), 7, np.uint8)).save(path / "robot.png")
    np.testing.assert_array_equal(load_robot(path).image[0, 0], [7, 7, 7, 255])


def test_a_simulation_takes_the_folder(folder):
    sim = Simulation(robot=folder(), area=(200, 100))
    assert sim.robot.name == "toy"
    assert sim.markers.distance == pytest.approx(24)


def refuses(path, key):
    """The error names the file and, as a whole word, the key."""
    with pytest.raises(ValueError, match=re.escape(str(path / "robot.toml"))) as caught:
        load_robot(path)
    message = str(caught.value).replace(str(path), "")
    assert re.search(rf"\b{key}\b", message), message


NO_POLYGONS = [
    *("1", "true", "'abc'", "2020-01-01", "{a = 1, b = 2, c = 3}", "[]"),
    "[[1, 2], [3, 4]]",
    "[[1, 2], [2, 3], [3, 4]]",
    "[[1, 2], [3, 4], [5]]",
    "[[1, 2, 3], [3, 4, 5], [5, 7, 8]]",
    "[[nan, 2], [3, 4], [5, 0]]",
    "[[inf, 2], [3, 4], [5, 0]]",
    "[['a', 'b'], ['c', 'd'], ['e', 'f']]",
    "[['1', '6'], ['3', '6'], ['3', '8']]",
]


WRONG_VALUES = {
    "name image": ("1", "true", "[]", "['a']"),
    "size": (
        *("0", "-1", "0.0", "nan", "inf", "-inf", "1e400", "'40'", "true", "[40]", "2020-01-01"),
        "1" + "0" * 400,
    ),
    "alignment": ("nan", "inf", "'up'", "false", "[90]", "1" + "0" * 400),
    "centre": (
        *("1", "[1]", "[1, 2, 3]", "[nan, 1]", "['a', 'b']", "[[1, 2]]", "'ab'", "[]"),
        *("{x = 1, y = 2}", "['1', '2']", "[true, false]"),
    ),
    "outline markers.right.polygon markers.left.polygon": NO_POLYGONS,
}


@pytest.mark.long
@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        *((key, None, f"{key} is missing") for key in GOOD if key != "centre" and "." not in key),
        ("markers.right.polygon", None, "markers"),
        *((key, "1", f"{key} is not known") for key in ("colour", "Size", "center")),
        *(
            (k, v, k.split(".")[0])
            for keys in WRONG_VALUES
            for k in keys.split()
            for v in WRONG_VALUES[keys]
        ),
        ("markers.right.polygon", str(BLUE), "right marker"),
    ],
)
def test_wrong_keys_and_values_of_a_file(folder, key, value, says):
    refuses(folder(**{key: value}), says)


def test_markers_without_polygons_are_named(folder):
    missing = {f"markers.{role}.polygon": None for role in ("right", "left")}
    refuses(folder(**missing), "markers must have a polygon each, got")


@pytest.mark.parametrize(
    "text",
    [
        *("", "[name]\na = 1", "name = ", "\0", b"\xff\xfe", "name = 'a'\nname = 'b'"),
        "outline = " + "[" * 10_000,
    ],
    ids=lambda text: repr(text[:20]),
)
def test_broken_toml_names_the_file(folder, text):
    refuses(folder(text=text), "")


@pytest.mark.parametrize("name", ["no.png", "", "..", "robot.toml", "/"])
def test_an_image_that_is_none(folder, name):
    path = folder(image=f"'{name}'")
    with pytest.raises(ValueError, match=re.escape(str(path / "robot.toml"))):
        load_robot(path)


@pytest.mark.parametrize(
    "name",
    [
        *("../robot.png", "../../etc/passwd", "/etc/passwd", "a/robot.png", "./robot.png"),
        *("..", ".", "C:robot.png", "C:\\\\robot.png", "..\\\\robot.png", "robot.png/"),
    ],
)
def test_an_image_that_is_not_beside_its_file(folder, name):
    path = folder(image=f'"{name}"')
    with pytest.raises(ValueError, match="image must be the name of a file beside"):
        load_robot(path)


def png(width, height):
    """The bytes of a PNG file that claims to be so large."""
    header = b"IHDR" + width.to_bytes(4, "big") + height.to_bytes(4, "big") + b"\x08\6\0\0\0"
    parts = [header, b"IDAT" + zlib.compress(b"\0" * 100), b"IEND"]
    chunks = [
        (len(part) - 4).to_bytes(4, "big") + part + zlib.crc32(part).to_bytes(4, "big")
        for part in parts
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


BROKEN_PICTURES = {
    "empty": b"",
    "text": b"hello",
    "signature": b"\x89PNG\r\n\x1a\n",
    "cut": png(20, 10)[:60],
    "short": png(200, 100),
    "size 0": png(0, 0),
    "bomb": png(60_000, 60_000),
}


@pytest.mark.parametrize("content", BROKEN_PICTURES.values(), ids=BROKEN_PICTURES)
def test_a_broken_picture_names_both_files(folder, content):
    path = folder()
    (path / "robot.png").write_bytes(content)
    refuses(path, "robot.png")


@pytest.mark.parametrize("robot", ["no such robot", "", "..", "/", "\0", "lab/robot.toml"])
def test_an_unknown_robot(robot):
    with pytest.raises(ValueError, match=r"there are .*lab"):
        load_robot(robot)


# --- definitions in Python


def test_as_robot():
    robot = definition()
    assert as_robot(robot) is robot
    assert as_robot("lab").name == "lab"
    assert as_robot(None).name == "lab"
    for wrong in (5, b"lab", ["lab"]):
        with pytest.raises(TypeError, match="robot must be"):
            as_robot(wrong)


def test_a_definition_is_frozen():
    with pytest.raises(AttributeError):
        definition().size = 5


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("image", v) for v in (None, "a.png", PICTURE[0], PICTURE[..., :3], PICTURE[:0])),
        *(("image", v) for v in (PICTURE.astype(float), PICTURE.astype(bool), [[[1, 2, 3, 4]]])),
        ("name", None),
        *(("size", v) for v in (0, -1, np.nan, np.inf, "40", None, True, [1], np.ones(2), 1j)),
        *(("alignment", v) for v in (np.nan, -np.inf, "up", None, [1])),
        *(("centre", v) for v in (5, "ab", (1,), (1, 2, 3), (np.nan, 1), [[1, 2]])),
        *(("red", v) for v in (None, 5, "abc", [], EDGE[:2], np.zeros((3, 3)), {1: 2})),
        *(("red", v) for v in ([[1, 2], [2, 3], [3, 4]], [["1", "6"], ["3", "6"], ["3", "8"]])),
        *(("blue", v) for v in (np.full((3, 2), np.nan), [[1, 2], [3]], [["a", "b"]] * 3)),
        *(("outline", v) for v in (None, EDGE[:2], np.zeros((2, 2)), EDGE[0])),
    ],
    ids=lambda value: f"{value!r}"[:30].replace("\n", ""),
)
def test_a_wrong_value_is_named(name, value):
    role = {"red": "front", "blue": "back"}.get(name)
    said = rf"markers\['{role}'\]" if role else name
    with pytest.raises((TypeError, ValueError), match=rf"^{said} must "):
        definition(**{name: value})


def refused(**changed):
    with pytest.raises(ValueError, match="must") as caught:
        definition(**changed)
    return str(caught.value)


CALLED = {"red": "front marker (red)", "blue": "back marker (blue)"}


@pytest.mark.parametrize("name", ["outline", "red", "blue"])
def test_a_polygon_that_crosses_itself(name):
    bow_tie = {
        "outline": [[0, 0], [19, 9], [19, 0], [0, 9]],
        "red": [[14, 6], [17, 9], [17, 6], [14, 9]],
        "blue": [[2, 6], [5, 9], [5, 6], [2, 9]],
    }[name]
    (x, y), (x2, y2) = bow_tie[0], bow_tie[1]
    message = refused(**{name: bow_tie})
    assert message.startswith(f"{CALLED.get(name, name)} must not intersect itself: ")
    assert f"({x}, {y}) to ({x2}, {y2})" in message


NOTCHED = [[0, 0], [7, 0], [10, 8], [13, 0], [19, 0], [19, 9], [0, 9]]
FAR = [[100, 0], [110, 0], [110, 10], [105, 12], [100, 10]]
INSIDE = "{} must lie inside the outline: outside is "


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        *(
            (
                {name: [[8, 2], [11, 2], [11, -8]]},
                f"^{INSIDE.format(CALLED[name])}(11, -8), by up to 8.0 px$",
            )
            for name in ("red", "blue")
        ),
        ({"red": FAR}, "(100, 0), (110, 0), (110, 10) and 2 more, by up to 91.0 px"),
        (
            {"outline": NOTCHED, "centre": [3, 3], "red": [[5, 1], [16, 1], [16, 5], [5, 5]]},
            f"^{INSIDE.format(CALLED['red'])}(10, 1), by up to 2.",
        ),
        ({"centre": [9.5, 12]}, f"^{INSIDE.format('centre')}(9.5, 12), by up to 3.0 px$"),
        *(
            ({"outline": [[0, 0], [value, 0], [0, value]]}, "^outline must be a polygon")
            for value in (1e7, 1e200, -1e300)
        ),
    ],
)
def test_what_is_far_away_or_outside(changed, says):
    message = refused(**changed)
    assert re.search(says.replace("(", r"\(").replace(")", r"\)"), message), message


def test_an_outline_outside_of_the_picture():
    message = refused(outline=[[0, 0], [19, 0], [24.5, 5], [19, 9], [0, 9]])
    assert message == (
        "outline must lie within the image of 20 x 10 px: outside is (24.5, 5), by up to 5.0 px"
    )
    assert definition(outline=[[-1.4, 0], [20.4, 0], [20.4, 10.4], [-1.4, 10.4]]).radius > 0


BOTH = "front marker (red) and back marker (blue)"


def test_markers_that_overlap():
    message = refused(red=[[3, 4], [8, 4], [8, 9], [3, 9]])
    assert message.startswith(f"{BOTH} must not overlap: they do around (")
    inside = refused(red=[[0, 0], [19, 0], [19, 9], [0, 9]])
    assert inside.startswith(f"{BOTH} must not overlap")
    beside = definition(red=[[5, 6], [8, 6], [8, 9], [5, 9]])  # a common edge
    assert beside.marker_layout().distance == pytest.approx(6)


def test_all_that_is_wrong_is_said_at_once():
    message = refused(centre=[9, 30], red=[[2, 2], [4, 2], [4, -9]])
    assert "centre must" in message
    assert "front marker (red) must" in message


def test_a_corner_that_is_given_twice_is_one_corner():
    robot = definition(red=[RED[0], *RED, RED[0]])
    np.testing.assert_array_equal(robot.markers["front"], RED)


@pytest.mark.parametrize("points", [1001, 20_000])
def test_a_polygon_of_too_many_points(points):
    angle = 2 * np.pi * np.arange(points) / points
    message = refused(red=np.column_stack((np.cos(angle) + 9, np.sin(angle) + 4)))
    assert (
        message == f"markers['front'] must be a polygon of 3 to 1000 different points, got {points}"
    )


@pytest.mark.long
def test_the_shipped_robots_are_right():
    for name in robot_names():
        robot = load_robot(name)
        assert robot.name == name
        assert check_colors(robot).ok


def test_a_misspelt_value():
    with pytest.raises(TypeError, match="sizee"):
        definition(sizee=1)


@pytest.mark.parametrize("points", [[1, 2], None, [1, 2, 3], "ab", np.zeros((2, 3)), [[1, np.nan]]])
def test_to_robot_frame_refuses_other_shapes(points):
    with pytest.raises(ValueError, match="points must be"):
        definition().to_robot_frame(points)
