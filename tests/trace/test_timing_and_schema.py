"""The timing and the schema of a trace."""

import dataclasses
import math

import numpy as np
import pytest

import robsim
from robsim._core import trace_schema
from robsim.trace import NotRecordedError, Trace

# --- timing


DT = 0.2


def live(t, arrival=0.03, sent=0.05, **groups):
    """A run whose frames were exposed at these times, arrived and were answered so much later."""
    t = np.asarray(t, float)
    info = dataclasses.replace(robsim.Simulation(seed=1).trace.info, boundary="recorded", dt=DT)
    times = {"t": t, "t_arrival": t + arrival, "t_sent": t + sent}
    return Trace({"pose_measured": np.zeros((len(t), 3))} | times | groups, info)


def test_a_regular_run():
    report = live(np.arange(100) * DT).timing()
    assert report.rate == pytest.approx(5)
    assert report.jitter == pytest.approx(0, abs=1e-9)
    assert (report.steps, report.lost, report.stopped) == (100, 0, 0)
    expected = np.repeat([[0.03], [0.02], [0.05]], 3, axis=1)
    np.testing.assert_allclose(report.latency, expected, atol=1e-9)
    assert report.motor_delay == pytest.approx(0.25)
    assert report.to_dict()["motor_delay"] == report.motor_delay
    assert "regularly" not in str(report)


def test_the_latencies_of_the_steps(rng):
    arrival = rng.uniform(0.02, 0.04, 200)
    sent = arrival + rng.exponential(0.01, 200)
    t = np.arange(200) * DT
    report = live(t, arrival, sent).timing()
    for row, times in zip(report.latency, (arrival, sent - arrival, sent), strict=True):
        assert row[0] == pytest.approx(np.median(times))
        assert np.mean(times < row[1]) == pytest.approx(0.95, abs=0.006)
        assert row[2] == pytest.approx(times.max())
    shown = report.to_dict()
    assert shown["jitter_ms"] == pytest.approx(0, abs=1e-6)
    assert report.motor_delay == pytest.approx(np.median(sent) / DT)


def test_jitter_lost_frames_and_stops(rng):
    t = np.arange(50) * DT + rng.normal(0, 0.01, 50)
    t[20:] += 2 * DT
    t[35:] += 100.07
    report = live(t, interrupted=np.arange(50) == 35).timing()
    assert (report.lost, report.stopped) == (2, 1)
    assert report.jitter == pytest.approx(0.014, rel=0.4)
    assert report.rate == pytest.approx(5, rel=0.05)
    irregular = live(np.cumsum(rng.uniform(0.11, 0.29, 50))).timing()
    assert "regularly" in str(irregular)


@pytest.mark.parametrize("interval", [0.05, 0.25, 0.35])
def test_another_rate_than_the_models_is_told(interval):
    wrong, right = (live(np.arange(50) * dt).timing() for dt in (interval, DT))
    steps = max(round(interval / DT), 1)
    assert (wrong.interval, right.interval) == pytest.approx((interval / steps, DT))
    assert len(wrong.remarks) == len(right.remarks) + 1


def test_no_rate_is_reported_that_never_was(rng):
    t = np.arange(60) * 2 * DT + rng.normal(0, 0.005, 60)
    t[30:] += 2 * DT
    report = live(t).timing()
    assert report.rate == pytest.approx(2.5, rel=0.02)
    assert report.lost == 1
    assert any("2.5 frames/s" in remark for remark in report.remarks)


def test_a_delay_that_varies_is_told(rng):
    steady, varying = (
        live(np.arange(50) * DT, sent=0.05 + rng.uniform(0, spread, 50)).timing()
        for spread in (0.02, 0.3)
    )
    assert len(varying.remarks) == len(steady.remarks) + 1


def test_what_is_not_known_of_some_steps_and_of_all():
    t = np.arange(10) * DT
    arrival = np.where(t < 1, np.nan, 0.03)
    report = live(t, arrival, np.full(10, np.nan)).timing()
    assert not any("motor delay" in remark for remark in report.remarks)
    np.testing.assert_allclose(report.latency[0], 0.03)
    assert np.isnan(report.latency[1:]).all()
    assert np.isnan(report.motor_delay)
    single = live([3.0]).timing()
    assert np.isnan(single.rate)
    assert single.motor_delay == pytest.approx(0.25)


def test_a_simulation_has_no_such_times():
    trace = robsim.Simulation(seed=1).run(3)
    with pytest.raises(NotRecordedError, match="live camera") as caught:
        trace.timing()
    assert caught.value.columns == ("t_arrival", "t_sent")


def test_the_delay_is_that_of_a_world():
    report = live(np.arange(30) * DT, sent=0.48).timing()
    assert robsim.Scenario(motor_delay=report.motor_delay).motor_delay == pytest.approx(2.4)


# --- the schema


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
