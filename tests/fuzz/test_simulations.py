"""Random simulations and random measurements: a result or a refusal."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from fuzzing import (
    FLOATS,
    ORDINARY,
    POSITIVE,
    SEEDS,
    arrays,
    attempt,
    fuzzed,
    images,
    on_every_path,
    with_stride,
)
from robsim.vision import Blob, MarkerLayout, PlaneMap, detect
from scenarios import scenarios

# Odd voltages, headings and noises are warned of.
pytestmark = [pytest.mark.fuzz, pytest.mark.filterwarnings("ignore::UserWarning")]


# --- simulations


POSES = st.tuples(st.floats(-50, 300), st.floats(-50, 300), st.floats(-7, 7))
SQUARES = st.integers(0, 2**31).map(
    lambda seed: (lambda a: a @ a.T)(np.random.default_rng(seed).normal(size=(3, 3)))
)
#: What a slot asks for.
RIGHT = {
    "control": st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    "measure": st.one_of(st.none(), st.builds(robsim.Measurement, POSES)),
    "estimate_state": st.builds(robsim.Estimate, POSES, SQUARES),
    "estimate_parameters": st.one_of(st.none(), st.just(np.ones((3, 5)))),
    "evaluate_model": POSES,
    "adjust_background": st.just(np.full((40, 50, 3), 90, np.uint8)),
    "define_model": st.one_of(st.none(), st.builds(robsim.RobotModel)),
    "init_parameter_estimator": st.builds(lambda: robsim.RecursiveLeastSquares(5, n_filters=3)),
}
ODD = st.one_of(
    st.none(), st.booleans(), FLOATS, st.integers(), st.text(max_size=3), st.binary(max_size=3),
    st.lists(FLOATS, max_size=4), st.tuples(FLOATS, FLOATS), st.tuples(FLOATS, FLOATS, FLOATS),
    st.sampled_from((int, ..., {}, {1, 2}, np.ones((3, 5)), np.array("a"), np.eye(3) * 1j)),
)  # fmt: skip
ONCE = ("adjust_background", "define_model", "init_parameter_estimator")


class Planned(Exception):
    """What a callback raises on purpose."""


def callback(slot, answers):
    """A callback that gives one of the answers after the other; `Planned` is raised."""
    left = iter(answers * 100)

    def answer(*_):
        value = next(left)
        if value is Planned:
            raise Planned(slot)
        return value

    if slot in ONCE and slot != "adjust_background":
        return lambda: answer()
    return lambda step: answer()


@st.composite
def callbacks(draw):
    chosen = draw(st.lists(st.sampled_from(sorted(RIGHT)), max_size=4, unique=True))
    given = {}
    for slot in chosen:
        kinds = draw(st.sampled_from(((RIGHT[slot],), (RIGHT[slot],), (RIGHT[slot], ODD))))
        answers = draw(st.lists(st.one_of(*kinds), min_size=1, max_size=4))
        if draw(st.integers(0, 9)) == 0:
            answers.append(Planned)
        given[slot] = callback(slot, answers)
    return given


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::robsim.vision.SmallMarkersWarning")
@fuzzed
@given(
    scenarios(), callbacks(), st.tuples(st.integers(16, 200), st.integers(16, 200)),
    st.tuples(st.integers(16, 200), st.integers(16, 200)), st.integers(1, 25), st.booleans(),
)  # fmt: skip
def test_simulations(scenario, given_callbacks, area, resolution, n, again):
    scenario = scenario.replace(area=area, resolution=resolution)
    sim = attempt(robsim.Simulation, scenario, **given_callbacks)
    if sim is None:
        return
    for _ in range(2 if again else 1):
        trace = attempt(run, sim, n, also=(Planned,))
        if trace is not None:
            assert len(trace) <= 2 * n
            assert np.isfinite(trace.u[:-1]).all()
        kept = sim.trace
        assert np.isfinite(kept.pose_true).all()
        assert len(repr(kept)) < 10_000
        attempt(kept.tracking)
    attempt(sim.reset)


def run(sim, n):
    try:
        sim.run(n)
    except IndexError as error:  # Replay ends so, and nothing else
        if not str(error).startswith("the recorded inputs have"):
            raise
    return sim.trace


# --- measurements


COLORS = robsim.load_colors()
LARGE = st.integers(60, 140) | st.sampled_from((63, 64, 65, 127, 128, 129))
SIZES = st.one_of(
    st.tuples(LARGE, LARGE), st.tuples(LARGE, LARGE), st.tuples(*[st.integers(1, 8)] * 2)
)


@st.composite
def outlines(draw):
    """A polygon: round, a star, or any points."""
    if draw(st.integers(0, 3)) == 0:
        return draw(arrays((st.integers(0, 9), 2), (4, 2), (3, 2)))
    count = draw(st.integers(3, 40))
    radius = draw(st.floats(1, 14)) * np.ones(count)
    radius[:: draw(st.integers(1, 3))] *= draw(st.floats(0.1, 1))
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.column_stack((radius * np.cos(angles), radius * np.sin(angles)))


@st.composite
def layouts(draw):
    """Two markers with outlines, or places alone."""
    distance, offset = draw(st.floats(10, 40)), draw(st.floats(-10, 10))
    places = {"right": (offset, distance / 2), "left": (offset, -distance / 2)}
    first, second = draw(outlines()), draw(outlines())
    kind = draw(st.sampled_from(("polygons", "polygons", "places", "both")))
    if kind == "places":
        return attempt(MarkerLayout.from_positions, places)
    given = {"right": first, "left": second}
    if kind == "both":
        return attempt(MarkerLayout.from_positions, places, polygons=given)
    if all(np.ndim(one) == 2 and np.shape(one)[1:] == (2,) for one in given.values()):
        given = {role: np.add(one, places[role]) for role, one in given.items()}
    return attempt(MarkerLayout.from_markers, given)


def picture(layout, size, light, noise, seed):
    """Two discs where the markers are, in any light; they may lie partly beyond the picture."""
    rng = np.random.default_rng(seed)
    height, width = size
    v, u = np.indices((height, width))
    image = np.full((height, width, 3), rng.integers(60, 250), float)
    pose = rng.uniform((0.3 * width, 0.3 * height, -4), (0.7 * width, 0.7 * height, 4))
    turn = np.array(((np.cos(pose[2]), -np.sin(pose[2])), (np.sin(pose[2]), np.cos(pose[2]))))
    for role, color in (("right", (200, 40, 45)), ("left", (35, 60, 210))):
        centre = pose[:2] + turn @ layout.positions[role]
        radius = np.sqrt(np.nan_to_num(layout.areas[role], nan=200) / np.pi)
        covered = np.clip(radius - np.hypot(u - centre[0], v - centre[1]), 0, 1)[..., np.newaxis]
        image += covered * (color - image)
    return np.clip(light * image + noise * rng.normal(size=image.shape), 0, 255).astype(np.uint8)


def check(detection):
    """What is measured is finite, and a value that is made anew from its parts."""
    assert pickle.loads(pickle.dumps(detection)) == detection
    measurement = detection.measurement
    if measurement is None:
        assert detection.reason
        return
    assert np.isfinite(measurement.pose).all()
    if measurement.covariance is not None:
        assert np.isfinite(measurement.covariance).all()
        assert (np.linalg.eigvalsh(measurement.covariance) >= -1e-9).all()


def same_on_every_path(call):
    first, *others = on_every_path(call)
    for other in others:
        assert other == first
        if first is not None:
            assert repr(other) == repr(first)
    return first


@fuzzed
@given(
    st.data(), layouts(), SIZES, st.floats(0.02, 1.2) | st.floats(0.6, 1),
    st.sampled_from((0, 0, 2, 20)), SEEDS, st.booleans(),
)  # fmt: skip
def test_pictures_of_markers(data, layout, size, light, noise, seed, with_colors):
    if layout is None or not np.isfinite(list(layout.positions.values())).all():
        return
    image = with_stride(data.draw, picture(layout, size, light, noise, seed))
    given = {"image": image, "colors": COLORS if with_colors else None}

    def measured():
        blobs = robsim.find_blobs(image, COLORS, markers=layout)
        return attempt(detect, blobs, layout, **given)

    detection = same_on_every_path(measured)
    if detection is not None:
        check(detection)
        assert measured() == detection  # nothing is kept from call to call


@st.composite
def blobs(draw, color, layout):
    """A blob that may lie anywhere, of any size; two in three where a marker may be."""
    sides = st.one_of(st.integers(-5, 100), st.integers(-(2**31), 2**31 - 1))
    left, right = sorted(draw(st.tuples(sides, sides)))
    top, bottom = sorted(draw(st.tuples(sides, sides)))
    box = (left, top, right, bottom)
    if draw(st.integers(0, 2)):
        role = {"red": "right", "blue": "left"}[color]
        area = round(np.nan_to_num(layout.areas[role], nan=200))
        place = tuple(np.add((30, 30), layout.positions[role]))
    else:
        area = draw(st.integers(1, 900) | st.integers(-1, 2**63 - 1))
        place = draw(st.tuples(ORDINARY, ORDINARY) | st.tuples(FLOATS, FLOATS))
    return attempt(Blob, color, area=area, centroid=place, bounding_box=box)


@fuzzed
@given(
    st.data(), layouts(), images(),
    st.sampled_from(("identity", "identity", "scaled", "oblique")),
    arrays((3, 3), numbers=POSITIVE),
)  # fmt: skip
def test_blobs_that_are_not_those_of_the_image(data, layout, image, kind, matrix):
    if layout is None:
        return
    found = {
        color: [data.draw(blobs(color, layout)) for _ in range(data.draw(st.integers(1, 2)))]
        for color in ("red", "blue")
    }
    found = {color: [one for one in some if one is not None] for color, some in found.items()}
    plane_map = {
        "identity": PlaneMap,
        "scaled": lambda: PlaneMap.scaled((64, 48), (64, 51)),
        "oblique": lambda: attempt(PlaneMap, matrix) or PlaneMap(),
    }[kind]()
    detection = same_on_every_path(
        lambda: attempt(detect, found, layout, image=image, plane_map=plane_map)
    )
    if detection is not None:
        check(detection)
