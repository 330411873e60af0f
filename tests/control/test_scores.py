"""The scores of driven paths and reached poses."""

import json

import numpy as np
import pytest

import robsim
from robsim.control import PathScore, PoseScore, score_path, score_pose

# --- paths


NAN = np.nan
L_TURN = [(100, 0), (100, 100)]


def trace_of(places, *, measured=None, u=(0.0, 0.0)):
    """A trace whose true path goes through these places."""
    places = np.asarray(places, dtype=float)
    rows = len(places)
    groups = {
        "pose_true": np.column_stack((places, np.zeros(rows))),
        "u": np.broadcast_to(np.asarray(u, dtype=float), (rows, 2)),
        "bounced": np.zeros((rows, 1)),
    }
    if measured is not None:
        groups["pose_measured"] = np.column_stack(
            (np.asarray(measured, dtype=float), np.zeros(rows))
        )
    return robsim.Trace(groups, robsim.trace.RunInfo(dt=0.2, theta_true=np.zeros((3, 5))))


def test_errors_are_distances_from_the_line():
    score = score_path(trace_of([(0, 0), (30, 3), (60, -4), (100, 0)]), [(100, 0)])
    assert score == PathScore(
        source="truth",
        waypoints=1,
        reached=1,
        completed_step=3,
        rmse=2.5,  # sqrt((0 + 9 + 16 + 0)/4)
        max_error=4.0,
        final_distance=0.0,
        effort=0.0,
    )


def test_a_robot_beyond_the_end_of_its_segment_is_off_the_line():
    score = score_path(trace_of([(0, 0), (130, 40)], u=(1.0, -7.0)), [(100, 0)])
    assert score.effort == 5.0  # the root mean square of both voltages
    assert score.max_error == 50.0
    assert (score.reached, score.completed_step) == (0, None)
    assert score_path(trace_of([(0, 0), (-30, 40)]), [(100, 0)]).max_error == 50.0


def test_waypoints_count_in_order_only():
    assert score_path(trace_of([(0, 0), (100, 100)]), L_TURN).reached == 0
    assert score_path(trace_of([(0, 0), (100, 100), (100, 0)]), L_TURN).reached == 1
    score = score_path(trace_of([(0, 0), (100, 0), (100, 100)]), L_TURN)
    assert (score.reached, score.completed_step) == (2, 2)
    later = trace_of([(0, 50), (0, 0), (50, 0), (100, 0)])[1:]  # keeps its step numbers
    score = score_path(later, [(100, 0)])
    assert (score.completed_step, score.max_error) == (3, 0.0)


def test_a_short_cut_to_a_later_part_of_the_path_is_an_error():
    # (50, 100) lies on the last segment, yet the robot has not been at (100, 0)
    path = [(100, 0), (100, 100), (0, 100)]
    score = score_path(trace_of([(0, 0), (50, 100)]), path)
    assert score.max_error == 100.0


def test_near_a_corner_the_segment_behind_counts_too():
    on_the_line = score_path(trace_of([(0, 0), (80, 0), (90, 0), (100, 10)]), L_TURN)
    assert on_the_line.max_error == 0.0
    assert on_the_line.reached == 1
    # back out of reach of the corner: 40 px from the segment that it should be on
    turned_back = score_path(trace_of([(0, 0), (80, 0), (60, 0)]), L_TURN)
    assert turned_back.max_error == 40.0


def test_after_the_last_waypoint_the_robot_should_stay_there():
    places = [(0, 0), (90, 0), (100, 0), (100, 60)]
    score = score_path(trace_of(places), [(100, 0)])
    assert score.completed_step == 1
    assert score.max_error == score.final_distance == 60.0


def test_reach_decides_what_is_reached():
    trace = trace_of([(0, 0), (80, 0)])
    assert score_path(trace, [(100, 0)]).reached == 1
    assert score_path(trace, [(100, 0)], waypoint_radius=20).reached == 1
    assert score_path(trace, [(100, 0)], waypoint_radius=19).reached == 0


