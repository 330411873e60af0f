"""Random arrays into every native function: a result, or a refusal in words; never a crash."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from fuzzing import (
    FLOATS,
    NUMBERS,
    ORDINARY,
    POSITIVE,
    SEEDS,
    arrays,
    attempt,
    fuzzed,
    images,
    mostly,
    on_every_path,
)
from robsim import _core
from robsim.vision import MarkerLayout, PlaneMap

pytestmark = pytest.mark.fuzz

LEVELS = st.integers(0, 255)
RANGES = st.one_of(
    st.tuples(LEVELS, LEVELS).map(sorted).map(tuple), st.tuples(*[st.integers(-2, 300)] * 2)
)
COLORS = st.lists(
    st.builds(
        lambda name, y, u, v: attempt(robsim.ColorClass, name, y=y, u=u, v=v),
        st.sampled_from(("red", "blue", "a", "ä")),
        RANGES,
        RANGES,
        RANGES,
    ),
    max_size=4,
).map(lambda colors: [color for color in colors if color is not None])
LAYOUTS = st.builds(
    lambda distance, offset, *tolerances: attempt(
        MarkerLayout,
        distance,
        offset,
        distance_tolerance=tolerances[0],
        area_tolerance=tolerances[1],
        maximum_blobs=tolerances[2],
    ),
    mostly(POSITIVE, FLOATS),
    mostly(st.floats(-3.1, 3.1), FLOATS),
    mostly(st.floats(0.01, 1), FLOATS),
    mostly(st.floats(1.1, 9), FLOATS),
    st.integers(-1, 99),
)
REGIONS = st.one_of(st.none(), st.none(), st.tuples(*[st.integers(-3, 75)] * 4))
# x, y, width and height of a region as parts of an image's.
PARTS = st.tuples(*[st.floats(0, 0.99)] * 4)


# Rows of several blocks of 64 pixels, and of less than one
ANY_WIDTH = st.one_of(images(), images(largest=200))


@fuzzed
@given(
    ANY_WIDTH, COLORS, st.none() | LAYOUTS, st.none() | st.integers(-1, 9),
    st.none() | st.integers(-1, 9), st.none() | st.integers(-1, 16), REGIONS,
)  # fmt: skip
def test_find_blobs_and_locate(image, colors, layout, area, count, smoothing, region):
    def find():
        return attempt(
            robsim.find_blobs, image, colors, markers=layout, minimum_area=area,
            maximum_count=count, smoothing=smoothing, region=region,
        )  # fmt: skip

    first, *others = on_every_path(find)
    assert all(other == first for other in others)
    for blob in (blob for blobs in (first or {}).values() for blob in blobs):
        left, top, right, bottom = blob.bounding_box
        u, v = blob.centroid
        assert 0 <= left <= u + 1e-9 <= right + 2e-9 < image.shape[1]
        assert 0 <= top <= v + 1e-9 <= bottom + 2e-9 < image.shape[0]
    if first is not None and layout is not None:
        measured = attempt(robsim.locate, first, layout)
        assert measured is None or np.isfinite(measured.pose).all()


@fuzzed
@given(
    images(), REGIONS, PARTS, st.one_of(st.floats(0, 60), FLOATS), st.integers(-5, 300),
    st.booleans(),
)  # fmt: skip
def test_histograms_and_training(image, region, parts, percentile, margin, limit_y):
    if region is None:
        height, width = image.shape[:2]
        left, top = int(parts[0] * width), int(parts[1] * height)
        right, bottom = left + parts[2] * (width - left), top + parts[3] * (height - top)
        region = (left, top, int(right), int(bottom))
    histograms = attempt(_core.color_histograms, image, region)
    options = {"name": "a", "percentile": percentile, "margin": margin, "limit_y": limit_y}
    if histograms is not None:
        assert (histograms.sum(axis=1) == histograms[0].sum()).all()
        attempt(robsim.ColorClass.from_histograms, histograms, **options)
    attempt(robsim.ColorClass.from_region, image, region, **options)


POINTS = arrays((st.integers(0, 9), 2), (4, 2), (2,), (3,), (0, 2))


@fuzzed
@given(
    st.one_of(arrays((3, 3), (9,), (2, 2)), arrays((3, 3), numbers=ORDINARY)), POINTS,
    st.sampled_from(("identity", "scaled", "matrix")), st.tuples(NUMBERS, NUMBERS),
)  # fmt: skip
def test_plane_maps(matrix, points, kind, area):
    if kind == "identity":
        plane_map = PlaneMap()
    elif kind == "scaled":
        plane_map = attempt(PlaneMap.scaled, (64, 48), np.abs(area))
    else:
        plane_map = attempt(PlaneMap, matrix)
    if plane_map is None:
        return
    for direction in (plane_map.to_world, plane_map.to_pixel):
        mapped = attempt(direction, points)
        assert mapped is None or mapped.shape == np.shape(points)


@fuzzed
@given(arrays((st.integers(3, 12), 2)), arrays((4, 2), (st.integers(3, 12), 2)), SEEDS)
def test_plane_maps_from_points(pixels, positions, seed):
    moved = np.asarray(pixels, float) + np.random.default_rng(seed).normal(size=np.shape(pixels))
    for to in (positions, moved):
        plane_map = attempt(PlaneMap.from_points, pixels, to)
        if plane_map is not None:
            assert np.isfinite(plane_map.matrix).all()


def stable_theta(seed):
    """Random parameters with poles between 0 and 1."""
    rng = np.random.default_rng(seed)
    poles = rng.uniform(0, 1, (3, 2))
    a = np.column_stack((poles.sum(axis=1), -poles.prod(axis=1)))
    return np.hstack((a, rng.normal(size=(3, 3))))


STABLE = SEEDS.map(stable_theta)
THETA = st.one_of(STABLE, STABLE, arrays((3, 5), (5, 3), (15,)))
DT = st.one_of(POSITIVE, POSITIVE, FLOATS)


@fuzzed
@given(THETA, arrays((3,), (3,), (2,)), arrays((3,)), arrays((2,), (2,), (3,)), DT)
def test_the_model(theta, pose_1, pose_2, u, dt):
    model = attempt(robsim.RobotModel.from_theta, theta, dt=dt)
    if model is None:
        return
    attempt(model.steps_in, dt)
    attempt(model.jacobian, pose_1, pose_2, u)
    predicted = attempt(model.predict, pose_1, pose_2, u)
    if predicted is not None and np.isfinite(predicted).all():
        assert -np.pi < predicted[2] <= np.pi


LENGTHS = st.integers(0, 30)


@fuzzed
@given(
    THETA, arrays((2, 3), (2, 3), (3, 2)), arrays((LENGTHS, 2), (30, 2), (LENGTHS, 3)),
    arrays((LENGTHS, 3), (30, 3), (LENGTHS, 2)),
)  # fmt: skip
def test_paths_and_regressors(theta, first, u, poses):
    path = attempt(_core.simulated_path, theta, first, u)
    if path is not None:
        attempt(_core.path_sensitivities, theta, path, u)
    attempt(_core.path_sensitivities, theta, poses, u)
    samples = attempt(_core.regression, poses, u)
    if samples is not None:
        phi, y = samples
        assert len(phi) == len(y)


@fuzzed
@given(arrays((LENGTHS, st.integers(0, 7)), (30, 5), (LENGTHS, 2, 3)), arrays((LENGTHS,), (30,)))
def test_least_squares(phi, y):
    for target in (y, np.resize(y, np.shape(phi)[:1])):
        fit = attempt(_core.least_squares, phi, target)
        if fit is not None:
            assert 0 <= fit.rank <= np.shape(phi)[1]


@fuzzed
@given(
    mostly(st.integers(1, 12), st.integers(-1, 0)), mostly(st.integers(1, 5), st.integers(-1, 0)),
    mostly(st.floats(0.5, 1), FLOATS), mostly(POSITIVE, FLOATS),
    st.lists(st.tuples(arrays((5,), (3, 5), (1,)), arrays((), (3,), (1,))), max_size=8), SEEDS,
)  # fmt: skip
def test_recursive_least_squares(n, n_filters, forgetting, covariance, samples, seed):
    estimator = attempt(
        robsim.RecursiveLeastSquares, n, n_filters=n_filters, forgetting=forgetting,
        initial_covariance=covariance,
    )  # fmt: skip
    if estimator is None:
        return
    rng = np.random.default_rng(seed)
    fitting = [(rng.normal(size=(n_filters, n)), rng.normal(size=n_filters)) for _ in range(3)]
    for phi, y in (*samples, *fitting):
        attempt(estimator.update, phi, y)
    assert np.isfinite(estimator.theta).all()
    assert np.isfinite(estimator.P).all()
    diagonal = np.diagonal(estimator.P.reshape(-1, n, n), axis1=1, axis2=2)
    assert (diagonal >= 0).all()
