import traceback

import numpy as np
import pytest

import robsim

SMALL = {"resolution": (240, 240)}
GOOD = {
    "evaluate_model": lambda world: world.pose_1,
    "estimate_parameters": lambda step: None,
    "measure": lambda step: None,
    "estimate_state": lambda step: robsim.Estimate((0, 0, 0), np.eye(3)),
    "control": lambda step: (0.0, 0.0),
}


def failing_at_5(slot, result):
    """A simulation whose callback gives a bad result, or raises it, at step 5."""

    def my_callback(step):
        if step.k < 5:
            return GOOD[slot](step)
        if isinstance(result, Exception):
            raise result
        return result

    return robsim.Simulation(**{slot: my_callback}, **SMALL), my_callback


@pytest.mark.parametrize("slot", GOOD)
def test_an_exception_reaches_the_user_as_it_is_with_a_note(slot):
    mistake = ZeroDivisionError("my own mistake")
    sim, _ = failing_at_5(slot, mistake)
    with pytest.raises(ZeroDivisionError, match="my own mistake") as caught:
        sim.run(20)
    assert caught.value is mistake
    assert f"in the callback {slot} at step 5" in caught.value.__notes__
    text = "".join(traceback.format_exception(caught.value))
    assert "test_callbacks.py" in text
    assert "raise result" in text
    assert len(sim.trace) == 5
    assert np.isfinite(sim.trace.pose_true).all()


BAD = {
    "evaluate_model": [None, (1.0, 2.0), (1.0, np.nan, 0.0)],
    "estimate_parameters": [np.zeros(15), np.full((3, 5), np.nan), 1.0],
    "measure": [(1.0, 2.0), (1.0, np.inf, 0.0), True],
    "estimate_state": [None, (0, 0, 0)],
    "control": [None, 1.0, (1.0,), (1.0, 2.0, 3.0), (1.0, np.nan), ("a", "b")],
}


@pytest.mark.parametrize(("slot", "bad"), [(slot, bad) for slot in BAD for bad in BAD[slot]])
def test_a_bad_result_is_named_with_callback_step_and_expectation(slot, bad):
    sim, callback = failing_at_5(slot, bad)
    with pytest.raises((TypeError, ValueError)) as caught:
        sim.run(20)
    message = str(caught.value)
    assert message.startswith(f"in the callback {slot} at step 5: the result must be")
    assert "got" in message
    line = callback.__code__.co_firstlineno
    assert f'test_callbacks.py", line {line}, in my_callback' in message
    assert len(sim.trace) == 5


def test_a_bad_result_at_the_start():
    for slot, bad in (
        ("define_model", None),
        ("adjust_background", None),
        ("adjust_background", np.zeros((5, 5, 3), np.uint8)),
    ):
        sim = robsim.Simulation(**{slot: lambda *arguments, bad=bad: bad})
        with pytest.raises((TypeError, ValueError), match=slot) as caught:
            sim.run(1)
        assert "at the start" in "".join(traceback.format_exception(caught.value))
        assert len(sim.trace) == 0


@pytest.mark.parametrize("slot", ["define_model", "init_parameter_estimator", "adjust_background"])
def test_an_exception_at_the_start_has_a_note_and_the_start_can_be_tried_again(slot):
    calls = []

    def callback(*arguments):
        calls.append(slot)
        if len(calls) == 1:
            raise OSError("not yet")
        return {
            "define_model": robsim.RobotModel,
            "init_parameter_estimator": lambda: robsim.RecursiveLeastSquares(5, n_filters=3),
            "adjust_background": lambda: arguments[0],
        }[slot]()

    sim = robsim.Simulation(**{slot: callback})
    with pytest.raises(OSError, match="not yet") as caught:
        sim.run(1)
    assert f"in the callback {slot} at the start" in caught.value.__notes__
    assert len(sim.run(2)) == 2


