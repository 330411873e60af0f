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
from robsim.vision import MarkerLayout

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
        {"red blue": NO_POLYGON, "red": ([[10**400, 0], [1, 0], [1, 1]],)},
        **{"red": np.add(SQUARE, (0, 50)), "blue": SQUARE},
    ),
)
def test_markers(refusal):
    refusal()


@pytest.mark.parametrize("polygon", [SQUARE * 1e160, SQUARE + 1e300], ids=["large", "far"])
def test_polygons_beyond_all_bounds(polygon):
    with pytest.raises(ValueError, match=r"red|distance"):
        MarkerLayout.from_markers(polygon, SQUARE)


def test_markers_in_one_place():
    with pytest.raises(ValueError, match="distance between the markers"):
        MarkerLayout.from_markers(SQUARE, SQUARE)
