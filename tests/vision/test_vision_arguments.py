"""Limits of the markers and of the blobs that are looked at."""

import numpy as np
import pytest

from refusals import SQUARE, refuses
from robsim import locate
from robsim.vision import Blob, MarkerLayout

RIGHT = np.add(SQUARE, (0, 50))


def test_limits_of_a_layout():
    good = {"distance": 43, "offset": 14}
    assert MarkerLayout(**good, distance_tolerance=1e-3).distance == 43
    for name, values in {
        "distance": (0, 1e-4, -43, np.inf),
        "offset": (np.inf, np.nan),
        "distance_tolerance": (0, -1, np.nan),
        "area_tolerance": (1, 0.5, np.nan),
    }.items():
        for value in values:
            refuses(name, MarkerLayout, **good | {name: value})
    flat, few = [[0, 0], [1, 1], [2, 2]], SQUARE[:2]
    for wrong in (
        *({"right": RIGHT, "left": polygon} for polygon in (flat, few, SQUARE * np.nan)),
        *({"right": RIGHT}, {"right": RIGHT, "back": SQUARE}, (RIGHT, SQUARE)),
    ):
        refuses("markers", MarkerLayout.from_markers, wrong)
    with pytest.raises(ValueError, match="distance"):
        MarkerLayout.from_markers({"right": SQUARE, "left": SQUARE})


CROSSED = np.array(((0, 0), (10, 10.001), (10, 0), (0, 10)))
ROUND = 9 * np.column_stack([f(np.linspace(0, 2 * np.pi, 1001)) for f in (np.cos, np.sin)])


def test_polygons_beyond_all_bounds():
    for polygon, words in (
        (SQUARE * 1e160, "1e9 px"),
        (SQUARE * 1e-160, "area"),
        (CROSSED, "cross"),
        (ROUND, "1000 points, got 1001"),
    ):
        with pytest.raises(ValueError, match=rf"^markers\['right'\].*{words}"):
            MarkerLayout.from_markers({"right": polygon, "left": np.add(SQUARE, (0, -50))})
        polygons = {"right": SQUARE - SQUARE.mean(axis=0), "left": polygon}
        with pytest.raises(ValueError, match=rf"^polygons\['left'\].*{words}"):
            MarkerLayout.from_positions({"right": (0, 9), "left": (0, -9)}, polygons=polygons)


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
