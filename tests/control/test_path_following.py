from types import SimpleNamespace

import numpy as np
import pytest

import robsim
from robsim.control import FollowPath, GoToPoint, score_path
from sizes import thorough

pytestmark = pytest.mark.kernels

NOISY = {"resolution": (400, 400), "noise": robsim.GaussianNoise(10), "measure": True}
MODELS = {"slides sideways": None, "does not": robsim.Unicycle()}
SQUARE = [(850, 400), (850, 850), (400, 850), (400, 400)]
TURNS = np.linspace(0, 2 * np.pi, 25)[1:]
EIGHT = 600 + 230 * np.column_stack((np.sin(TURNS), np.sin(2 * TURNS)))


def seen(k, *pose, estimate=None):
    """What a controller sees of step k: a measured pose, or none."""
    measurement = robsim.Measurement(pose) if pose else None
    if estimate is not None:
        estimate = robsim.Estimate(estimate, np.eye(3))
    return SimpleNamespace(k=k, dt=0.2, measurement=measurement, estimate=estimate)


# --- the law, step by step


@pytest.mark.parametrize("heading", [0.0, 1.0, np.pi])
def test_a_goal_ahead_or_behind_is_driven_to_straight(heading):
    along = 300 * np.array([np.cos(heading), np.sin(heading)])
    u1, u2 = GoToPoint(*(600 + along))(seen(0, 600, 600, heading))
    assert u1 == pytest.approx(u2)
    assert u1 == pytest.approx(1.0)
    u1, u2 = GoToPoint(*(600 - along))(seen(0, 600, 600, heading))
    assert u1 == pytest.approx(u2)
    assert u1 == pytest.approx(-1.0)


def test_a_goal_to_the_right_lets_the_left_wheel_go_faster():
    # y points down: larger y is to the right of a robot that faces +x
    u1, u2 = GoToPoint(900, 700)(seen(0, 600, 600, 0.0))
    assert u1 > u2 > 0
    u1, u2 = GoToPoint(900, 500)(seen(0, 600, 600, 0.0))
    assert u2 > u1 > 0
    # behind and to the right: backwards, tail to the right, so it turns to the left
    u1, u2 = GoToPoint(300, 700)(seen(0, 600, 600, 0.0))
    assert u1 < u2 < 0


def test_at_the_goal_the_motors_rest():
    control = GoToPoint(600, 600)
    for k in range(5):
        assert control(seen(k, 602, 597, 1.0)) == (0.0, 0.0)


def test_turning_comes_before_driving():
    u1, u2 = GoToPoint(600 + 10, 900, heading_gain=50)(seen(0, 600, 600, 0.0))
    assert (u1, u2) == (1.0, -1.0)
    u1, u2 = GoToPoint(900, 900, heading_gain=0.5)(seen(0, 600, 600, 0.0))
    assert u1 == pytest.approx(1.0)
    assert u1 - u2 == pytest.approx(2 * 0.5 * np.pi / 4)


def test_a_sideways_slide_is_braked():
    control = GoToPoint(1000, 600)
    for k in range(10):
        u1, u2 = control(seen(k, 600, 500 + 4.0 * k, 0.0))  # slides to the right, 20 px/s
    assert u2 > u1


@pytest.mark.parametrize("gap", [1, 2, 4])
def test_speed_is_per_time_even_when_steps_are_missed(gap):
    # At the wanted speed there is nothing to do; taken for faster, the robot would brake.
    control = GoToPoint(10_000, 0, maximum_speed=20)
    for k in range(0, 60, gap):
        u = control(seen(k, 4.0 * k, 0, 0.0))
        for missed in range(k + 1, k + gap):
            assert control(seen(missed)) == (0.0, 0.0)
    assert u == (0.0, 0.0)


def test_a_turn_through_half_a_turn_is_a_small_one():
    control = GoToPoint(0, 600)
    control(seen(0, 600, 600, np.pi - 0.01))
    u1, u2 = control(seen(1, 600, 600, -np.pi + 0.01))
    assert abs(u1 - u2) < 0.1


