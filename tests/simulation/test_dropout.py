import numpy as np
import pytest

import robsim

OPTIONS = {"measure": True, "resolution": (400, 400), "boundary": "unlimited", "seed": 5}


def test_a_hidden_robot_is_neither_drawn_nor_found():
    sim = robsim.Simulation(
        **OPTIONS, dropout=robsim.Dropout(1.0), adjust_background=lambda background: background
    )
    trace = sim.run(3)
    assert not trace.seen.any()
    assert np.isfinite(trace.pose_true).all()
    assert sim.last_step.blobs == {"red": [], "blue": []}


def test_stretches_are_hidden_with_the_probability():
    sim = robsim.Simulation(**OPTIONS, dropout=robsim.Dropout(0.3, steps=4))
    valid = sim.run(400).seen.reshape(-1, 4)
    assert (valid.all(axis=1) | (~valid).all(axis=1)).all()
    assert 0.2 < 1 - valid.mean() < 0.4


def test_the_path_and_the_other_frames_stay_what_they_are():
    free, hidden = (
        robsim.Simulation(
            **OPTIONS, control=robsim.DriveAround(), dropout=robsim.Dropout(share)
        ).run(100)
        for share in (0.0, 0.5)
    )
    np.testing.assert_array_equal(free.pose_true, hidden.pose_true)
    np.testing.assert_array_equal(
        free.pose_measured[hidden.seen], hidden.pose_measured[hidden.seen]
    )
    assert not hidden.seen.all()


def test_wrong_options():
    for name, arguments in (
        ("probability", (1.0001,)),
        ("probability", (-0.1,)),
        ("probability", (float("nan"),)),
        ("steps", (0.1, 0)),
    ):
        with pytest.raises(ValueError, match=rf"\b{name}\b"):
            robsim.Dropout(*arguments)


@pytest.mark.parametrize("boundary", ["bounce", "unlimited"])
def test_the_frame_of_a_recorded_step_is_the_one_that_was(boundary):
    sim = robsim.Simulation(
        resolution=(300, 200),
        boundary=boundary,
        control=robsim.DriveAround(),
        noise=robsim.UniformNoise(10),
        dropout=robsim.Dropout(0.3),
        measure=True,
        seed=6,
    )
    frames = [sim.step().frame for _ in range(50)]
    for k in (0, 49, 3, 27, 26, 40):
        again = sim.render_step(k)
        assert (again.index, again.t) == (frames[k].index, frames[k].t)
        np.testing.assert_array_equal(again.image, frames[k].image)
        np.testing.assert_array_equal(again.plane_map.matrix, frames[k].plane_map.matrix)
    for k in (-1, 50):
        with pytest.raises(IndexError, match=r"0\.\.49"):
            sim.render_step(k)


def test_step_locator_is_what_the_default_measurement_uses():
    def measure(step):
        return robsim.locate(step.blobs, step.markers, image=step.frame)

    own, default = (
        robsim.Simulation(**{**OPTIONS, "measure": which}).run(10) for which in (measure, True)
    )
    assert own.seen.all()
    np.testing.assert_array_equal(own.pose_measured, default.pose_measured)
