"""What users get wrong: every public entry point says which argument, and nothing crashes."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

import robsim
from robsim import (
    DriveAround,
    Estimate,
    Frame,
    Measurement,
    RecursiveLeastSquares,
    RobotModel,
    RobotParameters,
    Simulation,
    Spin,
    _core,
    find_blobs,
    locate,
)
from robsim.identification import least_squares, regression
from robsim.imaging import PlaneMap
from robsim.simulation import Renderer
from robsim.vision import MarkerLayout, rgb_to_yuv

NAN, INF = np.nan, np.inf
BEYOND_INT = (2**31, -(2**31) - 1, 2**63, 2**64, 10**30)

COLORS = robsim.load_colors()
IMAGE = np.full((8, 10, 3), 100, np.uint8)
SPRITE = np.full((4, 4, 4), 200, np.uint8)
SQUARE = np.array([[0, 0], [4, 0], [4, 4], [0, 4]], dtype=float)
POSE = (1.0, 2.0, 3.0)


def short(value):
    return re.sub(r" at 0x\w+|\s+", " ", repr(value))[:40]


def refuses(name, call, *arguments, **options):
    """The call raises an error of the right type that has the argument's name as a word."""
    with pytest.raises((TypeError, ValueError)) as caught:
        call(*arguments, **options)
    message = str(caught.value)
    assert re.search(rf"\b{re.escape(name)}(?!\w)", message), message
    return message


def refuses_in_words(name, call, *arguments, **options):
    """It does so in a sentence, not with pybind11's list of signatures."""
    message = refuses(name, call, *arguments, **options)
    assert "incompatible" not in message
    return message


# --- images

IMAGE_TAKERS = {
    "find_blobs": lambda image: find_blobs(image, COLORS),
    "rgb_to_yuv": rgb_to_yuv,
    "color_histograms": lambda image: robsim.vision.color_histograms(image, (0, 0, 0, 0)),
    "Frame": Frame,
    "UniformNoise.add": lambda image: robsim.UniformNoise(5).add(image, 1),
    "UniformNoise.add, off": lambda image: robsim.UniformNoise(0).add(image, 1),
}
takes_images = pytest.mark.parametrize("take", IMAGE_TAKERS.values(), ids=IMAGE_TAKERS)

NO_IMAGES = {
    "None": None,
    "text": "image.png",
    "bytes": b"\0" * 12,
    "a path": Path("image.png"),
    "a number": 3,
    "lists": IMAGE.tolist(),
    "lists of text": [[["a", "b", "c"]]],
    "a numpy scalar": np.uint8(3),
    "0 dimensions": np.array(3, np.uint8),
    "1 dimension": IMAGE[0, 0],
    "2 dimensions": IMAGE[..., 0],
    "4 dimensions": IMAGE[None],
    "0 channels": IMAGE[..., :0],
    "1 channel": IMAGE[..., :1],
    "4 channels": np.zeros((8, 10, 4), np.uint8),
    "channels first": np.zeros((3, 8, 10), np.uint8),
    "no rows": IMAGE[:0],
    "no columns": IMAGE[:, :0],
    "mirrored": IMAGE[:, ::-1],
    "BGR": IMAGE[..., ::-1],
    "every second column": IMAGE[:, ::2],
    "transposed": IMAGE.transpose(1, 0, 2),
    "Fortran order": np.asfortranarray(IMAGE),
    "RGB of RGBA": np.zeros((8, 10, 4), np.uint8)[..., :3],
    "one byte, broadcast": np.broadcast_to(np.uint8(0), (8, 10, 3)),
    "too high": np.broadcast_to(np.uint8(0), (65536, 2, 3)),
    "too wide": np.broadcast_to(np.uint8(0), (2, 65536, 3)),
    "higher than an int": np.broadcast_to(np.uint8(0), (2**32 + 8, 10, 3)),
    "bool": IMAGE.astype(bool),
    "objects": IMAGE.astype(object),
    "NaN": np.full((8, 10, 3), NAN),
    "a record": np.zeros((8, 10, 3), [("r", "u1")]),
    "time": np.zeros((8, 10, 3), "m8[s]"),
}


@takes_images
@pytest.mark.parametrize("image", NO_IMAGES.values(), ids=NO_IMAGES)
def test_what_is_no_image(take, image):
    refuses("image", take, image)


OTHER_DTYPES = (
    npst.integer_dtypes(endianness="?")
    | npst.unsigned_integer_dtypes(endianness="?")
    | npst.floating_dtypes(endianness="?")
    | npst.complex_number_dtypes()
    | npst.byte_string_dtypes(max_len=3)
    | npst.unicode_string_dtypes(max_len=3)
).filter(lambda dtype: dtype != np.uint8)


@pytest.mark.long
@takes_images
@settings(max_examples=40)
@given(dtype=OTHER_DTYPES)
def test_images_of_other_types(take, dtype):
    message = refuses("image", take, np.zeros((8, 10, 3), dtype))
    assert "uint8" in message
    assert "(8, 10, 3)" in message


