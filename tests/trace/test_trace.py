import copy
import csv
import json
import pickle
import re

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robsim
from robsim.trace import PARAMETER_NAMES, NotRecordedError, RunInfo, Trace
from sizes import thorough

NAN = np.nan
DT = 0.2
THETA = tuple(tuple(float(5 * row + column) for column in range(5)) for row in range(3))
SEED = {"entropy": 12345678901234567890123, "spawn_key": [1, 2]}
INFO = RunInfo(dt=DT, theta_true=THETA, seed=SEED, area=(300, 200), boundary="bounce", robot="lab")

REQUIRED = {"pose_true": 3, "u": 2, "bounced": 1}
OPTIONAL = {
    "pose_measured": 3,
    "pose_held": 3,
    "blobs_red": 4,
    "blobs_blue": 4,
    "pose_estimated": 3,
    "covariance": 9,
    "state": 2,
    "parameters": 15,
    "view": 2,
}

# pose_true, measured, and what comes of it: error, seen, is_false
TRACKED = [
    # heading wrapped: 3.1 measured, -3.1 true, that is 2 pi - 6.2 short of it
    ([10, 20, -3.1], [13, 16, 3.1], [3, -4, 6.2 - 2 * np.pi], True, False),
    ([10, 20, 0.0], [NAN, NAN, NAN], [NAN, NAN, NAN], False, False),
    ([10, 20, 0.0], [10, 20.5, 0.1], [0, 0.5, 0.1], True, False),
    ([10, 20, 0.0], [10, 31, 0.0], [0, 11, 0], True, True),
    ([10, 20, 0.0], [10, 20, 0.4], [0, 0, 0.4], True, True),
    ([10, 20, 0.0], [10, 30, np.deg2rad(19.9)], [0, 10, np.deg2rad(19.9)], True, False),
]


def groups(rows, optional=tuple(OPTIONAL), first=0.0):
    """Numbers that are all different."""
    widths = REQUIRED | {name: OPTIONAL[name] for name in optional}
    start = first + 100 * np.cumsum([0, *widths.values()])
    made = {
        name: begin + np.arange(rows * width, dtype=float).reshape(rows, width)
        for (name, width), begin in zip(widths.items(), start[:-1], strict=True)
    }
    made["bounced"] = np.arange(rows, dtype=float).reshape(rows, 1) % 2
    return made


def trace_of(rows=4, optional=tuple(OPTIONAL), first_step=0, **replaced):
    return Trace(groups(rows, optional) | replaced, INFO, first_step=first_step)


def tracked():
    poses, measured = (np.array([row[i] for row in TRACKED], dtype=float) for i in (0, 1))
    return trace_of(len(TRACKED), ("pose_measured",), pose_true=poses, pose_measured=measured)


def assert_same(trace, other):
    assert trace.info == other.info
    assert trace.names == other.names
    assert len(trace) == len(other)
    np.testing.assert_array_equal(trace.k, other.k)
    for name in trace.names:
        assert trace[name].dtype == other[name].dtype
        assert trace[name].tobytes() == other[name].tobytes(), name


# --- columns


def test_single_columns_are_the_numbers_of_their_group():
    trace = trace_of(4)
    for name, expected in {
        "heading_true": trace.pose_true[:, 2],
        "u2": trace.u[:, 1],
        "red2_x": trace.blobs["red"][:, 1, 0],
        "blue1_y": trace.blobs["blue"][:, 0, 1],
        "cov_x_heading": trace.covariance[:, 0, 2],
        "b1Y": trace.parameters[:, 1, 2],
        "state1": trace.state[:, 1],
        "bounced": [False, True, False, True],
    }.items():
        np.testing.assert_array_equal(trace[name], expected)
    assert all(trace[name].shape == (4,) for name in trace.names)
    assert PARAMETER_NAMES[:6] == ("a1X", "a2X", "b1X", "b2X", "d1X", "a1Y")


