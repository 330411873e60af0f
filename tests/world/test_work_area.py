import numpy as np
import pytest

import robsim


def driven(start, steps=40, **options):
    sim = robsim.Simulation(start=start, control=lambda step: (1.0, 1.0), **options)
    return sim.run(steps)


@pytest.mark.parametrize(
    ("start", "axis", "mirrored"),
    [
        ((1100.0, 600.0, 0.3), 0, np.pi - 0.3),
        ((100.0, 600.0, np.pi - 0.3), 0, 0.3),
        ((600.0, 1100.0, 1.2), 1, -1.2),
        ((600.0, 100.0, -1.2), 1, 1.2),
    ],
)
def test_the_robot_bounces_off_each_wall(start, axis, mirrored):
    trace = driven(start)
    radius = robsim.load_robot().radius
    (bounces,) = np.nonzero(trace.bounced)
    assert len(bounces) == 1
    k = bounces[0]
    low, high = radius - 0.5, 1199.5 - radius
    assert (trace.pose_true[:, :2] >= low - 1e-9).all()
    assert (trace.pose_true[:, :2] <= high + 1e-9).all()
    assert trace.pose_true[k, 2] == pytest.approx(mirrored, abs=1e-6)
    # The last two poses are mirrored together: the speed only changes its sign across the wall.
    step = np.diff(trace.pose_true[:, axis])
    assert np.sign(step[k]) == -np.sign(step[k - 2])
    assert abs(step[k]) == pytest.approx(abs(step[k - 2]), rel=0.15)


def test_a_mirrored_path_is_the_path_of_a_mirrored_robot():
    bounced = driven((1100.0, 600.0, 0.3)).pose_true
    free = driven((1100.0, 600.0, 0.3), boundary="unlimited").pose_true
    wall = 1199.5 - robsim.load_robot().radius
    np.testing.assert_allclose(np.minimum(free[:, 0], 2 * wall - free[:, 0]), bounced[:, 0])
    np.testing.assert_allclose(free[:, 1], bounced[:, 1])


@pytest.mark.parametrize("start", [(1195.0, 600.0, np.pi), (600.0, 4.0, np.pi / 2)])
def test_a_robot_that_starts_beyond_a_wall_comes_in_without_a_bounce(start):
    trace = driven(start)
    free = driven(start, boundary="unlimited")
    np.testing.assert_array_equal(trace.pose_true, free.pose_true)
    assert not trace.bounced.any()


def test_in_the_unlimited_area_nothing_bounces_and_the_view_follows():
    sim = robsim.Simulation(
        boundary="unlimited", measure=True, control=lambda step: (1.0, 0.98), resolution=(480, 480)
    )
    trace = sim.run(300)
    assert not trace.bounced.any()
    assert np.abs(trace.pose_true[:, :2]).max() > 2000
    assert trace.seen.all()
    assert trace.tracking().false_poses == 0
    # whole camera pixels of 2.5 work-area px, moved no more than needed
    np.testing.assert_array_equal(trace.view % 2.5, 0)
    place = trace.pose_true[:, :2] - trace.view
    assert (place > 100).all()
    assert (place < 1100).all()


def test_a_robot_may_start_half_out_of_the_view():
    trace = robsim.Simulation(start=(10.0, 600.0, 0.0), measure=True).run(5)
    assert not trace.bounced.any()
    assert not trace.seen.any()
    assert np.isnan(trace.pose_held).all()


@pytest.mark.filterwarnings("ignore:.*limit the voltages")
def test_a_robot_faster_than_the_room_stays_in_it():
    trace = robsim.Simulation(control=lambda step: (5e3, 4e3)).run(60)
    radius = robsim.load_robot().radius
    assert (trace.pose_true[:, :2] > radius - 1).all()
    assert (trace.pose_true[:, :2] < 1200 - radius).all()


def test_no_pose_is_held_while_nothing_measures():
    sim = robsim.Simulation(measure=True, seed=1)
    sim.run(3)
    sim.measure = False
    sim.run(2)
    sim.measure = True
    trace = sim.run(2)
    held = np.isfinite(trace.pose_held[:, 0])
    assert held.tolist() == [True] * 3 + [False] * 2 + [True] * 2
    assert held.tolist() == trace.seen.tolist()


@pytest.mark.filterwarnings("ignore:.*limit the voltages")
@pytest.mark.parametrize("volts", [1e3, 1e6, 1e100])
def test_no_voltage_takes_the_robot_out_of_the_walls(volts):
    generator = np.random.default_rng(1)
    trace = robsim.Simulation(control=lambda step: volts * generator.normal(size=2)).run(100)
    radius = robsim.load_robot().radius
    assert trace.pose_true[:, :2].min() >= radius - 0.5
    assert trace.pose_true[:, :2].max() <= 1199.5 - radius
