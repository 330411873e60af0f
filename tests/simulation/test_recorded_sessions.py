"""An experiment records a session, which another one runs again, to the byte."""

import numpy as np
import pytest

import robsim
from robsim.trace import Session

pytest.importorskip("cv2")


@pytest.fixture(scope="module")
def frames():
    sim = robsim.Simulation(control=robsim.DriveAround(), resolution=(240, 240), seed=1)
    return [sim.step().frame for _ in range(12)]


def control(step):
    x, _, heading = step.measurement.pose
    return x / 1000, heading


@pytest.mark.long
def test_what_is_recorded_runs_again_to_the_byte(frames, tmp_path):
    options = {"control": control, "robot": "lab"}
    with robsim.Experiment(
        frames,
        send=lambda u: None,
        frame_timeout=300,
        record=tmp_path / "session",
        lossless=True,
        **options,
    ) as experiment:
        experiment.run(5)
        trace = experiment.run()
    session = Session(tmp_path / "session")
    assert session.is_complete
    again = robsim.Experiment(session, **options).run()
    for name in ("t", "u", "pose_measured", "pose_held", "interrupted"):
        assert getattr(again, name).tobytes() == getattr(trace, name).tobytes(), name
    assert again.interrupted.any()
    # What the robot got, which is not what other callbacks would have sent.
    other = robsim.Experiment(session, control=lambda step: (9, 9), robot="lab").run()
    np.testing.assert_array_equal(other.last_u[6:], trace.u[5:-1])
    np.testing.assert_array_equal(other.last_u[5], (0, 0))
    assert session.full_trace() == trace


def test_a_session_says_what_it_was_made_with(frames, tmp_path):
    with robsim.Experiment(frames, record=tmp_path / "s", robot="robot2") as experiment:
        experiment.run(3)
    session = Session(tmp_path / "s")
    assert session.setup["robot"] == "robot2"
    assert session.setup["is_live"] is False
    assert (session.area, session.dt) == (experiment.area, experiment.model.dt)
    assert session.colors == [*experiment.colors]
    assert session.markers == experiment.markers
    assert session.model == experiment.model


def test_a_session_is_not_overwritten_nor_begun_again(frames, tmp_path):
    with robsim.Experiment(frames, record=tmp_path / "s") as experiment:
        experiment.run(3)
        with pytest.raises(RuntimeError, match="new Experiment"):
            experiment.reset()
    with pytest.raises(RuntimeError, match="new Experiment"):
        experiment.run(3)
    with pytest.raises(FileExistsError, match=r"s\.mcap"):
        robsim.Experiment(frames, record=tmp_path / "s")


def test_an_error_keeps_what_was_recorded(frames, tmp_path):
    def fails(step):
        return 1 / (4 - step.k), 0

    with (
        pytest.raises(ZeroDivisionError),
        robsim.Experiment(frames, control=fails, record=tmp_path / "s") as experiment,
    ):
        experiment.run()
    session = Session(tmp_path / "s")
    assert session.is_complete
    assert session.count == 4
