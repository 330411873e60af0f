"""Scenarios to test with: one with all options, and random ones."""

import dataclasses
import math

import numpy as np
from hypothesis import strategies as st

import robsim
from robsim import Scenario
from robsim.simulation.option import Choice, Number, Switch, Whole
from robsim.simulation.options import OPTIONS
from robsim.vision import MarkerLayout

_RNG = np.random.default_rng(1)

FULL = Scenario(**{n: row.maximum for n, row in OPTIONS.items() if isinstance(row, Number)})
FULL = FULL.replace(
    robot=dataclasses.replace(robsim.load_robot("robot2"), name="own"),
    area=(800, 600),
    resolution=(400, 300),
    boundary="unlimited",
    headings=None,
    noise=robsim.UniformNoise(10.1),
    dropout=robsim.Dropout(0.1, 3),
    process_noise=robsim.WheelNoise((0.02, 0.03)),
    mismatch=robsim.ParameterMismatch(0.05),
    camera_delay=2,
    motor_delay=2.4,
    background=_RNG.integers(0, 256, (8, 10, 3)).astype(np.uint8),
    start=(1, 2.5, 6),
    seed=np.random.SeedSequence(7).spawn(2)[1],
    colors=[robsim.ColorClass("dark red", y=(1, 2)), robsim.ColorClass("blau-ä")],
    markers=MarkerLayout.from_positions({"right": (3, 4), "left": (1, 2)}, areas={"right": 5}),
    smoothing=3,
    identify_from="estimate",
    model=robsim.RobotParameters(mass=0.31),
    evaluate_model=robsim.Unicycle(),
    estimate_parameters=True,
    measure=True,
    control=robsim.Replay(_RNG.normal(size=(50, 2))),
)

_FINITE = st.floats(-1e6, 1e6)
_HEADING = st.floats(-6.28, 6.28)
_POSITIVE = st.floats(1e-3, 1e3)
# Whatever area and resolution come together, the robot's image is not too large.
_SIZE = st.tuples(st.integers(400, 8192), st.integers(400, 8192))
_RANGE = st.tuples(st.integers(0, 255), st.integers(0, 255)).map(sorted).map(tuple)
_SEEDS = st.one_of(
    st.integers(0, 2**200),
    st.builds(
        np.random.SeedSequence,
        st.one_of(st.integers(0, 2**70), st.lists(st.integers(0, 2**32), min_size=1)),
        spawn_key=st.lists(st.integers(0, 2**31)).map(tuple),
    ),
)
_LAYOUTS = st.builds(
    MarkerLayout.from_positions,
    st.fixed_dictionaries(
        {
            "front": st.tuples(st.floats(1, 100), _FINITE),
            "back": st.tuples(st.floats(-100, -1), _FINITE),
        }
    ),
    areas=st.fixed_dictionaries(dict.fromkeys(("front", "back"), st.none() | _POSITIVE)),
    distance_tolerance=_POSITIVE,
    area_tolerance=st.floats(1.01, 1e9),
    maximum_blobs=st.integers(1, 2**31 - 1),
)
# Words, as names of colours have to be.
_NAMES = st.text(st.characters(categories=("L", "Nd")), min_size=1, max_size=40)
_COLORS = st.lists(
    st.builds(robsim.ColorClass, _NAMES, y=_RANGE, u=_RANGE, v=_RANGE),
    min_size=1,
    max_size=4,
    unique_by=lambda color: color.name,
)
_PARAMETERS = st.builds(
    robsim.RobotParameters,
    mass=st.floats(0.1, 10),
    linear_friction=st.floats(0.01, 10),
    motor_gain=st.tuples(_POSITIVE, _POSITIVE),
)
_CONTROLLERS = st.one_of(
    st.builds(robsim.Spin, _FINITE),
    st.builds(
        robsim.DriveAround,
        low=st.floats(-1e6, 0),
        high=st.floats(0, 1e6),
        hold=st.integers(1, 2**31 - 1),
    ),
    st.lists(st.tuples(_FINITE, _FINITE), min_size=1).map(robsim.Replay),
)
_DISTURBANCES = st.one_of(
    st.builds(robsim.PoseNoise.from_sigma, *[st.floats(0, 1e6)] * 3),
    st.builds(robsim.WheelNoise, st.tuples(st.floats(0, 1e6), st.floats(0, 1e6))),
)
_NOISES = st.one_of(
    st.builds(robsim.GaussianNoise, st.floats(0, 100)),
    st.builds(robsim.UniformNoise, st.floats(1e-3, 100)),
)


_PLAIN = {
    Whole: lambda row: st.integers(row.minimum, row.maximum),
    Number: lambda row: (
        st.integers(math.ceil(row.minimum), int(row.maximum)) | st.floats(row.minimum, row.maximum)
    ),
    Choice: lambda row: st.sampled_from(row.choices),
    Switch: lambda row: st.booleans(),
}


def scenarios():
    """Random scenarios: any of the options, any others left out."""
    none = st.none()
    return st.builds(
        lambda given: Scenario(**given),
        st.fixed_dictionaries(
            {"boundary": st.just("unlimited")},  # a start anywhere
            optional={
                **{
                    name: _PLAIN[type(row)](row)
                    for name, row in OPTIONS.items()
                    if type(row) in _PLAIN and name != "boundary"
                },
                "robot": st.sampled_from(["lab", "sheep", FULL.robot]),
                "area": _SIZE,
                "resolution": none | _SIZE,
                "headings": none | st.integers(1, 360),
                "noise": none | _NOISES,
                "dropout": none | st.builds(robsim.Dropout, st.floats(0, 1), st.integers(1, 99)),
                "process_noise": none | _DISTURBANCES,
                "mismatch": none | st.builds(robsim.ParameterMismatch, st.floats(0, 0.3)),
                "background": st.none() | st.just(FULL.background),
                "start": st.one_of(none, st.just("random"), st.tuples(_FINITE, _FINITE, _HEADING)),
                "seed": none | _SEEDS,
                "colors": none | _COLORS,
                "markers": none | _LAYOUTS,
                "smoothing": none | st.sampled_from(range(1, 16, 2)),
                "model": none | _PARAMETERS | _PARAMETERS.map(robsim.RobotModel),
                "evaluate_model": none | st.just(robsim.Unicycle()),
                "control": none | _CONTROLLERS,
            },
        ),
    )