def test_a_trace_without_groups_or_without_steps_has_the_same_columns():
    trace = trace_of(4, optional=())
    assert np.isnan(trace.error).all()
    assert not np.any([trace.seen, trace.is_false])
    assert trace.blobs == {}
    assert trace.state.shape == (4, 0)
    assert " ".join(trace.names) == "k t x_true y_true heading_true u1 u2 bounced"
    for trace in (trace_of(0), trace_of(4)[2:2]):
        statistics = trace.tracking()
        assert len(trace) == statistics.seen == statistics.steps == 0
        assert statistics.to_dict()["rmse_xy"] is None
        assert (trace.covariance.shape, trace.state.shape) == ((0, 3, 3), (0, 2))
        assert trace.names == trace_of(1).names


def test_a_loaded_trace_is_read_only(tmp_path):
    trace_of(4, optional=("pose_estimated", "view")).save(tmp_path / "run.npz")
    loaded = Trace.load(tmp_path / "run.npz")
    for name in ("pose_true", "u", "pose_measured", "pose_held", "pose_estimated", "view"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(loaded, name)[0] = 1


def test_wrong_groups_are_named():
    for name, values in (
        ("pose_true", np.zeros((2, 2))),
        ("u", np.zeros((3, 2))),
        ("u", np.zeros((2, 3))),
        ("something", np.zeros((2, 1))),
        ("blobs_", np.zeros((2, 1))),
        ("pose_held", np.zeros((2, 1))),
    ):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            trace_of(2, (), **{name: values})


# --- derived columns


def test_error_valid_and_false_by_hand():
    trace = tracked()
    _, _, errors, seen, is_false = zip(*TRACKED, strict=True)
    np.testing.assert_allclose(trace.error, np.array(errors), atol=1e-12)
    np.testing.assert_array_equal(trace.seen, seen)
    np.testing.assert_array_equal(trace.is_false, is_false)


def test_tracking_statistics_by_hand():
    trace = trace_of(
        4,
        ("pose_measured",),
        pose_true=np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, np.pi]], dtype=float),
        pose_measured=np.array([[3, 4, 0.1], [NAN, NAN, NAN], [0, 12, 0.2], [1, 0, -np.pi]]),
    )
    statistics = trace.tracking()
    assert (statistics.steps, statistics.seen, statistics.false_poses) == (4, 3, 1)
    # without the false pose: (3^2 + 4^2 + 1^2)/2 = 13; with it the distances are 1, 5, 12
    assert statistics.rmse_xy == pytest.approx(np.sqrt(13))
    assert statistics.rmse_heading_deg == pytest.approx(np.rad2deg(np.sqrt(0.01 / 2)))
    assert statistics.median_xy == pytest.approx(5)
    assert statistics.median_heading_deg == pytest.approx(np.rad2deg(0.1))
    assert statistics.largest_xy == pytest.approx(5)
    assert statistics.largest_heading_deg == pytest.approx(np.rad2deg(0.1))
    lines = str(statistics).splitlines()
    assert [line.split("   ")[-1].strip() for line in lines[1:11]] == [
        *("4", "3 (75.0 %)", "1", "1", "3.606", "4.051", "5.000", "5.730", "5.000", "5.730")
    ]
    assert "more than 10 px or 20 deg" in " ".join(str(statistics).split())


def test_tracking_tells_reasons_and_what_measurements_report():
    covariance = np.zeros((5, 3, 3))
    covariance[:, 0, 0], covariance[:, 1, 1] = 9, 16
    covariance[:, 2, 2] = np.deg2rad([1, 2, 3, 4, 5]) ** 2
    covariance[3:] = NAN
    poses = np.zeros((5, 3))
    poses[3:] = NAN
    trace = trace_of(
        5,
        ("pose_measured",),
        pose_measured=poses,
        covariance_measured=covariance.reshape(5, 9),
        missed=np.array([[0], [0], [0], [1], [4]], dtype=float),
    )
    statistics = trace.tracking()
    assert statistics.missed == dict.fromkeys(trace.missed_reasons[3:].tolist(), 1)
    assert statistics.reported_xy == pytest.approx(5)
    assert statistics.reported_heading_deg == pytest.approx(2)
    assert statistics.to_dict()["not_seen"] == 2


def test_errors_of_false_poses_alone_are_not_known():
    measured = np.tile([600, 800, 3.0], (4, 1))
    trace = trace_of(4, ("pose_measured",), pose_true=np.zeros((4, 3)), pose_measured=measured)
    every = trace.tracking()
    assert np.isnan([every.rmse_xy, every.largest_xy]).all()
    assert (every.median_xy, every.false_poses) == (1000, 4)