@pytest.mark.long
@takes_images
@settings(max_examples=60)
@given(shape=npst.array_shapes(min_dims=0, max_dims=5, min_side=0, max_side=9))
def test_images_of_any_shape(take, shape):
    image = np.zeros(shape, np.uint8)
    if len(shape) == 3 and shape[2] == 3 and image.size:
        take(image)
    else:
        refuses("image", take, image)


STEPS = st.sampled_from([-3, -2, -1, 1, 2, 3])


@pytest.mark.long
@takes_images
@settings(max_examples=60)
@given(rows=STEPS, columns=STEPS, channels=STEPS, fortran=st.booleans())
def test_images_of_any_stride(take, rows, columns, channels, fortran):
    whole = np.zeros((12, 12, 9), np.uint8, order="F" if fortran else "C")
    view = whole[::rows, ::columns, ::channels][:, :, :3]
    assume(view.shape[2] == 3)
    if view.strides[1:] == (3, 1):
        take(view)
    else:
        assert "ascontiguousarray(image)" in refuses("image", take, view)


def test_a_frame_is_an_image_to_find_blobs_only():
    assert find_blobs(Frame(IMAGE), COLORS) == {"red": [], "blue": []}
    refuses("image", rgb_to_yuv, Frame(IMAGE))
    refuses("image", Frame, Frame(IMAGE))


def blobs_in(image, **options):
    found = find_blobs(image, COLORS, minimum_area=1, **options)
    return {
        color: [(b.area, *b.centroid, b.bounding_box, b.at_border) for b in blobs]
        for color, blobs in found.items()
    }


VIEWS = {
    "every second row": lambda image: image[::2],
    "upside down": lambda image: image[::-1],
    "every third row from below": lambda image: image[::-3],
    "a part": lambda image: image[1:-2, 1:-1],
    "one column": lambda image: image[:, 3:4],
    "one row": lambda image: image[2:3],
    "one pixel": lambda image: image[2:3, 3:4],
    "a row, repeated": lambda image: np.broadcast_to(image[:1], image.shape),
    "read-only": lambda image: np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape),
    "a memory map's kind": lambda image: image.view(np.memmap),
}


@pytest.mark.long
@pytest.mark.parametrize("view", VIEWS.values(), ids=VIEWS)
@settings(max_examples=30)
@given(width=st.integers(5, 41), height=st.integers(5, 20), seed=st.integers(0, 2**32))
def test_rows_may_lie_anywhere_in_memory(view, width, height, seed):
    palette = np.array([[220, 30, 30], [30, 60, 220], [100, 100, 100]], np.uint8)
    image = palette[np.random.default_rng(seed).integers(0, 3, (height, width))]
    seen = view(image)
    copy = np.array(seen, order="C")
    blobs = blobs_in(seen)
    assert blobs == blobs_in(copy)
    assert sum(map(len, blobs.values())) > 0 or (copy == 100).all(axis=2).any()
    np.testing.assert_array_equal(rgb_to_yuv(seen), rgb_to_yuv(copy))
    np.testing.assert_array_equal(Frame(seen).image, copy)
    noise = robsim.GaussianNoise(20)
    np.testing.assert_array_equal(noise.add(seen, 1), noise.add(copy, 1))


def test_a_blob_upside_down_is_upside_down():
    image = np.full((9, 7, 3), 100, np.uint8)
    image[1:3, 2:6] = (220, 30, 30)
    assert blobs_in(image)["red"] == [(8, 3.5, 1.5, (2, 1, 5, 2), False)]
    assert blobs_in(image[::-1])["red"] == [(8, 3.5, 6.5, (2, 6, 5, 7), False)]


@takes_images
def test_a_long_text_in_other_letters(take):
    refuses("image", take, "ä" * 100)


# --- the other arguments of vision and imaging

NO_INTS = (None, "5", 1.5, NAN, 1j, [1])


@pytest.mark.parametrize("name", ["minimum_area", "maximum_count"])
@pytest.mark.parametrize("value", [0, -1, *NO_INTS[1:], *BEYOND_INT[2:]], ids=short)
def test_find_blobs_options(name, value):
    refuses(name, find_blobs, IMAGE, COLORS, **{name: value})


@pytest.mark.parametrize(
    "colors",
    [None, 5, "red", ["red"], [None], COLORS[0], b"x", {"red": COLORS[0]}, [COLORS[0]] * 2],
    ids=short,
)
def test_find_blobs_colors(colors):
    refuses("colors", find_blobs, IMAGE, colors)


def test_misspelt_arguments():
    refuses("min_area", find_blobs, IMAGE, COLORS, min_area=3)
    refuses("time", Frame, IMAGE, time=3)
    refuses("mas", RobotParameters, mas=3)
    refuses("lambda_", RecursiveLeastSquares, 5, lambda_=1)
    refuses("tolerance", MarkerLayout, 43, 14, tolerance=1)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("t", value) for value in (None, "now", 1j, [1], NAN, INF)),
        *(("index", value) for value in (-1, *NO_INTS, *BEYOND_INT[2:])),
        *(("plane_map", value) for value in (None, np.eye(3), "identity")),
    ],
    ids=short,
)
def test_frame_options(name, value):
    refuses(name, Frame, IMAGE, **{name: value})


