"""What reading a slot gives, and what is told when one is set or used wrongly."""

import copy
import functools
import operator
import pickle

import numpy as np
import pytest

import robsim
from robsim import Experiment, Simulation

FRAME = robsim.Frame(np.zeros((60, 60, 3), np.uint8))
SIZE = (60, 60)
ESTIMATE = robsim.Estimate((0, 0, 0), np.eye(3))


def drive(step):
    return 0.1, 0.2


class Driver:
    def __call__(self, step):
        return 0.1, 0.2

    def drive(self, step):
        return 0.1, 0.2


def test_an_experiment_has_the_slots_of_the_robot_half():
    world_half = {"adjust_background", "evaluate_model"}
    assert set(Simulation.SLOTS) - set(Experiment.SLOTS) == world_half
    for name in Simulation.SLOTS:
        assert hasattr(Simulation(), name)
        assert hasattr(Experiment([FRAME], area=SIZE), name) == (name not in world_half)


def test_the_stages_of_a_step_run_in_the_order_of_the_table():
    sim = Simulation(
        estimate_parameters=lambda step: None,
        measure=lambda step: None,
        estimate_state=lambda step: ESTIMATE,
    )
    in_step = ["estimate_parameters", "measure", "estimate_state", "control"]
    assert [sim.step_stage() for _ in range(5)] == ["world", *in_step]


def test_reading_a_slot_gives_its_callback_back():
    sim = Simulation(control=drive)
    assert sim.control.callback is drive
    assert sim.control == drive
    assert sim.control != Driver().drive
    goal = robsim.GoToPoint(900, 300)
    sim.control = goal
    assert sim.control.callback is goal
    sim.measure = True
    assert sim.measure.callback is True
    assert sim.measure == Simulation(measure=True).measure
    assert sim.measure
    assert not sim.estimate_state


def test_a_slot_is_the_decorator_and_returns_the_function():
    sim = Simulation()
    assert sim.control(drive) is drive
    assert sim.control == drive
    assert tuple(sim.run(1).u[0]) == (0.1, 0.2)
    with pytest.raises(TypeError, match="without parentheses"):

        @sim.control()
        def control(step):
            return 0, 0

    for values in ((sim.last_step,), (0.1, 0.2)):
        with pytest.raises(TypeError, match=r"sim\.control"):
            sim.control(*values)


async def drive_later(step):
    return 0.1, 0.2


def drive_on(step):
    yield 0.1, 0.2


class NoCall:
    def control(self, step):
        return 0.1, 0.2


class NoSelf:
    def __call__(step):
        return 0.1, 0.2


WRONG = [
    (3, "callable"),
    (True, "True"),
    (False, "False"),
    (Driver, "Driver is a class"),
    (robsim.RecursiveLeastSquares(5, n_filters=3), "callable"),
    (lambda: (0, 0), r"one argument, step, .*test_slots\.py:\d+"),
    (lambda step, *, more: (0, 0), "one argument"),
    (drive_later, r"drive_later is an async function.*test_slots\.py:\d+"),
    (functools.partial(drive_later), "drive_later is an async function"),
    (drive_on, "drive_on is a generator function"),
    (NoCall(), "NoCall.*__call__.*its method control"),
    (NoSelf(), r"NoSelf.__call__.*test_slots\.py:\d+.*needs self"),
    ((0.1, 0.2), "itself, not its result"),
]
RIGHT = [
    *(drive, Driver(), Driver().drive, lambda *a: (0, 0), lambda step=None: (0, 0), min),
    *(lambda step, more=3, *, other=4: (0, 0), functools.partial(lambda a, step: (0, 0), 1)),
    *(functools.lru_cache(drive), robsim.Spin(), robsim.GoToPoint(3, 4), operator.itemgetter(0)),
]
DOORS = [
    lambda value: Simulation(control=value),
    lambda value: Experiment([], control=value),
    lambda value: setattr(Simulation(), "control", value),
    lambda value: Simulation().control(value),
]