# --- slices


@pytest.mark.parametrize(("key", "steps"), [(slice(-2, None), [13, 14]), (slice(3, 1), [])])
def test_slices_keep_info_and_step_numbers(tmp_path, key, steps):
    whole = trace_of(5, optional=("pose_measured",), first_step=10)
    part = whole[key]
    assert part.info is whole.info
    np.testing.assert_array_equal(part.t, np.array(steps) * DT)
    np.testing.assert_array_equal(part[1:].k, steps[1:])
    np.testing.assert_array_equal(part.pose_measured, whole.pose_measured[key])
    part.save(tmp_path / "part.npz")
    assert_same(Trace.load(tmp_path / "part.npz"), part)
    with pytest.raises(ValueError, match="stride of 2"):
        whole[::2]


def test_a_wrong_key_or_attribute_names_the_column_that_was_meant():
    with pytest.raises(KeyError, match="x_true"):
        trace_of(4)["x_ture"]
    for name, meant in (("x_true", r"trace\['x_true'\]"), ("pose_ture", "'pose_true'")):
        with pytest.raises(AttributeError, match=meant):
            getattr(trace_of(4), name)


# --- what a run must have recorded


def test_what_was_not_recorded_is_named_with_the_remedy():
    trace = trace_of(4, optional=())
    trace.require()
    trace.require("pose_true", "u", "theta_true")
    with pytest.raises(NotRecordedError) as caught:
        trace.require("pose_true", "pose_measured", "pose_estimated", "covariance")
    error = caught.value
    assert error.columns == ("pose_measured", "pose_estimated", "covariance")
    assert error.remedy == "run with measure=True; run with estimate_state=..."
    again = pickle.loads(pickle.dumps(error))
    assert (again.columns, again.remedy, str(again)) == (error.columns, error.remedy, str(error))
    with pytest.raises(ValueError, match="'poses'"):
        trace.require("poses")
    for column, remedy in (("x_measured", "measure=True"), ("a1X", "estimate_parameters")):
        with pytest.raises(KeyError, match=f"'{column}' .*{remedy}"):
            trace[column]


def test_what_was_recorded_and_never_known_is_told_apart():
    unseen = trace_of(3, ("pose_measured",), pose_measured=np.full((3, 3), NAN))
    with pytest.raises(NotRecordedError, match="no pose_measured: the robot was never seen"):
        unseen.require("pose_measured")
    with pytest.raises(NotRecordedError, match="no pose_measured: it has no steps"):
        unseen[:0].require("pose_measured")


# --- other formats


def test_to_pandas():
    trace = trace_of(4, first_step=5)
    assert "steps 5..8" in repr(trace)
    frame = trace.to_pandas()
    assert frame.index.tolist() == [5, 6, 7, 8]
    assert ("k", *frame.columns) == trace.names
    assert frame.attrs["units"] == trace.units
    for name in frame.columns:
        np.testing.assert_array_equal(frame[name], trace[name])


def test_csv_round_trip_keeps_every_bit(tmp_path, rng):
    measured = rng.normal(size=(6, 3)) * 1e3
    measured[2] = NAN
    true = rng.normal(size=(6, 3))
    trace = trace_of(6, ("pose_measured",), pose_true=true, pose_measured=measured)
    path = tmp_path / "run.csv"
    trace.to_csv(path)
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert tuple(header) == trace.names
    assert len(rows) == 6
    assert rows[2][header.index("x_measured")] == ""
    assert rows[1][header.index("bounced")] == "True"
    for name in ("x_true", "heading_true", "y_measured", "t"):
        numbers = [float(row[header.index(name)] or NAN) for row in rows]
        np.testing.assert_array_equal(numbers, trace[name])
    trace_of(0, optional=()).to_csv(tmp_path / "empty.csv")
    header = "k,t,x_true,y_true,heading_true,u1,u2,bounced"
    assert (tmp_path / "empty.csv").read_text().split() == [header]
    frame = pd.read_csv(path)
    assert frame["seen"].dtype == frame["bounced"].dtype == bool