@pytest.mark.parametrize(
    ("kind", "percent", "name"),
    [
        *(("uniform", value, "percent") for value in (None, "40", 1j, [1], -1, NAN, INF)),
        *((value, 5, "kind") for value in (None, 5, ["none"], "white", "")),
        ("none", -1, "percent"),
    ],
)
def test_visual_noise(kind, percent, name):
    refuses(name, _core.VisualNoise, kind, percent)


@pytest.mark.parametrize("percent", [5e-324, 1e-300, 1e308])
@pytest.mark.parametrize("kind", ["uniform", "gaussian"])
def test_extreme_noise_stays_within_the_picture(kind, percent):
    noisy = _core.VisualNoise(kind, percent).add(IMAGE, 1)
    assert noisy.shape == IMAGE.shape
    assert set(np.unique(noisy)) == ({100} if percent < 1 else {0, 255})


@pytest.mark.parametrize("name", ["seed", "index"])
@pytest.mark.parametrize("value", [-1, 2**64, *NO_INTS], ids=short)
def test_seeds_of_noise(name, value):
    options = {"seed": 1} | {name: value}
    refuses(name, robsim.UniformNoise(5).add, IMAGE, **options)


@pytest.mark.parametrize(
    ("blobs", "markers", "plane_map", "name"),
    [
        *(
            (value, MarkerLayout(43, 14), PlaneMap(), "blobs")
            for value in (None, [], "red", {1: []})
        ),
        *(
            (value, MarkerLayout(43, 14), PlaneMap(), "blobs")
            for value in ({"red": [1]}, {"red": None})
        ),
        *(({}, value, PlaneMap(), "markers") for value in (None, (43, 14), "lab")),
        *(
            ({}, MarkerLayout(43, 14), value, "plane_map")
            for value in (None, np.eye(3), "identity")
        ),
    ],
    ids=short,
)
def test_locate(blobs, markers, plane_map, name):
    refuses(name, locate, blobs, markers, plane_map)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("distance", value) for value in (0, 1e-4, -43, NAN, INF, None, "43", 1j)),
        *(("offset", value) for value in (NAN, INF, -INF, None, "14")),
        *(("distance_tolerance", value) for value in (0, -1, NAN, None, "x")),
        *(("area_tolerance", value) for value in (1, 0.5, 0, -1, NAN, None, "x")),
    ],
)
def test_locator(name, value):
    options = {"distance": 43, "offset": 14} | {name: value}
    refuses(name, MarkerLayout, **options)


NO_POLYGONS = {
    "None": None,
    "a number": 5,
    "text": "abc",
    "lists of text": [["a", "b"]] * 3,
    "empty": [],
    "2 points": SQUARE[:2],
    "a line": [[0, 0], [1, 1], [2, 2]],
    "one point": np.zeros((4, 2)),
    "a bow tie": [[0, 0], [4, 4], [4, 0], [0, 4]],
    "ragged": [[1, 2], [3], [4, 5]],
    "3 coordinates": np.ones((4, 3)),
    "3 dimensions": SQUARE[None],
    "NaN": SQUARE * NAN,
    "infinite": [[0, 0], [INF, 0], [0, 1]],
    "complex": [[1j, 0], [1, 0], [1, 1]],
    "a set": {1, 2, 3},
}


@pytest.mark.parametrize("polygon", NO_POLYGONS.values(), ids=NO_POLYGONS)
@pytest.mark.parametrize("name", ["red", "blue"])
def test_what_is_no_polygon(name, polygon):
    markers = {"red": np.add(SQUARE, (0, 50)), "blue": SQUARE} | {name: polygon}
    refuses(name, MarkerLayout.from_markers, **markers)


@pytest.mark.parametrize("polygon", [SQUARE * 1e160, SQUARE + 1e300], ids=["large", "far"])
def test_polygons_beyond_all_bounds(polygon):
    with pytest.raises(ValueError, match=r"red|distance"):
        MarkerLayout.from_markers(polygon, SQUARE)


def test_markers_in_one_place():
    with pytest.raises(ValueError, match="distance between the markers"):
        MarkerLayout.from_markers(SQUARE, SQUARE)


# --- plane map


@pytest.mark.parametrize(
    "matrix",
    [
        *(None, 5, "abc", {1: 2}, [["a"] * 3] * 3, [[1j, 0, 0], [0, 1, 0], [0, 0, 1]]),
        *(np.eye(2), np.eye(4), np.zeros(9), np.zeros((1, 3, 3)), np.zeros((3, 3))),
        *(np.ones((3, 3)), np.diag([1, 1, 0]), np.eye(3) * NAN, np.full((3, 3), INF)),
    ],
    ids=short,
)
def test_what_is_no_homography(matrix):
    refuses("matrix", PlaneMap, matrix)