def test_several_waypoints_may_be_reached_at_once():
    score = score_path(trace_of([(0, 0), (100, 0)]), [(0, 0), (5, 0), (5, 0), (90, 0), (100, 0)])
    assert (score.reached, score.completed_step) == (5, 1)
    assert score.rmse == 0.0


def test_waypoints_may_lie_closer_together_than_the_reach():
    x = np.arange(0.0, 100.0, 5.0)
    line = np.column_stack((x, 3 * np.ones_like(x)))
    score = score_path(trace_of(line), np.column_stack((x, 0 * x)), waypoint_radius=25)
    assert score.reached == 20
    assert score.rmse == pytest.approx(np.sqrt(9 * 19 / 20))  # 3 px, but at the start


def test_without_truth_the_measured_path_is_scored():
    nowhere = np.full((4, 2), NAN)
    measured = [(NAN, NAN), (0, 0), (NAN, NAN), (90, 6)]
    score = score_path(trace_of(nowhere, measured=measured, u=(NAN, NAN)), [(100, 0)])
    assert score.source == "measurement"
    assert score.completed_step == 3
    assert score.rmse == pytest.approx(np.sqrt(18))
    assert np.isnan(score.effort)
    assert score.to_dict()["effort"] is None
    both = trace_of([(0, 0), (50, 1)], measured=[(0, 0), (50, 9)])
    assert score_path(both, [(100, 0)]).max_error == 1.0


def test_a_score_reads_as_a_report():
    score = score_path(trace_of([(0, 0), (50, 8), (100, 0)], u=(0.5, 0.5)), L_TURN)
    lines = str(score).splitlines()
    assert lines[0].endswith(": incomplete")
    values = [line.split("   ")[-1].strip() for line in lines[1:9]]
    assert values == ["2", "1", "-", "4.6", "8.0", "100.0", "0.50", "truth"]
    completed = score_path(trace_of([(0, 0), (100, 0)]), [(100, 0)])
    assert (completed.verdict, completed.completed_step) == ("completed", 1)
    assert json.loads(score.to_json()) == {
        "title": "Path through the waypoints",
        "verdict": "incomplete",
        "source": "truth",
        "waypoints": 2,
        "reached": 1,
        "completed_step": None,
        "rmse": pytest.approx(8 / np.sqrt(3)),
        "max_error": 8.0,
        "final_distance": 100.0,
        "effort": 0.5,
        "units": {"rmse": "px", "max_error": "px", "final_distance": "px", "effort": "V"},
        "remarks": list(score.remarks),
    }


def test_small_errors_of_a_robot_that_stands_say_so():
    standing, driving = (
        score_path(trace_of(places), [(100, 0)]) for places in ([(0, 0)] * 3, [(0, 0), (100, 0)])
    )
    assert standing.rmse == driving.rmse == 0
    assert standing.remarks
    assert not driving.remarks


def test_wrong_input_is_named():
    trace = trace_of([(0, 0)])
    for waypoints in ([], [100, 0], [(100, 0, 0)], [(100, 0), (100,)], [(100, NAN)]):
        with pytest.raises(ValueError, match="waypoints must"):
            score_path(trace, waypoints)
    for wrong in (-1, NAN):
        with pytest.raises(ValueError, match="waypoint_radius must"):
            score_path(trace, L_TURN, waypoint_radius=wrong)
    for empty in (trace[:0], trace_of(np.full((4, 2), NAN))):
        with pytest.raises(ValueError, match="no pose_measured"):
            score_path(empty, L_TURN)


# --- poses


def trace_of_poses(poses, *, measured=None, u=(0.3, 0.4)):
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
    score = score_pose(
        trace_of_poses([(0, 0, 0), (103, 46, np.pi - 0.05)]), (100, 50, 0.05 - np.pi)
    )
    assert score == PoseScore(
        source="truth",
        final_distance=5.0,
        final_heading_error=pytest.approx(-0.1),
        settled_step=1,
        settling_time=pytest.approx(0.2),
        held=1,
        overshoot=0.0,
        effort=pytest.approx(np.sqrt(0.125)),
    )


