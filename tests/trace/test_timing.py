"""The timing of a run: rate, jitter, lost frames, latency."""

import dataclasses

import numpy as np
import pytest

import robsim
from robsim.trace import NotRecordedError, Trace

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
    assert report.input_delay == pytest.approx(0.25)
    assert report.to_dict()["input_delay"] == report.input_delay
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
    assert report.input_delay == pytest.approx(np.median(sent) / DT)


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


def test_what_is_not_known_of_some_steps_and_of_all():
    t = np.arange(10) * DT
    arrival = np.where(t < 1, np.nan, 0.03)
    report = live(t, arrival, np.full(10, np.nan)).timing()
    assert not any("input delay" in remark for remark in report.remarks)
    np.testing.assert_allclose(report.latency[0], 0.03)
    assert np.isnan(report.latency[1:]).all()
    assert np.isnan(report.input_delay)
    single = live([3.0]).timing()
    assert np.isnan(single.rate)
    assert single.input_delay == pytest.approx(0.25)


def test_a_simulation_has_no_such_times():
    trace = robsim.Simulation(seed=1).run(3)
    with pytest.raises(NotRecordedError, match="live camera") as caught:
        trace.timing()
    assert caught.value.columns == ("t_arrival", "t_sent")


def test_the_delay_is_that_of_a_world():
    report = live(np.arange(30) * DT, sent=0.48).timing()
    assert robsim.Scenario(motor_delay=report.input_delay).motor_delay == pytest.approx(2.4)
