"""What is no homography, no camera and no point is refused by a plane map."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis.extra import numpy as npst

from refusals import INF, NAN, NO_PAIR, NO_PIXELS, Refusal, refusals, refuses
from robsim.imaging import PlaneMap

MAPS = {"pixels": PlaneMap().to_world, "positions": PlaneMap().to_pixel}
map_points = pytest.mark.parametrize(("call", "name"), [(MAPS[name], name) for name in MAPS])
NO_HOMOGRAPHY = (
    *(None, 5, "abc", {1: 2}, [["a"] * 3] * 3, [[1j, 0, 0], [0, 1, 0], [0, 0, 1]]),
    *(np.eye(2), np.eye(4), np.zeros(9), np.zeros((1, 3, 3)), np.zeros((3, 3))),
    *(np.ones((3, 3)), np.diag([1, 1, 0]), np.eye(3) * NAN, np.full((3, 3), INF)),
)
NO_POINTS = (
    *(None, 5, 1.5, "ab", "a", b"ab", [], [1], [1, 2, 3], [[1, 2], [3]], {1, 2}),
    *(["a", "b"], [["a", "b"]], [NAN, 1], [[INF, 1]], [None, None], [1j, 2], [object(), 1]),
    *(np.array(1.0), np.zeros((2, 3)), np.zeros((2, 2, 2)), np.zeros((2, 0))),
    *((value for value in (1, 2)), {0: 1, 1: 2}, {"u": 1, "v": 2}, (10**400, 0)),
)


@pytest.mark.long
@refusals(
    Refusal(PlaneMap, "matrix", NO_HOMOGRAPHY[1:]),  # None: the identity
    Refusal(lambda value: PlaneMap.scaled(value, (1, 1)), "resolution", (*NO_PIXELS, (None, 1))),
    Refusal(
        lambda value: PlaneMap.scaled((1000, 1000), value),
        "area",
        (*NO_PAIR, "12", (0, 1), (1, -1), (INF, 1), ("a", 1), (1e-9, 1e-9)),
    ),
    *(Refusal(call, name, NO_POINTS) for name, call in MAPS.items()),
)
def test_what_is_no_map_and_no_point(refusal):
    refusal()


@pytest.mark.parametrize("factor", [1e-5, -2, 1e200])
def test_a_homography_is_the_same_times_any_number(factor):
    np.testing.assert_allclose(PlaneMap(np.eye(3) * factor).to_world((3, 4)), (3, 4))


@pytest.mark.long
@map_points
@settings(max_examples=60)
@given(shape=npst.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=4))
def test_points_of_any_shape(call, name, shape):
    if shape == (2,) or (len(shape) == 2 and shape[1] == 2):
        assert call(np.zeros(shape)).shape == shape
    else:
        refuses(name, call, np.zeros(shape))
