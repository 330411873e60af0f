"""What is no option of a simulation is refused at once, in a sentence with its name."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robsim
from refusals import IMAGE, IN_WORDS, NAN, options, refusals, refuses, short
from robsim import Simulation

COLORS = robsim.load_colors()

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

NO_BACKGROUNDS = (
    *(5, IMAGE.tolist(), b"x", IMAGE.astype(float), IMAGE.astype(np.int8), IMAGE.astype(bool)),
    *(IMAGE[..., 0], np.zeros((8, 10, 4), np.uint8), IMAGE[:0]),
)


@pytest.fixture(scope="module")
def sim():
    return Simulation(area=(200, 200), seed=1)


@pytest.mark.long
@refusals(
    options(Simulation, WRONG_OPTIONS, says=IN_WORDS),
    options(
        Simulation,
        {"noise": ("gaussian", "", 40, True, ["none"], robsim.GaussianNoise)},
        says=r"GaussianNoise\(40\)",
    ),
    options(
        Simulation,
        {"dropout": (0.2, "much", True, (0.2, 5), robsim.Dropout)},
        says=r"Dropout\(0\.2\)",
    ),
    options(Simulation, {"areas Noise identify control_ callback": (None,)}, raises=TypeError),
    options(Simulation, {"background": NO_BACKGROUNDS}, area=(200, 200)),
    options(Simulation, {"start": ((-1.1e6, 5, 0),)}, boundary="unlimited"),
)
def test_wrong_options(refusal):
    refusal()


@pytest.mark.parametrize("steps", [-1, -(2**63), 2**70, None, "3", 1.5, NAN, [3]], ids=short)
def test_steps(sim, steps):
    refuses("steps", sim.run, steps, says=IN_WORDS)
    assert len(sim.trace) == 0
    if steps in (-1, "3", 1.5):
        refuses("steps", sim.run, steps, says=IN_WORDS, progress=True)


@pytest.mark.parametrize("value", [np.int64(36), pytest.param(np.uint8(36), id="uint8")])
def test_numpy_ints_are_ints(value):
    Simulation(headings=value, area=(np.int64(100), np.int64(100)))


def test_a_background_of_another_type_is_described():
    with pytest.raises(TypeError, match=r"got a float64 array of shape \(9, 9, 3\)$"):
        Simulation(background=np.zeros((9, 9, 3)))


def test_the_number_of_a_step_is_an_int(sim):
    for k in ("1", 1.5, None, True):
        refuses("k", sim.render_step, k)
    with pytest.raises(IndexError, match=r"there are steps 0\.\.0, got k = 3"):
        sim.render_step(3)


def test_missing_color_and_picture_files(tmp_path):
    missing = tmp_path / "missing"
    with pytest.raises(FileNotFoundError, match="missing"):
        Simulation(colors=missing)
    with pytest.raises(FileNotFoundError, match="missing"):
        Simulation(background=missing, area=(200, 200))


def test_options_are_keywords():
    with pytest.raises(TypeError, match="scenario must be a Scenario, got 'lab': give options by"):
        Simulation("lab")


def test_a_misspelt_slot():
    sim = Simulation()
    with pytest.raises(AttributeError, match="contrl"):
        sim.contrl = lambda step: (0, 0)


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


@pytest.mark.long
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


def test_no_steps_are_no_steps(sim):
    assert len(sim.run(0)) == 0


@pytest.mark.long
@given(st.integers(0, 2**300))
def test_any_natural_number_is_a_seed(seed):
    trace = Simulation(area=(200, 200), seed=seed).trace
    assert trace.info.seed == {"entropy": seed, "spawn_key": []}