@pytest.mark.parametrize("factor", [1e-5, -2, 1e200])
def test_a_homography_is_the_same_times_any_number(factor):
    np.testing.assert_allclose(PlaneMap(np.eye(3) * factor).to_world((3, 4)), (3, 4))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("resolution", v) for v in (None, 5, "ab", (1,), (1, 2, 3), (0, 1), (1, -1), (1.5, 1))),
        *(("resolution", v) for v in ((NAN, 1), (2**31, 1), (None, 1))),
        *(("area", v) for v in (None, 5, "12", (1,), (0, 1), (1, -1), (NAN, 1), (INF, 1))),
        *(("area", v) for v in (("a", 1), (1e-9, 1e-9))),
    ],
    ids=short,
)
def test_plane_map_of_a_camera(name, value):
    options = {"resolution": (1000, 1000), "area": (1, 1)} | {name: value}
    refuses(name, PlaneMap.scaled, *options.values())


map_points = pytest.mark.parametrize(
    ("call", "name"), [(PlaneMap().to_world, "pixels"), (PlaneMap().to_pixel, "positions")]
)


@map_points
@pytest.mark.parametrize(
    "points",
    [
        *(None, 5, 1.5, "ab", "a", b"ab", [], [1], [1, 2, 3], [[1, 2], [3]], {1, 2}),
        *(["a", "b"], [["a", "b"]], [NAN, 1], [[INF, 1]], [None, None], [1j, 2], [object(), 1]),
        *(np.array(1.0), np.zeros((2, 3)), np.zeros((2, 2, 2)), np.zeros((2, 0))),
        *((value for value in (1, 2)), {0: 1, 1: 2}, {"u": 1, "v": 2}),
    ],
    ids=short,
)
def test_points_to_map(call, name, points):
    refuses(name, call, points)


@map_points
@settings(max_examples=60)
@given(shape=npst.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=4))
def test_points_of_any_shape(call, name, shape):
    if shape == (2,) or (len(shape) == 2 and shape[1] == 2):
        assert call(np.zeros(shape)).shape == shape
    else:
        refuses(name, call, np.zeros(shape))


# --- poses

MODEL = RobotModel()

POSE_TAKERS = {
    "pose_1": lambda pose: MODEL.predict(pose, POSE, (0, 0)),
    "pose_2": lambda pose: MODEL.predict(POSE, pose, (0, 0)),
    "pose of Measurement": Measurement,
    "pose of Estimate": lambda pose: Estimate(pose, np.eye(3)),
    "pose of render": lambda pose: small_renderer().render(pose),
    "start": lambda pose: Simulation(start=pose),
}
takes_poses = pytest.mark.parametrize(
    ("name", "take"), [(name.split()[0], take) for name, take in POSE_TAKERS.items()]
)

NO_POSES = {
    "text": "abc",
    "bytes": b"abc",
    "a number": 5.0,
    "2 numbers": (1, 2),
    "4 numbers": (1, 2, 3, 4),
    "a row": [POSE],
    "nothing": [],
    "letters": ["a", "b", "c"],
    "ragged": [[1], [2, 3], 4],
    "NaN": (NAN, 0, 0),
    "infinite": (0, -INF, 0),
    "None inside": (None, 0, 0),
    "complex": (1j, 0, 0),
    "a dict": {0: 1, 1: 2, 2: 3},
    "a set": {1, 2, 3},
    "a generator": (value for value in POSE),
    "an object": object(),
}


@takes_poses
@pytest.mark.parametrize("pose", NO_POSES.values(), ids=NO_POSES)
def test_what_is_no_pose(name, take, pose):
    refuses(name, take, pose)


@pytest.mark.parametrize(
    "pose",
    [
        *(["1", "2", "3"], np.array(["1", "2", "3"]), np.array([1 + 1j, 0, 0]), [object()] * 3),
        *(np.array([1, 2, 3], "m8[s]"), np.array(["2020-01-01"] * 3, "M8[D]")),
    ],
    ids=short,
)
def test_arrays_that_are_no_numbers(pose):
    with pytest.raises(TypeError, match=r"\bpose\b"):
        Measurement(pose)


@pytest.mark.long
@takes_poses
@settings(max_examples=40, deadline=None)
@given(
    shape=npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4).filter(
        lambda shape: shape != (3,)
    )
)
def test_poses_of_other_shapes(name, take, shape):
    refuses(name, take, np.zeros(shape))


@given(pose=npst.arrays(float, 3, elements=st.floats(allow_subnormal=True)))
def test_a_pose_of_floats_is_kept_or_refused(pose):
    if np.isfinite(pose).all():
        x, y, heading = Measurement(pose).pose
        assert (x, y) == (pose[0], pose[1])
        assert -np.pi < heading <= np.pi
    else:
        assert "finite" in refuses("pose", Measurement, pose)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("pose", lambda: Measurement((10**400, 0, 0))),
        ("pixels", lambda: PlaneMap().to_world((10**400, 0))),
        ("red", lambda: MarkerLayout.from_markers([[10**400, 0], [1, 0], [1, 1]], SQUARE)),
        ("y", lambda: RecursiveLeastSquares(2).update([1, 2], 10**400)),
        ("start", lambda: Simulation(start=(10**400, 0, 0))),
    ],
)
def test_ints_beyond_all_floats(name, call):
    refuses(name, call)