# --- files


@pytest.mark.long
@settings(max_examples=thorough(60, 20), deadline=None)
@given(
    rows=st.integers(0, 40),
    optional=st.sets(st.sampled_from(sorted(OPTIONAL))),
    first_step=st.integers(0, 10**9),
    seed=st.integers(0, 2**32),
)
def test_load_gives_back_what_save_wrote(tmp_path_factory, rows, optional, first_step, seed):
    rng = np.random.default_rng(seed)
    values = groups(rows, sorted(optional))
    for name, array in values.items():
        array[...] = rng.choice([rng.normal(), NAN, np.inf, -0.0, 5e-324, 1e308], size=array.shape)
        if name.startswith("covariance"):  # a negative variance is refused
            array[...] = np.abs(array)
    first, second = (tmp_path_factory.getbasetemp() / f"round_trip{i}.npz" for i in (1, 2))
    Trace(values, INFO, first_step=first_step).save(first)
    loaded = Trace.load(first)
    loaded.save(second)
    assert first.read_bytes() == second.read_bytes()
    assert loaded.info == INFO
    np.testing.assert_array_equal(loaded.k, first_step + np.arange(rows))
    with np.load(first, allow_pickle=False) as archive:
        for name, array in values.items():
            assert archive[name].shape == array.shape
            assert archive[name].tobytes() == array.tobytes()


def test_there_is_no_pickle_in_the_file(tmp_path):
    trace = trace_of(3)
    trace.save(tmp_path / "run.trace")
    assert [file.name for file in tmp_path.iterdir()] == ["run.trace"]
    assert Trace.load(str(tmp_path / "run.trace")) == trace
    with np.load(tmp_path / "run.trace", allow_pickle=False) as archive:
        members = {name: archive[name] for name in archive.files}
    assert set(members) == {"info", *REQUIRED, *OPTIONAL}
    info = json.loads(str(members["info"]))
    assert info["groups"] == [*REQUIRED, *OPTIONAL]
    assert info["seed"] == SEED
    assert info["theta_true"] == [list(row) for row in THETA]
    assert all(values.dtype == np.float64 for name, values in members.items() if name != "info")


def refuses(path, name=""):
    """The error names the file, and what is wrong with it."""
    with pytest.raises(ValueError, match=rf"{re.escape(str(path))}.*{name}"):
        Trace.load(path)


def test_files_of_other_kinds(tmp_path):
    path = tmp_path / "other.npz"
    no_members = b"PK\x05\x06" + bytes(18)
    pickled = b"\x80\x04N."
    for content in (b"", b"k,t\n1,2\n", b"PK\x03\x04", no_members, b"\x93NUMPY", pickled):
        path.write_bytes(content)
        refuses(path)
    np.save(tmp_path / "array.npy", np.zeros(3))
    refuses(tmp_path / "array.npy")
    np.savez(tmp_path / "foreign.npz", a=np.zeros(3))
    refuses(tmp_path / "foreign.npz")
    with pytest.raises((OSError, ValueError), match=re.escape(str(tmp_path))):
        Trace.load(tmp_path)
    with pytest.raises(FileNotFoundError, match=re.escape(str(tmp_path / "no.npz"))):
        Trace.load(tmp_path / "no.npz")


@pytest.mark.long
def test_truncated_files(tmp_path):
    trace_of(5, ("pose_measured",)).save(tmp_path / "run.npz")
    saved = (tmp_path / "run.npz").read_bytes()
    for size in range(0, len(saved), 7):
        (tmp_path / "run.npz").write_bytes(saved[:size])
        refuses(tmp_path / "run.npz")


@pytest.fixture
def forge(tmp_path):
    """Write a trace file by hand, with some groups or some of its info changed."""

    def write(members=None, info=None, *, text=None, without=()):
        rows = groups(2, ("pose_measured",)) | (members or {})
        known = {
            "format": "robsim trace 1",
            "groups": [name for name in rows if name not in without],
            "first_step": 0,
            "dt": DT,
            "theta_true": THETA,
            "seed": SEED,
            "identify_from": "truth",
            "area": [300, 200],
            "boundary": "bounce",
            "robot": "lab",
        }
        known = {key: v for key, v in (known | (info or {})).items() if key not in without}
        text = json.dumps(known) if text is None else text
        made = {"info": np.array(text)} | rows
        path = tmp_path / "forged.npz"
        np.savez(path, **{name: v for name, v in made.items() if name not in without})
        return path

    return write