@pytest.mark.long
@pytest.mark.parametrize("set_slot", DOORS)
def test_what_is_no_controller_is_told_when_it_is_set(set_slot):
    for wrong, words in WRONG:
        if set_slot is DOORS[-1] and "callable" not in words:
            words = ""  # it says what the decorator is for
        with pytest.raises(TypeError, match=rf"(?s)\bcontrol\b.*{words}"):
            set_slot(wrong)
    for right in RIGHT:
        set_slot(right)


def test_other_slots_are_checked_by_their_own_arguments():
    estimator = robsim.RecursiveLeastSquares(5, n_filters=3)
    for slot, wrong, words in (
        ("define_model", lambda x: None, "no argument"),
        ("define_model", Driver, "Driver is a class"),
        ("init_parameter_estimator", Driver, "one argument, model"),
        ("estimate_parameters", estimator, "init_parameter_estimator"),
        *((slot, True, "True") for slot in ("evaluate_model", "estimate_state", "define_model")),
        *((slot, False, "") for slot in ("evaluate_model", "adjust_background")),
    ):
        with pytest.raises(TypeError, match=rf"\b{slot}\b.*{words}"):
            Simulation(**{slot: wrong})
    Simulation(estimate_parameters=True, measure=True, define_model=robsim.RobotModel)
    Simulation(estimate_parameters=False, measure=False, estimate_state=False)


def test_an_estimator_that_is_none_is_told_at_the_start():
    class Mine:
        def update(self, phi):
            pass

    for made, words in (
        (Mine(), r"Mine.*update\(phi\)"),
        (robsim.RecursiveLeastSquares, "class RecursiveLeastSquares"),
        (3, r"int.*update\(phi, y\)"),
        (None, "None"),
    ):
        sim = Simulation(init_parameter_estimator=lambda model, made=made: made)
        with pytest.raises(TypeError, match=words) as caught:
            sim.run(1)
        assert len(sim.trace) == 0
        failed = caught.value.callback
        assert (failed.slot, failed.k) == ("init_parameter_estimator", None)


GOAL = {"control": robsim.GoToPoint(900, 300)}


def test_a_controller_without_what_it_needs_is_told_before_the_first_step():
    with pytest.raises(ValueError, match=r"GoToPoint.*measure=True"):
        Simulation(**GOAL).run(1)
    Simulation(measure=True, **GOAL).run(1)
    Simulation(estimate_state=lambda step: ESTIMATE, **GOAL).run(1)

    class Mine(Driver):
        needs = "parameters"

    with pytest.raises(ValueError, match=r"step\.parameters"):
        Simulation(control=Mine()).run(1)


def test_an_observation_may_bring_what_a_controller_needs():
    with pytest.raises(ValueError, match=r"step\.measurement .* Observation"):
        Experiment([FRAME], area=SIZE, measure=None, **GOAL).run()
    seen = robsim.simulation.Observation(frame=FRAME, measurement=(100, 200, 0))
    assert Experiment([seen], area=SIZE, measure=None, **GOAL).run().u.any()


def raised(**options):
    """The exception that a run ends with."""
    with pytest.raises(Exception) as caught:  # noqa: PT011
        Simulation(**{"seed": 1} | options).run(20)
    return caught.value


def fails(step):
    if step.k == 3:
        return step.k / 0
    return 0, 0


def test_an_exception_says_where_it_came_from():
    error = raised(control=fails)
    assert type(error) is ZeroDivisionError
    assert (error.callback.slot, error.callback.k) == ("control", 3)
    assert error.callback.source.file == __file__
    assert error.callback.source.text == "return step.k / 0"
    assert error.callback.source.function == "fails"
    again = pickle.loads(pickle.dumps(error))
    assert again.callback == error.callback


def test_a_bad_result_is_a_callback_error_of_its_type():
    error = raised(control=lambda step: "no")
    assert isinstance(error, robsim.simulation.CallbackTypeError)
    assert isinstance(error, (TypeError, robsim.simulation.CallbackError))
    assert (error.callback.slot, error.callback.k) == ("control", 0)
    assert error.callback.source.function == "<lambda>"
    error = raised(define_model=lambda: 3)
    assert (error.callback.slot, error.callback.k) == ("define_model", None)
    error = raised(evaluate_model=lambda world: (1, 2))
    assert isinstance(error, robsim.simulation.CallbackValueError)
    assert isinstance(error, ValueError)
    assert copy.copy(error).callback == error.callback