def test_poses_of_any_layout_are_taken():
    for pose in (
        list(POSE),
        np.array(POSE, dtype=">f8"),
        np.array(POSE, dtype=np.float32),
        np.array([3.0, 2.0, 1.0])[::-1],
        np.arange(9.0).reshape(3, 3, order="F")[0] * 0 + POSE,
        np.array([1, 2, 3]),
        range(1, 4),
    ):
        np.testing.assert_array_equal(Measurement(pose).pose, POSE)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("covariance", value) for value in (None, 5, "abc", np.eye(2), np.eye(3) * NAN)),
        *(("covariance", value) for value in (np.zeros(9), [["a"] * 3] * 3)),
        *(("state", value) for value in (5, "abc", np.eye(2), [NAN], [None], ["a"])),
    ],
    ids=short,
)
def test_estimate(name, value):
    options = {"covariance": np.eye(3)} | {name: value}
    refuses(name, Estimate, POSE, **options)


# --- renderer


def small_renderer(**changed):
    options = {
        "floor": (IMAGE, IMAGE),
        "home": (IMAGE, IMAGE),
        "shadow_left": 6,
        "shadow_factor": 0.8,
        "sprite": SPRITE,
        "centre": (1.5, 1.5),
        "unit": 1.0,
        "alignment": 0.0,
        "headings": 4,
        "area": (10, 8),
    }
    return Renderer(**(options | changed))


FLOAT_IMAGE = IMAGE.astype(float)
NO_PAIRS = [None, "ab", 5, IMAGE, (IMAGE,), (IMAGE,) * 3, (IMAGE, None), (IMAGE[:4], IMAGE)]
NO_PAIRS += [(FLOAT_IMAGE, IMAGE), (IMAGE[:, ::-1], IMAGE)]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, value) for name in ("floor", "home") for value in NO_PAIRS),
        *(("shadow_left", v) for v in (*NO_INTS, *BEYOND_INT)),
        *(("shadow_factor", v) for v in (None, "x", -1, NAN, INF, 1e308)),
        *(("sprite", v) for v in (None, "x", SPRITE.tolist(), SPRITE[0], SPRITE[:0])),
        *(("sprite", v) for v in (SPRITE[..., :3], SPRITE.astype(float), SPRITE.astype(">u2"))),
        *(("sprite", v) for v in map(SPRITE.astype, (object, bool, np.int8))),
        *(("centre", v) for v in (None, "ab", (1,), (1, 2, 3), (NAN, 1), (INF, 1), ["a", "b"])),
        ("centre", (1e9, 0)),
        *(("unit", v) for v in (None, "x", 0, -1, NAN, INF, 1e9)),
        *(("alignment", v) for v in (None, "x", NAN, INF)),
        *(("headings", v) for v in (-1, *NO_INTS, *BEYOND_INT)),
        *(("area", v) for v in (None, "ab", (1,), (1, 2, 3), (0, 1), (1, -1), (1.5, 1))),
        ("area", (2**31, 1)),
    ],
    ids=short,
)
def test_renderer(name, value):
    refuses(name, small_renderer, **{name: value})


def test_renderer_arguments_are_all_needed():
    with pytest.raises(TypeError, match="floor"):
        Renderer()


@pytest.mark.parametrize(
    "pan", [None, 5, "ab", (1,), (1, 2, 3), (1.5, 1), (NAN, 1), (2**31, 0), (0, -(2**31) - 1)]
)
def test_pan(pan):
    refuses("pan", small_renderer().render, (5, 4, 0), pan)


INT = st.integers(-(2**31), 2**31 - 1) | st.sampled_from([-(2**31), 2**31 - 1, -1, 0, 7])


@pytest.mark.long
@pytest.mark.parametrize("headings", [0, 4])
@settings(max_examples=100, deadline=None)
@given(
    x=st.floats(allow_nan=False, allow_infinity=False),
    y=st.floats(allow_nan=False, allow_infinity=False),
    heading=st.floats(allow_nan=False, allow_infinity=False),
    pan=st.tuples(INT, INT),
)
def test_any_finite_pose_and_view_can_be_drawn(headings, x, y, heading, pan):
    image = small_renderer(headings=headings).render((x, y, heading), pan)
    assert image.shape == IMAGE.shape
    if abs(x) > 100 and pan == (0, 0):
        np.testing.assert_array_equal(image, IMAGE)


# --- model


@pytest.mark.parametrize("name", ["mass", "inertia", "wheel_radius", "wheel_base", "dt"])
@pytest.mark.parametrize("value", [0, -0.0, -1, NAN, INF, -INF, None, "1", 1j, [1], 10**400])
def test_parameters_that_must_be_positive(name, value):
    refuses(name, RobotParameters, **{name: value})


