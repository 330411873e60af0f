import numpy as np
import pytest

import robsim
from robsim.control import PoseScore, score_pose

NAN = np.nan


def trace_of(poses, *, measured=None, u=(0.3, 0.4)):
    poses = np.asarray(poses, dtype=float)
    groups = {
        "pose_true": poses,
        "u": np.broadcast_to(np.asarray(u, dtype=float), (len(poses), 2)),
        "bounced": np.zeros((len(poses), 1)),
    }
    if measured is not None:
        groups["pose_measured"] = np.asarray(measured, dtype=float)
    return robsim.Trace(groups, robsim.trace.RunInfo(dt=0.2, theta_true=np.zeros((3, 5))))


def test_errors_are_those_at_the_end_and_headings_turn_around():
    score = score_pose(trace_of([(0, 0, 0), (103, 46, np.pi - 0.05)]), (100, 50, 0.05 - np.pi))
    assert score == PoseScore(
        source="truth",
        final_distance=5.0,
        final_heading_error=pytest.approx(-0.1),
        settled_step=1,
        settling_time=pytest.approx(0.2),
        overshoot=0.0,
        effort=pytest.approx(np.sqrt(0.125)),
    )


def test_it_settles_where_it_stays_within_both_tolerances():
    poses = [(0, 0, 0), (100, 50, 0), (100, 50, 0.3), (100, 76, 0), (90, 50, 0), (100, 50, 0.1)]
    trace = trace_of(poses)
    assert score_pose(trace, (100, 50, 0)).settled_step == 4
    assert score_pose(trace, (100, 50, 0), position_tolerance=26).settled_step == 3
    wide = score_pose(trace, (100, 50, 0), position_tolerance=26, heading_tolerance=0.3)
    assert wide.settled_step == 1
    never = score_pose(trace, (100, 50, 0), heading_tolerance=0.05)
    assert (never.settled_step, never.verdict) == (None, "not settled")
    assert score_pose(trace_of(poses[1:2]), (100, 50, 0)).settled_step == 0


def test_settling_takes_the_time_since_the_first_step_of_the_trace():
    poses = [(0, 0, 0), (100, 50, 0), (100, 80, 0), (100, 50, 0), (100, 50, 0)]
    score = score_pose(trace_of(poses), (100, 50, 0))
    assert (score.settled_step, score.settling_time) == (3, pytest.approx(0.6))
    assert score_pose(trace_of(poses)[1:], (100, 50, 0)).settling_time == pytest.approx(0.4)
    assert score_pose(trace_of(poses), (100, 50, 0.5)).settling_time is None


def test_the_overshoot_is_beyond_the_tolerance_after_the_first_arrival():
    poses = [(0, 0, 0), (90, 50, 0), (140, 50, 0), (96, 50, 0), (60, 50, 0)]
    trace = trace_of(poses)
    assert score_pose(trace, (100, 50, 0), position_tolerance=15).overshoot == 25
    assert score_pose(trace, (100, 50, 0), position_tolerance=5).overshoot == 35
    assert score_pose(trace, (100, 50, 0), position_tolerance=60).overshoot == 0
    assert score_pose(trace, (100, 50, 0), position_tolerance=1).overshoot is None


def test_without_truth_the_measured_poses_count_where_there_are_any():
    unknown = np.full((3, 3), NAN)
    measured = [(0, 0, 0), (100, 50, 0), (NAN, NAN, NAN)]
    score = score_pose(trace_of(unknown, measured=measured), (100, 50, 0))
    assert (score.source, score.settled_step, score.final_distance) == ("measurement", 1, 0)
    with pytest.raises(robsim.trace.NotRecordedError):
        score_pose(trace_of(unknown), (100, 50, 0))


def test_lengths_are_those_of_the_trace():
    sim = robsim.Simulation(area=(300, 300), seed=1, control=robsim.Spin(0.4))
    trace = sim.run(20)
    there = (*trace.pose_true[-1, :2] + (3, 4), trace.pose_true[-1, 2])
    one = score_pose(trace, there)
    assert one.final_distance == pytest.approx(5)
    mm = trace.in_unit("mm", mm_per_px=2.0)
    other = score_pose(mm, there)
    assert other.final_distance == pytest.approx(10)
    assert (other.unit, other.settled_step) == ("mm", one.settled_step)


def test_wrong_input_is_told():
    for pose in ((1, 2), (1, 2, NAN)):
        with pytest.raises(ValueError, match="pose must"):
            score_pose(trace_of([(0, 0, 0)]), pose)
    with pytest.raises(ValueError, match="position_tolerance"):
        score_pose(trace_of([(0, 0, 0)]), (0, 0, 0), position_tolerance=-1)
    with pytest.raises(ValueError, match="heading_tolerance"):
        score_pose(trace_of([(0, 0, 0)]), (0, 0, 0), heading_tolerance=-1)