def test_wrong_members(forge):
    assert_same(Trace.load(forge()), trace_of(2, ("pose_measured",)))
    for name in ("info", "pose_true", "u", "bounced"):
        refuses(forge(without=[name]), name)
    for name, values in (
        *(("pose_true", np.zeros(shape)) for shape in (2, (2, 2), (3, 3))),
        *(("u", np.zeros((2, 2), dtype)) for dtype in (np.float32, np.int64, ">f8", complex)),
        ("bounced", np.array([["a"], ["b"]])),
        ("pose_measured", np.array([[None] * 3] * 2, dtype=object)),
        ("state", np.zeros((2, 2, 2))),
        *(("blobs_red", np.zeros((2, 8))), ("covariance", np.zeros((2, 3)))),
        ("something", np.zeros((2, 1))),
    ):
        refuses(forge({name: values}))


def test_wrong_info(forge):
    for key, values in {
        "format": ("robsim trace 2", None),
        "groups": (5, [1, "u"], [], [*REQUIRED, "pose_measured", "u"], [*REQUIRED, "pose_held"]),
        "first_step": ("3", 1.5, -1, 2**80),
        "theta_true": ("text", ["12345"] * 3, [[0.0] * 4] * 3, [[np.nan] * 5] * 3),
        "dt": ("x", 0, np.inf, 10**400),
        "area": (5, [1, 2, 3], [1.5, "a"], [0, 1]),
        "seed": (1, {"entropy": 1}, {"spawn_key": []}, {"entropy": 1, "spawn_key": [], "a": 1}),
        "robot": (5,),
        "colour": ("red",),
    }.items():
        for value in values:
            refuses(forge(info={key: value}))
        if key in ("format", "groups", "first_step", "theta_true", "dt", "area"):
            refuses(forge(without=[key]), key)
    for key in ("area", "callbacks", "changed", "marker_colors"):
        refuses(forge(info={key: None}), f"{key} must be a list")
    for key in ("format", "first_step", "groups"):
        refuses(forge(without=[key]), f"has no {key}")
    for text in ("", "{", "[]", "1", "{}", "9" * 5000, "[" * 100_000, 5, ["a", "b"]):
        refuses(forge(text=text))


def test_traces_are_equal_if_their_columns_and_runs_are():
    def run(seed, steps=5):
        return robsim.Simulation(seed=seed, control=robsim.DriveAround()).run(steps)

    trace = run(1)
    assert trace == run(1)
    assert trace == pickle.loads(pickle.dumps(trace)) == copy.deepcopy(trace)
    assert trace[2:] == run(1)[2:]
    for other in (run(2), run(1, 4), trace[1:], "trace"):
        assert trace != other
    frame = robsim.Frame(np.zeros((60, 60, 3), np.uint8))
    recorded = robsim.Experiment([frame], area=(60, 60), seed=1).run()  # no truth: NaN
    assert recorded == pickle.loads(pickle.dumps(recorded))


def test_a_callback_that_forgot_its_return_is_suspected():
    options = {"measure": lambda step: None, "estimate_parameters": lambda step: None}
    trace = robsim.Simulation(seed=1, **options).run(5)
    (remark,) = trace.tracking().remarks
    assert "must return its Measurement" in remark
    with pytest.raises(NotRecordedError, match="let estimate_parameters return"):
        trace.require("parameters")


def test_headings_in_degrees_are_suspected():
    def measure(step):
        x, y, heading = robsim.locate(step.blobs, step.markers).pose
        return robsim.Measurement((x, y, np.rad2deg(heading)))

    options = {"headings": None, "control": robsim.DriveAround(), "seed": 1}
    with pytest.warns(UserWarning, match="looks like degrees"):
        tracking = robsim.Simulation(measure=measure, **options).run(60).tracking()
    assert "is the heading of the Measurement in rad" in str(tracking)
    right = robsim.Simulation(measure=True, **options).run(60).tracking()
    assert "in rad" not in str(right)