@pytest.mark.parametrize("name", ["linear_friction", "angular_friction"])
@pytest.mark.parametrize("value", [-1, -5e-324, NAN, INF, None, "1", [1]])
def test_friction(name, value):
    refuses(name, RobotParameters, **{name: value})


@pytest.mark.parametrize("name", ["motor_gain", "motor_offset"])
@pytest.mark.parametrize(
    "value",
    [
        *(None, 1, "12", "ab", (), (1,), (1, 2, 3), (NAN, 1), (1, INF), (1, None), (1, 1j)),
        {1, 2},  # which is left, which right?
    ],
)
def test_motors(name, value):
    refuses(name, RobotParameters, **{name: value})


@pytest.mark.parametrize(
    ("parameters", "name"),
    [
        ({"linear_friction": 0}, "linear_friction"),
        ({"angular_friction": 0}, "angular_friction"),
        ({"mass": 1e308}, "mass"),
        ({"inertia": 1e308}, "inertia"),
        ({"wheel_radius": 5e-324}, "wheel_radius"),
        ({"dt": 1e308}, "dt"),
        ({"motor_gain": (1e308, 0)}, "motor_gain"),
    ],
)
def test_models_that_are_not_stable(parameters, name):
    refuses(name, RobotModel, RobotParameters(**parameters))


@pytest.mark.parametrize("parameters", [None, 5, "lab", MODEL, MODEL.theta])
def test_robot_model(parameters):
    refuses("parameters", RobotModel, parameters)


THETA = MODEL.theta


def with_entry(row, column, value):
    theta = np.array(THETA)
    theta[row, column] = value
    return theta


@pytest.mark.parametrize(
    ("theta", "name"),
    [
        *((value, "theta") for value in (None, 5, "abc", THETA.T, THETA[0], THETA * NAN, [])),
        *((value, "theta") for value in (THETA[None], [["a"] * 5] * 3, with_entry(1, 2, INF))),
        *((with_entry(0, 0, value), "a1X") for value in (0, 2, -1)),
        (with_entry(1, 0, 2), "a1Y"),
        (with_entry(2, 0, 2.5), "a1P"),
        (with_entry(0, 1, 50), "a2X"),
    ],
    ids=short,
)
def test_from_theta(theta, name):
    refuses(name, RobotModel.from_theta, theta)


@pytest.mark.parametrize("dt", [0, -1, NAN, INF, None, "0.2", [1]])
def test_from_theta_dt(dt):
    refuses("dt", RobotModel.from_theta, THETA, dt=dt)


@pytest.mark.parametrize(
    "u", [None, 5, "ab", (1,), (1, 2, 3), (NAN, 1), (1, INF), [[1, 2]], (None, 1), ["a", "b"]]
)
def test_inputs(u):
    refuses("u", MODEL.predict, POSE, POSE, u)


POSES, INPUTS = np.zeros((4, 3)), np.zeros((4, 2))


@pytest.mark.parametrize(
    ("poses", "u", "name"),
    [
        *((v, INPUTS, "poses") for v in (None, "abc", 5, [], POSES[0], POSES[:, :2], POSES * NAN)),
        *((v, INPUTS, "poses") for v in (POSES[None], [["a"] * 3] * 4, POSES.T)),
        *((POSES, v, "u") for v in (None, "abc", 5, [], INPUTS[:3], INPUTS[0], INPUTS.T)),
        *((POSES, v, "u") for v in (np.full((4, 2), INF), INPUTS[None], [["a"] * 2] * 4)),
    ],
    ids=short,
)
def test_regression_samples(poses, u, name):
    refuses(name, regression, poses, u)


@given(rows=st.integers(0, 6), others=st.integers(0, 6))
def test_as_many_inputs_as_poses(rows, others):
    if rows == others:
        phi, y = regression(np.zeros((rows, 3)), np.zeros((rows, 2)))
        assert phi.shape == (max(rows - 2, 0), 3, 5)
        assert y.shape == (max(rows - 2, 0), 3)
    else:
        refuses("u", regression, np.zeros((rows, 3)), np.zeros((others, 2)))


# --- estimation


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, v) for name in ("parameters", "filters") for v in (0, -1, *NO_INTS, *BEYOND_INT)),
        *(("forgetting", v) for v in (0, -0.0, -1, 1.000001, NAN, INF, None, "1")),
        *(("initial_covariance", v) for v in (0, -1, NAN, INF, None, "1")),
    ],
    ids=short,
)
def test_recursive_least_squares(name, value):
    options = {"parameters": 5} | {name: value}
    refuses(name, RecursiveLeastSquares, **options)


def test_counts_are_shown_as_counts():
    assert refuses("parameters", RecursiveLeastSquares, 0).endswith("got 0")


NO_SAMPLES = [
    *((v, 1, "phi") for v in (None, 5, "ab", [1], [1, 2, 3], [[1, 2, 3]], [INF, 1])),
    *((v, 1, "phi") for v in (["a", "b"], [None, 1], [1j, 1], [[[1, 2]]])),
    *(([1, 2], v, "y") for v in (None, "1", [1], [1, 2], INF, 1j)),
    *(([[1, 2]], v, "y") for v in (1, [1, 2], [[1]], [INF], [None])),
]


