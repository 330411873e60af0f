"""What is no option of the detection, no blob and no marker is refused in its name."""

import numpy as np
import pytest

import robsim
from refusals import (
    BEYOND_INT,
    IMAGE,
    NAN,
    NO_INT,
    NO_MAP,
    NO_POLYGON,
    NOT_FINITE,
    SQUARE,
    Refusal,
    options,
    refusals,
)
from robsim import find_blobs, locate
from robsim.imaging import PlaneMap
from robsim.vision import Blob, MarkerLayout

COLORS = robsim.load_colors()
MARKERS = MarkerLayout(43, 14)
NO_COLORS = (None, 5, "red", ["red"], [None], COLORS[0], b"x", {"red": COLORS[0]}, [COLORS[0]] * 2)


@refusals(
    options(
        find_blobs,
        {"minimum_area maximum_count": (0, -1, *NO_INT[1:], *BEYOND_INT[2:]), "min_area": (3,)},
        IMAGE,
        COLORS,
    ),
    Refusal(lambda value: find_blobs(IMAGE, value), "colors", NO_COLORS),
    Refusal(
        lambda value: locate(value, MARKERS, PlaneMap()),
        "blobs",
        (None, [], "red", {1: []}, {"red": [1]}, {"red": None}),
    ),
    Refusal(lambda value: locate({}, value, PlaneMap()), "markers", (None, (43, 14), "lab")),
    Refusal(lambda value: locate({}, MARKERS, value), "plane_map", NO_MAP[1:]),
)
def test_detection(refusal):
    refusal()


@refusals(
    options(
        MarkerLayout,
        {
            "distance": (0, 1e-4, -43, *NOT_FINITE, None, "43", 1j),
            "offset": (*NOT_FINITE, None, "14"),
            "distance_tolerance": (0, -1, NAN, None, "x"),
            "area_tolerance": (1, 0.5, 0, -1, NAN, None, "x"),
        },
        **{"distance": 43, "offset": 14},
    ),
    options(MarkerLayout, {"tolerance": (1,)}, 43, 14),
    options(
        MarkerLayout.from_markers,
        {
            "markers": (
                *({"right": polygon, "left": SQUARE} for polygon in NO_POLYGON),
                *({"right": np.add(SQUARE, (0, 50)), "left": polygon} for polygon in NO_POLYGON),
                {"right": [[10**400, 0], [1, 0], [1, 1]], "left": SQUARE},
                {"right": np.add(SQUARE, (0, 50))},
                {"right": np.add(SQUARE, (0, 50)), "back": SQUARE},
                (np.add(SQUARE, (0, 50)), SQUARE),
            )
        },
        **{"markers": {"right": np.add(SQUARE, (0, 50)), "left": SQUARE}},
    ),
)
def test_markers(refusal):
    refusal()


CROSSED = np.array(((0, 0), (10, 10.001), (10, 0), (0, 10)))
ROUND = 9 * np.column_stack([f(np.linspace(0, 2 * np.pi, 1001)) for f in (np.cos, np.sin)])


@pytest.mark.parametrize(
    ("polygon", "words"),
    [
        (SQUARE * 1e160, "of points within 1e9 px"),
        (SQUARE + 1e300, "of points within 1e9 px"),
        (SQUARE * 1e-160, "with an area"),
        (CROSSED, "whose sides do not cross"),
        (ROUND, "of at most 1000 points, got 1001"),
    ],
    ids=["large", "far", "small", "crossed", "round"],
)
def test_polygons_beyond_all_bounds(polygon, words):
    with pytest.raises(ValueError, match=rf"^markers\['right'\] must be a polygon {words}"):
        MarkerLayout.from_markers({"right": polygon, "left": np.add(SQUARE, (0, -50))})
    polygons = {"right": SQUARE - SQUARE.mean(axis=0), "left": polygon}
    with pytest.raises(ValueError, match=rf"^polygons\['left'\] must be a polygon {words}"):
        MarkerLayout.from_positions({"right": (0, 9), "left": (0, -9)}, polygons=polygons)


@pytest.mark.parametrize(
    "box", [(-(2**31), -(2**31), 2**31 - 1, 2**31 - 1), (5000, 5000, 5010, 5010), (7, 0, 9, 6)]
)
@pytest.mark.parametrize(
    "markers",
    [MARKERS, MarkerLayout.from_markers({"right": np.add(SQUARE, (0, 43)), "left": SQUARE})],
)
def test_blobs_of_another_frame_leave_the_measurement_as_it_is(box, markers):
    places = {"red": (600, 621.5), "blue": (600, 578.5)}
    blobs = {
        name: [Blob(name, area=16, centroid=place, bounding_box=box)]
        for name, place in places.items()
    }
    counted = locate(blobs, markers)
    seen = locate(blobs, markers, image=np.full((7, 9, 3), 90, np.uint8))
    assert counted is not None
    np.testing.assert_array_equal(seen.pose, counted.pose)
    assert seen.covariance is None


def test_as_many_blobs_are_considered_as_the_markers_say():
    """The blob like the marker is the third largest."""

    def blob(color, area, place):
        return Blob(color, area=area, centroid=place, bounding_box=(0, 0, 9, 9))

    blobs = {
        "red": [blob("red", 900, (50, 9)), blob("red", 800, (9, 50)), blob("red", 90, (100, 143))],
        "blue": [blob("blue", 90, (100, 100))],
    }
    layouts = [MarkerLayout(43, 14, maximum_blobs=most) for most in (2, 3)]
    found = [locate(blobs, layout) for layout in layouts]
    assert found[0] is None
    assert found[1] is not None


def test_markers_in_one_place():
    with pytest.raises(ValueError, match="distance between the markers"):
        MarkerLayout.from_markers({"right": SQUARE, "left": SQUARE})