def test_it_settles_where_it_stays_within_both_tolerances():
    poses = [(0, 0, 0), (100, 50, 0), (100, 50, 0.3), (100, 76, 0), (90, 50, 0), (100, 50, 0.1)]
    trace = trace_of_poses(poses)
    assert score_pose(trace, (100, 50, 0)).settled_step == 4
    assert score_pose(trace, (100, 50, 0), position_tolerance=26).settled_step == 3
    wide = score_pose(trace, (100, 50, 0), position_tolerance=26, heading_tolerance=0.3)
    assert wide.settled_step == 1
    never = score_pose(trace, (100, 50, 0), heading_tolerance=0.05)
    assert (never.settled_step, never.verdict) == (None, "not settled")
    assert score_pose(trace_of_poses(poses[1:2]), (100, 50, 0)).settled_step == 0


def test_who_may_only_drive_through_is_told():
    through = score_pose(trace_of_poses([(x, 0, 0) for x in range(0, 400, 10)]), (400, 0, 0))
    stays = [(x, 0, 0) for x in range(0, 400, 10)] + [(400, 0, 0)] * 5
    parked = score_pose(trace_of_poses(stays), (400, 0, 0))
    never = score_pose(trace_of_poses(stays), (0, 0, 0))
    assert (through.held, parked.held, never.held) == (2, 7, 0)
    assert through.remarks
    assert not parked.remarks
    assert not never.remarks


def test_settling_takes_the_time_since_the_first_step_of_the_trace():
    poses = [(0, 0, 0), (100, 50, 0), (100, 80, 0), (100, 50, 0), (100, 50, 0)]
    score = score_pose(trace_of_poses(poses), (100, 50, 0))
    assert (score.settled_step, score.settling_time) == (3, pytest.approx(0.6))
    assert score_pose(trace_of_poses(poses)[1:], (100, 50, 0)).settling_time == pytest.approx(0.4)
    assert score_pose(trace_of_poses(poses), (100, 50, 0.5)).settling_time is None


def test_the_overshoot_is_beyond_the_tolerance_after_the_first_arrival():
    poses = [(0, 0, 0), (90, 50, 0), (140, 50, 0), (96, 50, 0), (60, 50, 0)]
    trace = trace_of_poses(poses)
    assert score_pose(trace, (100, 50, 0), position_tolerance=15).overshoot == 25
    assert score_pose(trace, (100, 50, 0), position_tolerance=5).overshoot == 35
    assert score_pose(trace, (100, 50, 0), position_tolerance=60).overshoot == 0
    assert score_pose(trace, (100, 50, 0), position_tolerance=1).overshoot is None


def test_without_truth_the_measured_poses_count_where_there_are_any():
    unknown = np.full((3, 3), NAN)
    measured = [(0, 0, 0), (100, 50, 0), (NAN, NAN, NAN)]
    score = score_pose(trace_of_poses(unknown, measured=measured), (100, 50, 0))
    assert (score.source, score.settled_step, score.final_distance) == ("measurement", 1, 0)
    with pytest.raises(robsim.trace.NotRecordedError):
        score_pose(trace_of_poses(unknown), (100, 50, 0))


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
    for pose in ((1, 2), (1, 2, NAN), (1, 2, 90)):
        with pytest.raises(ValueError, match="pose must"):
            score_pose(trace_of_poses([(0, 0, 0)]), pose)
    with pytest.raises(ValueError, match="position_tolerance"):
        score_pose(trace_of_poses([(0, 0, 0)]), (0, 0, 0), position_tolerance=-1)
    for tolerance in (-1, 10):
        with pytest.raises(ValueError, match="heading_tolerance"):
            score_pose(trace_of_poses([(0, 0, 0)]), (0, 0, 0), heading_tolerance=tolerance)