def test_a_run_goes_on_with_the_stage_that_failed_and_does_nothing_twice():
    calls = []

    def note(slot, result):
        def callback(step):
            calls.append((slot, step.k))
            return result(step)

        return callback

    def fails_once(step):
        if step.k == 3 and calls.count(("control", 3)) == 1:
            raise ValueError("once")
        return (0.3, 0.1)

    options = {"evaluate_model": lambda w: w.model.predict(w.pose_1, w.pose_2, w.last_u)}
    sim = robsim.Simulation(
        estimate_parameters=note("estimate_parameters", lambda step: None),
        control=note("control", fails_once),
        **options,
    )
    with pytest.raises(ValueError, match="once"):
        sim.run(6)
    trace = sim.run(3)
    assert [k for slot, k in calls if slot == "estimate_parameters"] == [0, 1, 2, 3, 4, 5]
    assert [k for slot, k in calls if slot == "control"] == [0, 1, 2, 3, 3, 4, 5]
    undisturbed = robsim.Simulation(control=lambda step: (0.3, 0.1), **options).run(6)
    np.testing.assert_array_equal(trace.pose_true, undisturbed.pose_true)


def test_an_estimator_object_of_ones_own():
    class Mine:
        def __init__(self, model):
            self.samples = []

        def update(self, phi, y):
            self.samples.append((phi, y))
            return np.full((3, 5), len(self.samples))

    sim = robsim.Simulation(init_parameter_estimator=Mine)
    trace = sim.run(6)
    np.testing.assert_array_equal(trace.parameters[:, 0, 0], [np.nan, np.nan, 1, 2, 3, 4])
    assert sim.last_step.estimator is sim.estimator


def test_filters_of_the_wrong_size_are_refused_at_the_start():
    for n_parameters, n_filters in ((5, 1), (4, 3)):
        filters = robsim.RecursiveLeastSquares(n_parameters, n_filters=n_filters)
        sim = robsim.Simulation(init_parameter_estimator=lambda model, rls=filters: rls)
        with pytest.raises(ValueError, match="n_filters=3 and n_parameters=5"):
            sim.run(1)