@pytest.mark.parametrize(("phi", "y", "name"), NO_SAMPLES, ids=short)
def test_update_of_one_filter_changes_nothing(phi, y, name):
    filters = RecursiveLeastSquares(2, forgetting=0.9)
    filters.update([1, 2], 3)
    theta, P = filters.theta, filters.P
    refuses(name, filters.update, phi, y)
    np.testing.assert_array_equal(filters.theta, theta)
    np.testing.assert_array_equal(filters.P, P)


@settings(max_examples=60)
@given(
    phi=npst.array_shapes(min_dims=0, max_dims=4, max_side=4),
    y=npst.array_shapes(min_dims=0, max_dims=2, max_side=4),
)
def test_update_of_three_filters(phi, y):
    filters = RecursiveLeastSquares(2, n_filters=3)
    fits = phi[-2:] == (3, 2) and len(phi) <= 3
    if fits and y == phi[:-1]:
        assert filters.update(np.ones(phi), np.ones(y)).shape == phi
    else:
        name = "y" if fits else "phi"
        refuses(name, filters.update, np.ones(phi), np.ones(y))
        np.testing.assert_array_equal(filters.theta, np.zeros((3, 2)))


@pytest.mark.parametrize("phi", [(1e200, 1e200), (1e308, 0)])
def test_a_sample_that_overflows_changes_nothing(phi):
    filters = RecursiveLeastSquares(2)
    with pytest.raises((ValueError, OverflowError)):
        filters.update(phi, 1)
    assert np.isfinite(filters.theta).all()


@pytest.mark.parametrize(
    ("phi", "y", "name"),
    [
        *((v, [1, 2], "phi") for v in (None, 5, "ab", [1, 2], np.ones((1, 2, 2)), [["a"] * 2] * 2)),
        *((v, [1, 2], "phi") for v in (np.eye(2) * NAN, np.full((2, 2), INF), np.ones((2, 0)))),
        *((np.eye(2), v, "y") for v in (None, 5, "ab", [1], [1, 2, 3], [[1], [2]], [NAN, 1])),
        *((np.ones((0, 2)), [], "phi"), (np.eye(2) * 1e200, [1, 2], "phi")),
        (np.eye(2), [1e200, 0], "y"),
    ],
    ids=short,
)
def test_least_squares(phi, y, name):
    refuses(name, least_squares, phi, y)


def test_least_squares_of_large_numbers():
    fit = least_squares(np.eye(2) * 1e100, [1e100, 1e99])
    np.testing.assert_allclose(fit.theta, [1, 0.1])


# --- controllers


@pytest.mark.parametrize("voltage", [NAN, INF, None, "x", 1j])
def test_spin(voltage):
    refuses("voltage", Spin, voltage)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *((name, value) for name in ("low", "high") for value in (NAN, INF, None, "x")),
        *(("hold", value) for value in (0, -1, *NO_INTS, *BEYOND_INT)),
        ("low", 2),
        ("high", -1),
    ],
    ids=short,
)
def test_drive_around(name, value):
    refuses(name, DriveAround, **{name: value})


# --- simulation

WRONG_SIZES = (5, "ab", "80x80", (100,), (1, 2, 3), (0, 0), (-5, 50), (15, 16), (16385, 16))
WRONG_SIZES += ((NAN, 100), (100.0, 100), ("a", "b"), (True, 100), (2**40, 100), (None, 100))

WRONG_OPTIONS = {
    "robot": (5, "no such robot", "", b"lab", ["lab"], {}),
    "area": WRONG_SIZES,
    "resolution": WRONG_SIZES,
    "boundary": ("wall", "", "Bounce", None, 5, True, ["bounce"], b"bounce"),
    "headings": ("36", 1.5, NAN, True, 0, -1, 3601, 2**70),
    "start": ("middle", "", "Random", (NAN, 0, 0), (1, 2), 5, True, {}, (1e300, 1, 1), (-1, 9, 0)),
    "seed": (-1, 1.5, NAN, "1", True, [1], (1, 2), np.int64(-1), np.random.PCG64(1), object()),
    "colors": (5, 1.5, COLORS[0], [1], [None], ["red"], b"red", {"red": 1}, [COLORS[0]] * 2),
    "markers": ("no such robot", 5, (43, 14), True),
    "identify_from": ("camera", "", "Truth", 5, True, ["truth"], b"measurement"),
}


@pytest.mark.parametrize(
    ("name", "value"),
    [(name, value) for name, values in WRONG_OPTIONS.items() for value in values],
    ids=short,
)
def test_wrong_options(name, value):
    refuses_in_words(name, Simulation, **{name: value})


def test_a_start_far_out_of_an_unlimited_area():
    Simulation(boundary="unlimited", start=(-1e6, 5, 0))
    refuses("start", Simulation, boundary="unlimited", start=(-1.1e6, 5, 0))


