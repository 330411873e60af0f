"""The schema of a trace in the core, and what is made of it in Python."""

import math

import numpy as np
import pytest

import robsim
from robsim._core import trace_schema
from robsim.trace import Trace

SCHEMA = {group.name: group for group in trace_schema()}


def empty_trace(steps=4, **groups):
    required = {"pose_true": 3, "u": 2, "bounced": 1}
    rows = {name: np.zeros((steps, width)) for name, width in required.items()}
    info = robsim.Simulation(seed=1).trace.info
    return Trace(rows | groups, info)


def test_a_group_has_a_unit_for_each_number_of_its_shape():
    for group in SCHEMA.values():
        assert len(group.units) == math.prod(group.shape)
        assert not group.is_flag or group.shape == ()
        assert "(N" in getattr(Trace, group.name).__doc__
    fields = [field for group in SCHEMA.values() for field in group.units]
    assert len(set(fields)) == len(fields)


def test_a_group_comes_back_in_its_shape():
    for name, group in SCHEMA.items():
        rows = np.arange(1.0, 4 * len(group.units) + 1).reshape(4, *group.shape)
        trace = empty_trace(**{name: rows})
        values = getattr(trace, name)
        assert values.dtype == (bool if group.is_flag else float)
        np.testing.assert_array_equal(values, rows > 0 if group.is_flag else rows)
        for field, unit in group.units.items():
            assert trace.units[field] == unit
            assert trace[field].dtype == values.dtype


def test_what_was_not_recorded_is_said():
    trace = empty_trace()
    for name, group in SCHEMA.items():
        if not group.in_simulated and name != "t":
            values = getattr(trace, name)
            expected = np.full((4, *group.shape), False if group.is_flag else group.missing)
            np.testing.assert_array_equal(values, expected)
            assert values.shape == expected.shape
        with pytest.raises(AttributeError):
            setattr(trace, name, 0)


def test_the_time_is_that_of_the_steps_where_the_frames_had_none():
    np.testing.assert_allclose(empty_trace().t, [0, 0.2, 0.4, 0.6])
    np.testing.assert_array_equal(empty_trace(t=[1.0, 2.0, 3.0, 5.0]).t, [1, 2, 3, 5])


def test_the_noise_and_the_hiding_of_each_step():
    trace = empty_trace(noise=[[40, np.nan]] * 4, hidden=[0, 1, 1, 0])
    np.testing.assert_array_equal(trace["noise_gaussian"], [40] * 4)
    assert np.isnan(trace["noise_uniform"]).all()
    assert trace.units["noise_gaussian"] == "%"
    assert trace.hidden.tolist() == trace["hidden"].tolist() == [False, True, True, False]


def test_the_poses_of_each_source():
    groups = {"truth": "pose_true", "measurement": "pose_measured", "estimate": "pose_estimated"}
    for source, group in groups.items():
        trace = empty_trace(**{group: np.arange(12.0).reshape(4, 3)})
        np.testing.assert_array_equal(trace.poses_from(source), np.arange(12).reshape(4, 3))
    with pytest.raises(ValueError, match="source must"):
        empty_trace().poses_from("pose_true")


def test_a_run_is_tracked_if_the_pose_was_measured_seen_or_not():
    assert not empty_trace().is_tracked
    assert empty_trace(pose_measured=np.full((4, 3), np.nan)).is_tracked


def test_a_simulated_run_must_have_what_the_schema_says():
    trace = empty_trace()
    required = [name for name, group in SCHEMA.items() if group.in_simulated]
    assert set(required) == {"pose_true", "u", "bounced"}
    for left_out in required:
        rows = {name: getattr(trace, name) for name in required if name != left_out}
        with pytest.raises(ValueError, match=rf"\b{left_out}\b"):
            Trace(rows, trace.info)
