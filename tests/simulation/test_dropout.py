import numpy as np
import pytest

import robsim

OPTIONS = {"measure": True, "camera": (400, 400), "boundary": "unlimited", "seed": 5}


def test_a_hidden_robot_is_neither_drawn_nor_found():
    sim = robsim.Simulation(**OPTIONS, dropout=1.0, adjust_background=lambda background: background)
    trace = sim.run(3)
    assert not trace.valid.any()
    assert np.isfinite(trace.pose_true).all()
    assert sim.last_step.blobs == {"red": [], "blue": []}


def test_stretches_are_hidden_with_the_probability():
    sim = robsim.Simulation(**OPTIONS, dropout=0.3, dropout_steps=4)
    valid = sim.run(400).valid.reshape(-1, 4)
    assert (valid.all(axis=1) | (~valid).all(axis=1)).all()
    assert 0.2 < 1 - valid.mean() < 0.4


def test_the_path_and_the_other_frames_stay_what_they_are():
    free, hidden = (
        robsim.Simulation(**OPTIONS, control=robsim.DriveAround(), dropout=share).run(100)
        for share in (0.0, 0.5)
    )
    np.testing.assert_array_equal(free.pose_true, hidden.pose_true)
    np.testing.assert_array_equal(free.measured[hidden.valid], hidden.measured[hidden.valid])
    assert not hidden.valid.all()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"dropout": 1.5}, ValueError, r"dropout must lie within 0\.\.1, got 1\.5"),
        ({"dropout": -0.1}, ValueError, r"dropout must lie within 0\.\.1"),
        ({"dropout": float("nan")}, ValueError, r"dropout must lie within 0\.\.1"),
        ({"dropout": "much"}, TypeError, r"dropout must be a number, got 'much'"),
        ({"dropout_steps": 0}, ValueError, "dropout_steps must lie within 1"),
        ({"dropout_steps": 2.5}, TypeError, "dropout_steps must be an int"),
    ],
)
def test_wrong_options(options, error, message):
    with pytest.raises(error, match=message):
        robsim.Simulation(**options)


@pytest.mark.parametrize("boundary", ["bounce", "unlimited"])
def test_the_frame_of_a_recorded_step_is_the_one_that_was(boundary):
    sim = robsim.Simulation(
        camera=(300, 200),
        boundary=boundary,
        control=robsim.DriveAround(),
        noise="uniform",
        noise_percent=10,
        dropout=0.3,
        measure=True,
        seed=6,
    )
    frames = [sim.step().frame for _ in range(150)]
    for k in (0, 149, 3, 77, 76, 140):
        again = sim.render_step(k)
        assert (again.index, again.t) == (frames[k].index, frames[k].t)
        np.testing.assert_array_equal(again.image, frames[k].image)
        np.testing.assert_array_equal(again.plane_map.matrix, frames[k].plane_map.matrix)
    for k in (-1, 150):
        with pytest.raises(IndexError, match=r"there are steps 0\.\.149, got k ="):
            sim.render_step(k)


def test_step_locator_is_what_the_default_measurement_uses():
    def measure(step):
        return robsim.locate(step.blobs, step.markers, step.frame.plane_map)

    own, default = (
        robsim.Simulation(**{**OPTIONS, "measure": which}).run(10) for which in (measure, True)
    )
    assert own.valid.all()
    np.testing.assert_array_equal(own.measured, default.measured)