def test_a_pose_of_long_ago_says_nothing_of_the_speed():
    control = GoToPoint(900, 500)
    control(seen(0, 100, 100, 0.0))
    assert control(seen(50, 600, 600, 0.0)) == GoToPoint(900, 500)(seen(50, 600, 600, 0.0))
    # asked again at the same step, it answers the same
    assert control(seen(50, 600, 600, 0.0)) == GoToPoint(900, 500)(seen(50, 600, 600, 0.0))


@pytest.mark.parametrize("make", [GoToPoint, lambda x, y: FollowPath([(x, y)])])
def test_a_robot_that_is_not_seen_coasts(make):
    control = make(900, 300)
    assert control(seen(0)) == (0.0, 0.0)
    assert control(seen(1, 600, 600, 0.0)) != (0.0, 0.0)
    assert control(seen(2)) == (0.0, 0.0)


def test_the_estimate_comes_before_the_measurement():
    facing_goal, facing_away = (600, 600, 0.0), (600, 600, np.pi)
    control = GoToPoint(900, 600)
    assert control(seen(0, *facing_away, estimate=facing_goal)) == (1.0, 1.0)
    assert GoToPoint(900, 600)(seen(0, estimate=facing_goal)) == (1.0, 1.0)
    assert GoToPoint(900, 600)(seen(0, *facing_away)) == pytest.approx((-1.0, -1.0))


@pytest.mark.long
@pytest.mark.parametrize("maximum_voltage", [0.1, 2.7])
def test_no_voltage_is_above_the_limit(maximum_voltage, rng):
    controls = [
        GoToPoint(600, 600, maximum_voltage=maximum_voltage),
        FollowPath(rng.uniform(0, 1200, (5, 2)), maximum_voltage=maximum_voltage),
        GoToPoint(
            600, 600, maximum_voltage=maximum_voltage, heading_gain=30, speed_gain=20, turn_gain=9
        ),
    ]
    largest = np.zeros(3)
    for k in range(300):
        pose = (*rng.uniform(0, 1200, 2), rng.uniform(-np.pi, np.pi))
        u = np.abs([control(seen(k, *pose)) for control in controls])
        assert u.max() <= maximum_voltage
        largest = np.maximum(largest, u.max(axis=1))
    np.testing.assert_allclose(largest, maximum_voltage)


# --- the memory of a path


def test_a_path_heads_for_its_waypoints_one_after_the_other():
    control = FollowPath([(100, 0), (100, 100), (0, 100)], waypoint_radius=20)
    places = [((0, 0), 0), ((100, 90), 0), ((85, 0), 1), ((90, 90), 2)]
    for k, (place, next_waypoint) in enumerate(places):
        control(seen(k, *place, 0.0))
        assert control.next_waypoint == next_waypoint
    # the last one stays the last
    assert control(seen(30, 0, 100, 0.0)) == (0.0, 0.0)
    assert control.next_waypoint == 2


@pytest.mark.parametrize("first", [(), (0, 0, 0.0)])
def test_a_path_starts_anew_with_a_new_run(first):
    control = FollowPath([(100, 0), (100, 100)])
    control(seen(5, 100, 0, 0.0))
    assert control.next_waypoint == 1
    # the robot may not be seen at step 0; and a run may be entered later, as long as time goes back
    control(seen(0, *first))
    control(seen(3, 0, 0, 0.0))
    assert control.next_waypoint == 0
    control(seen(9, 100, 0, 0.0))
    control(seen(8, 0, 0, 0.0))
    assert control.next_waypoint == 0


def test_a_long_dropout_does_not_start_a_path_anew():
    control = FollowPath([(100, 0), (100, 100)])
    control(seen(0, 100, 0, 0.0))
    control(seen(100, 60, 60, 0.0))
    assert control.next_waypoint == 1


def test_the_first_line_begins_where_the_robot_is_first_seen():
    # On the line from (0, 0) to (1000, 0), and pushed off it: back towards it, y upwards.
    control = FollowPath([(1000, 0)], speed_gain=1.0, lookahead=30)
    control(seen(7, 0, 0, 0.0))
    u1, u2 = control(seen(60, 500, 40, 0.0))
    assert u2 > u1
    u1, u2 = FollowPath([(1000, 0)], speed_gain=1.0, lookahead=30)(seen(60, 500, 40, 0.0))
    assert abs(u1 - u2) < 0.2


