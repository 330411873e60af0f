"""Simulations of random scenarios, with callbacks that return anything: a run, or words."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from fuzzing import FLOATS, attempt, fuzzed
from scenarios import scenarios

pytestmark = [pytest.mark.fuzz, pytest.mark.long]

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