@pytest.mark.parametrize("kind", [robsim.UniformNoise, robsim.GaussianNoise])
@pytest.mark.parametrize(
    "percent",
    [None, -1, -5e-324, NAN, INF, "40", [1], 1j, True],
)
def test_noise_percent(kind, percent):
    refuses_in_words("percent", kind, percent)


@pytest.mark.parametrize("value", ["gaussian", "", 40, True, ["none"], robsim.GaussianNoise])
def test_noise(value):
    assert "GaussianNoise(40)" in refuses("noise", Simulation, noise=value)


@pytest.mark.parametrize("value", [0.2, "much", True, (0.2, 5), robsim.Dropout])
def test_dropout(value):
    assert "Dropout(0.2)" in refuses("dropout", Simulation, dropout=value)


@pytest.mark.parametrize("value", [np.int64(36), pytest.param(np.uint8(36), id="uint8")])
def test_numpy_ints_are_ints(value):
    Simulation(headings=value, area=(np.int64(100), np.int64(100)))


def test_missing_color_and_picture_files(tmp_path):
    missing = tmp_path / "missing"
    with pytest.raises(FileNotFoundError, match="missing"):
        Simulation(colors=missing)
    with pytest.raises(FileNotFoundError, match="missing"):
        Simulation(background=missing, area=(200, 200))


@pytest.mark.parametrize("name", ["areas", "Noise", "identify", "control_", "callback"])
def test_misspelt_options(name):
    with pytest.raises(TypeError, match=name):
        Simulation(**{name: None})


def test_options_are_keywords():
    with pytest.raises(TypeError, match="positional"):
        Simulation("lab")


def test_a_misspelt_slot():
    sim = Simulation()
    with pytest.raises(AttributeError, match="contrl"):
        sim.contrl = lambda step: (0, 0)


NO_BACKGROUNDS = {
    "a number": 5,
    "lists": IMAGE.tolist(),
    "bytes": b"x",
    "float": FLOAT_IMAGE,
    "int8": IMAGE.astype(np.int8),
    "bool": IMAGE.astype(bool),
    "grey": IMAGE[..., 0],
    "RGBA": np.zeros((8, 10, 4), np.uint8),
    "empty": IMAGE[:0],
}


@pytest.mark.parametrize("background", NO_BACKGROUNDS.values(), ids=NO_BACKGROUNDS)
def test_backgrounds(background):
    refuses("background", Simulation, background=background, area=(200, 200))


def test_a_broken_background_is_refused_before_the_run(tmp_path):
    (tmp_path / "floor.png").write_bytes(b"no picture")
    with pytest.raises(ValueError, match=r"floor\.png"):
        Simulation(background=tmp_path / "floor.png", area=(200, 200))


def test_backgrounds_of_any_layout_are_taken():
    for background in (IMAGE[:, ::-1], np.asfortranarray(IMAGE), IMAGE[::2], IMAGE[..., ::-1]):
        sim = Simulation(background=background, area=(200, 200), start=(199, 199, 0), seed=1)
        assert sim.frame.image[20, 20].tolist() == [100, 100, 100]


SLOTS = ("define_model", "init_parameter_estimator", "adjust_background", "evaluate_model")
SLOTS += ("estimate_parameters", "measure", "estimate_state", "control")
MAY_BE_ON = ("estimate_parameters", "measure")
MAY_BE_OFF = (*MAY_BE_ON, "estimate_state")


@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("value", [0, 1, "control.py", (0, 1), [], {}, Ellipsis], ids=short)
def test_callbacks_must_be_callable(slot, value):
    assert "callable" in refuses(slot, Simulation, **{slot: value})
    sim = Simulation()
    assert "callable" in refuses(slot, setattr, sim, slot, value)
    assert "callable" in refuses(slot, getattr(sim, slot), value)


@pytest.mark.parametrize("slot", SLOTS)
def test_true_and_false_where_they_mean_something(slot):
    for value, slots in ((True, MAY_BE_ON), (False, MAY_BE_OFF)):
        if slot in slots:
            Simulation(**{slot: value})
        else:
            refuses(slot, Simulation, **{slot: value})


@pytest.fixture(scope="module")
def sim():
    return Simulation(area=(200, 200), seed=1)


@pytest.mark.parametrize("steps", [-1, -(2**63), 2**70, None, "3", 1.5, NAN, [3]], ids=short)
def test_steps(sim, steps):
    refuses_in_words("steps", sim.run, steps)
    assert len(sim.trace) == 0


@pytest.mark.parametrize("steps", [-1, "3", 1.5], ids=short)
def test_steps_with_a_progress_bar(sim, steps):
    refuses_in_words("steps", sim.run, steps, progress=True)


def test_no_steps_are_no_steps(sim):
    assert len(sim.run(0)) == 0


# --- seeds


@pytest.mark.long
@given(st.integers(0, 2**300))
def test_any_natural_number_is_a_seed(seed):
    trace = Simulation(area=(200, 200), seed=seed).trace
    assert trace.info.seed == {"entropy": seed, "spawn_key": []}