def test_in_a_simulation_inside_a_callback_the_inner_place_counts():
    def outer(step):
        Simulation(control=fails).run(20)

    error = raised(estimate_parameters=outer)
    assert error.callback.slot == "control"
    assert error.__notes__ == [
        "in the callback control at step 3", "in the callback estimate_parameters at step 0"
    ]  # fmt: skip


def test_frames_and_send_are_places_too():
    def frames():
        yield FRAME
        raise OSError("gone")

    with pytest.raises(OSError, match="gone") as caught:
        Experiment(frames(), area=SIZE).run()
    assert (caught.value.callback.slot, caught.value.callback.k) == ("frames", 1)
    assert caught.value.callback.source.text == 'raise OSError("gone")'


def reads_measurement(step):
    return step.measurement.pose[:2]


def reads_parameters(step):
    return step.parameters[0][:2]


@pytest.mark.long
def test_a_step_that_lacks_what_is_used_says_why():
    lost = {"control": reads_measurement, "measure": True, "dropout": robsim.Dropout(0.9)}
    for options, reason in (
        ({"control": reads_measurement}, "step.measurement is None: the measurement is off"),
        ({"control": reads_measurement, "measure": lambda step: None},
         "step.measurement is None: the robot was not seen"),
        (lost, "step.measurement is None: the robot was not seen in this step: no blue blob"),
        ({"estimate_parameters": reads_measurement, "measure": True},
         "step.measurement is None: measure comes after estimate_parameters"),
        ({"control": lambda step: step.estimate.pose[:2]},
         "step.estimate is None: there is no state estimator"),
        ({"control": reads_parameters, "estimate_parameters": True},
         "step.parameters is None: no parameters have been estimated yet"),
        ({"estimate_parameters": lambda step: step.sample.phi}, "step.sample is None"),
    ):  # fmt: skip
        notes = raised(**options).__notes__
        assert len(notes) == 2, reason
        assert notes[1].startswith(reason)
    for control in (lambda step: None.pose, lambda step: [][step.measurement is None]):
        assert len(raised(control=control).__notes__) == 1


def sets_input(step):
    step.u = 0.1, 0.2


def takes_a_row_for_the_sample(step):
    if step.sample is not None:
        np.eye(3) @ step.sample.phi[0]


@pytest.mark.long
def test_what_was_used_wrongly_says_what_it_has():
    for options, note in (
        ({"control": lambda step: step.pose}, "step.measurement.pose"),
        ({"control": lambda step: (step.pose_true[0], 0)}, "the truth"),
        (
            {"control": lambda step: step.mesurement.pose[:2]},
            "did you mean 'measurement'?",
        ),
        ({"evaluate_model": lambda world: world.pose}, "a WorldState has dt, k, last_u, model, "),
        ({"control": lambda step: step.measurement[0]}, "a Measurement has "),
        ({"control": sets_input}, "read-only"),
        ({"estimate_parameters": takes_a_row_for_the_sample}, "phi of shape (3, 5)"),
    ):
        notes = raised(**{"measure": True, **options}).__notes__
        assert len(notes) == 2, note
        assert note in notes[1]


def test_a_name_that_is_none_is_told_with_the_closest():
    sim = Simulation()
    with pytest.raises(AttributeError, match="control"):
        _ = sim.controler
    with pytest.raises(AttributeError, match="noise"):
        sim.nosie = 3
    with pytest.raises(AttributeError, match="run"):
        sim.run = 3
    with pytest.raises(TypeError, match=r"'mesure'.*'measure'"):
        Simulation(mesure=True)


def test_an_attribute_error_of_a_callback_that_an_attribute_calls_reaches_the_user():
    sim = Simulation(define_model=lambda: None.theta)
    with pytest.raises(AttributeError, match="'NoneType'"):
        _ = sim.model


def test_a_simulation_can_be_neither_copied_nor_pickled():
    for how in (copy.copy, copy.deepcopy, pickle.dumps):
        for thing in (Simulation(), Experiment([FRAME], area=SIZE)):
            with pytest.raises(TypeError, match=type(thing).__name__):
                how(thing)