CORNERS = {
    # what comes after the line from (0, 0) to (100, 0), and what the robot at (70, 0) does there
    "a gentle corner": ([(200, 50)], "drives on"),
    "a sharp corner": ([(100, 100)], "slows down"),
    "back again": ([(0, 0)], "slows down"),
    "the end": ([], "slows down"),
    "twice the same": ([(100, 0), (200, 0)], "slows down"),
}


@pytest.mark.parametrize("corner", CORNERS)
def test_it_slows_down_at_the_end_and_at_sharp_corners_only(corner):
    after, expected = CORNERS[corner]
    control = FollowPath([(100, 0), *after], lookahead=60, maximum_voltage=9)
    control(seen(0, 0, 0, 0.0))
    drive = sum(control(seen(20, 70, 0, 0.0))) / 2
    # speed_gain distance_gain = 0.05 V/px
    assert drive == pytest.approx(0.05 * {"drives on": 60, "slows down": 30}[expected], rel=0.1)


def test_off_the_line_it_comes_back_before_it_goes_round_a_corner():
    control = FollowPath([(100, 0), (200, 50)], lookahead=60, waypoint_radius=20)
    control(seen(0, 0, 0, 0.0))
    # past the waypoint, without having reached it: backwards
    assert sum(control(seen(20, 150, 25, 0.0))) < 0
    assert control.next_waypoint == 0


OPTIONS = (
    *("maximum_voltage", "maximum_speed", "distance_gain", "speed_gain", "heading_gain"),
    *("turn_gain", "minimum_voltage"),
)


def test_what_is_no_path():
    for name in OPTIONS:
        for wrong in (-0.1, np.nan, np.inf):
            with pytest.raises(ValueError, match=f"^{name} must"):
                GoToPoint(1, 2, **{name: wrong})
            with pytest.raises(ValueError, match=f"^{name} must"):
                FollowPath([(1, 2)], **{name: wrong})
    for name, wrong in (("waypoint_radius", -1), ("lookahead", np.nan)):
        with pytest.raises(ValueError, match=f"^{name} must"):
            FollowPath([(1, 2)], **{name: wrong})
    for waypoints in ([], [1, 2], [(1, 2, 3)], [(1e200, 0)]):
        with pytest.raises(ValueError, match="waypoints must"):
            FollowPath(waypoints)
    with pytest.raises(ValueError, match="x must"):
        GoToPoint(np.nan, 2)


# --- in the loop


def assert_goes_to(trace, goal):
    distance = np.hypot(*(trace.pose_true[:, :2] - goal).T)
    near = np.flatnonzero(distance <= 15)
    assert len(near), distance[-1]
    assert near[0] < 250
    assert (distance[near[0] :] <= 20).all()


@pytest.mark.long
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", range(thorough(3, 1)))
def test_it_goes_to_a_point_and_stays_there(seed, model):
    goal = np.random.default_rng(seed).uniform(150, 1050, 2)
    control = GoToPoint(*goal)
    trace = robsim.Simulation(
        start="random", seed=seed, control=control, evaluate_model=MODELS[model], **NOISY
    ).run(280)
    assert_goes_to(trace, goal)
    assert np.abs(trace.u).max() <= 1.0


@pytest.mark.long
@pytest.mark.parametrize(
    ("path", "steps", "model"), [(SQUARE, 560, "slides sideways"), (EIGHT, 620, "does not")]
)
def test_it_follows_a_path(path, steps, model):
    start = (*path[-1], 0.5)
    trace = robsim.Simulation(
        start=start, seed=1, control=FollowPath(path), evaluate_model=MODELS[model], **NOISY
    ).run(steps)
    score = score_path(trace, path)
    assert score.reached == score.waypoints == len(path)
    assert score.rmse < 9
    assert score.max_error < 30
    assert score.final_distance < 20
    assert np.abs(trace.u).max() <= 1.0