def test_further_state_of_another_size_is_an_error():
    sim = robsim.Simulation(
        estimate_state=lambda step: robsim.Estimate((0, 0, 0), np.eye(3), np.zeros(2 + step.k // 3))
    )
    with pytest.raises(ValueError, match=r"estimate_state at step 3: state"):
        sim.run(5)
    assert len(sim.trace) == 3


def test_the_robot_half_cannot_reach_the_truth():
    step = robsim.Simulation(measure=True, estimate_parameters=True, **SMALL).step()
    names = {name for name in dir(step) if not name.startswith("_")}
    assert names == {"k", "t", "dt", "u", "last_u", "frame", "blobs", "measurement", "detection",
                     "estimate", "parameters", "sample", "estimator", "markers",
                     "colors"}  # fmt: skip
    for name in names:
        with pytest.raises(AttributeError):
            setattr(step, name, None)


@pytest.mark.filterwarnings("ignore:.*limit the voltages")
def test_inputs_that_throw_the_robot_out_of_the_world():
    sim = robsim.Simulation(control=lambda step: (1e308, 1e308))
    with pytest.raises((RuntimeError, ValueError), match="beyond all bounds"):
        sim.run(10)
    assert np.isfinite(sim.trace.pose_true).all()


def test_the_step_of_an_estimator_object_is_that_of_the_loop():
    class Fails:
        def update(self, phi, y):
            raise ValueError("mine")

    class Wrong:
        def update(self, phi, y):
            return phi[0]

    options = {"identify_from": "measurement", "measure": lambda step: (1, 2, 3), **SMALL}
    for kind, told in ((Fails, "mine"), (Wrong, r"shape \(3, 5\)")):
        sim = robsim.Simulation(init_parameter_estimator=lambda model, kind=kind: kind(), **options)
        with pytest.raises(ValueError, match=told) as caught:
            sim.run(6)
        assert len(sim.trace) == 3
        assert caught.value.callback.k == 3


def test_an_error_while_a_result_is_read_is_labelled_too():
    class Odd:
        def __array__(self, *arguments, **options):
            raise OSError("odd")

    sim = robsim.Simulation(control=lambda step: Odd())
    with pytest.raises(OSError, match="odd") as caught:
        sim.run(1)
    assert "in the callback control at step 0" in caught.value.__notes__


def test_what_a_callback_keeps_of_a_step_stays_what_it_is():
    steps, frames, blobs = [], [], []

    def control(step):
        if step.k % 3 == 0:
            steps.append(step)
        if step.k % 3 == 1:
            frames.append(step.frame)
        if step.k % 4 == 2:
            blobs.append((step.k, step.blobs["red"][0].centroid.copy(), step.blobs["red"][0]))
        return 0.3, 0.1 * step.k

    sim = robsim.Simulation(
        control=control, measure=True, estimate_parameters=True, resolution=(400, 400), seed=1
    )
    trace = sim.run(13)
    assert [step.k for step in steps] == [0, 3, 6, 9, 12]
    for step in steps:
        np.testing.assert_allclose(step.measurement.pose, trace.pose_measured[step.k])
        if step.k > 1:
            np.testing.assert_array_equal(step.parameters, trace.parameters[step.k])
    assert [frame.index for frame in frames] == [1, 4, 7, 10]
    for frame in frames:
        np.testing.assert_array_equal(frame.image, sim.render_step(frame.index).image)
    for k, centroid, blob in blobs:
        np.testing.assert_array_equal(blob.centroid, centroid)
        np.testing.assert_allclose(3 * centroid + 1, trace.blobs["red"][k, 0])


def test_frames_are_drawn_for_a_callback_that_looks():
    def measure(step):
        if step.k == 2:
            assert step.frame.index == 2

    trace = robsim.Simulation(measure=measure, resolution=(400, 400), seed=1).run(4)
    seen = np.isfinite(trace.blobs["red"][:, 0, 0])
    np.testing.assert_array_equal(seen, [False, False, True, False])


def test_u_cannot_be_read_before_it_is_decided():
    seen = []
    sim = robsim.Simulation(control=lambda step: seen.append(step) or (step.k + 1, 0.5))
    u = sim.run(3).u
    np.testing.assert_array_equal([step.u for step in seen], u)
    for slot in ("estimate_parameters", "measure", "estimate_state", "control"):
        sim = robsim.Simulation(**{slot: lambda step: step.u})
        with pytest.raises(RuntimeError, match=r"step 0.*step\.last_u") as caught:
            sim.run(1)
        assert any(slot in note for note in caught.value.__notes__)


@pytest.mark.long
def test_recursion_is_told_in_few_lines():
    def run():
        robsim.Simulation(control=lambda step: run()).run(1)

    with pytest.raises(RecursionError) as caught:
        run()
    assert caught.value.__notes__ == ["in the callback control at step 0"] * 8


def test_a_motion_that_is_filled_during_a_run_turns_the_samples():
    sim = robsim.Simulation(seed=1, control=robsim.Spin(0.5), **SMALL)
    samples = []

    @sim.estimate_parameters
    def estimate_parameters(step):
        if step.sample is not None:
            samples.append(step.sample.phi)

    sim.run(6)
    sim.evaluate_model = lambda world: world.model.predict(world.pose_1, world.pose_2, world.last_u)
    sim.run(5)
    phi = np.array(samples)
    assert len(phi) > 6
    headings = phi[:, 2, 0]
    np.testing.assert_allclose(phi[:, 0, 4], np.cos(headings), atol=1e-12)
    np.testing.assert_allclose(phi[:, 1, 4], np.sin(headings), atol=1e-12)
