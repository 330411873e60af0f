"""The table of slots, what reading a slot gives, and what is told when one is set."""

import ast
import copy
import functools
import inspect
import operator
import pickle

import numpy as np
import pytest

import robsim
from package_files import PACKAGE, package_files
from robsim import Experiment, Simulation
from robsim.simulation import _slots as table
from robsim.simulation._callbacks.slot import Slot, SlotHandle
from robsim.simulation._folders.spelling import misspelled
from robsim.simulation._slots import SLOTS

FRAME = robsim.Frame(np.zeros((60, 60, 3), np.uint8))
SIZE = (60, 60)


def drive(step):
    return 0.1, 0.2


class Driver:
    def __call__(self, step):
        return 0.1, 0.2

    def drive(self, step):
        return 0.1, 0.2


def test_each_class_has_the_slots_of_its_halves():
    robot_half = table.names(half=table.ROBOT)
    assert tuple(SLOTS) == Simulation.SLOTS
    assert robot_half == Experiment.SLOTS
    for kind in (Simulation, Experiment):
        assert {name for name in SLOTS if isinstance(getattr(kind, name, None), Slot)} == set(
            kind.SLOTS
        )


@pytest.mark.parametrize(
    ("kind", "callbacks"),
    [(Simulation, table.AllCallbacks), (Experiment, table.RobotCallbacks)],
)
def test_the_signature_and_the_docstring_have_every_slot_of_the_table(kind, callbacks):
    parameters = inspect.signature(kind).parameters
    assert [name for name in parameters if name in SLOTS] == list(kind.SLOTS)
    assert not any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    assert set(inspect.get_annotations(callbacks)) | (
        set(kind.SLOTS) if kind is Simulation else set()
    ) == set(kind.SLOTS)
    for name in kind.SLOTS:
        assert f"\n{name} : " in kind.__doc__
        assert SLOTS[name].call in kind.__doc__
        assert SLOTS[name].call in getattr(kind, name).__doc__


def test_each_slot_has_a_template_and_is_found_when_misspelled():
    assert sorted(file.stem for file in (PACKAGE / "simulation/templates").glob("*.py")) == sorted(
        SLOTS
    )
    for name, slot in SLOTS.items():
        assert misspelled([f"{name}s"]) == {f"{name}s": name}
        for other in slot.other_names:
            assert misspelled([other]) == {other: name}


def lists_of_slots(source):
    """The literals with three names of slots or more."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Tuple, ast.List, ast.Set, ast.Dict)):
            items = node.keys if isinstance(node, ast.Dict) else node.elts
            names = [item.value for item in items if isinstance(item, ast.Constant)]
            if sum(name in SLOTS for name in names if isinstance(name, str)) >= 3:
                yield node.lineno


@pytest.mark.long
def test_no_other_file_lists_the_slots():
    assert list(lists_of_slots("a = ('measure', 'control', 'estimate_state')"))
    found = {
        str(file.relative_to(PACKAGE)): lines
        for file in package_files()
        if (lines := list(lists_of_slots(file.read_text())))
    }
    assert found == {}


def test_the_stages_of_a_step_run_in_the_order_of_the_table():
    sim = Simulation(
        estimate_parameters=lambda step: None,
        measure=lambda step: None,
        estimate_state=lambda step: robsim.Estimate((0, 0, 0), np.eye(3)),
    )
    stages = [sim.step_stage() for _ in range(5)]
    in_step = table.names(half=table.ROBOT, when=table.STEP)
    assert stages == ["world", *in_step]


def test_reading_a_slot_gives_its_callback_back():
    sim = Simulation(control=drive)
    assert sim.control.callback is drive
    assert sim.control == drive
    assert sim.control != Driver().drive
    goal = robsim.GoToPoint(900, 300)
    sim.control = goal
    assert sim.control.callback is goal
    assert repr(sim.control) == f"<slot control: {goal!r}>"
    sim.measure = True
    assert sim.measure.callback is True
    assert sim.measure == Simulation(measure=True).measure
    assert sim.measure
    assert not sim.estimate_state


def test_a_slot_is_the_decorator_and_returns_the_function():
    sim = Simulation()
    assert isinstance(sim.control, SlotHandle)
    assert sim.control(drive) is drive
    assert sim.control == drive
    assert tuple(sim.run(1).u[0]) == (0.1, 0.2)


def test_a_decorator_with_brackets_or_a_step_is_told():
    sim = Simulation()
    with pytest.raises(TypeError, match=r"use @sim\.control, without brackets"):

        @sim.control()
        def control(step):
            return 0, 0

    with pytest.raises(TypeError, match=r"sim\.control\.callback is what is in it"):
        sim.control(sim.last_step)


@pytest.mark.parametrize("set_slot", [lambda value: Simulation(control=value),
                                      lambda value: Experiment([], control=value),
                                      lambda value: setattr(Simulation(), "control", value),
                                      lambda value: Simulation().control(value)])  # fmt: skip
class TestToldWhenSet:
    @pytest.mark.parametrize("kind", [Driver, robsim.GoToPoint, robsim.DriveAround, robsim.Spin])
    def test_a_class(self, set_slot, kind):
        with pytest.raises(TypeError, match=f"{kind.__name__} is a class: give an object of it"):
            set_slot(kind)

    @pytest.mark.parametrize(
        "wrong",
        [lambda: (0, 0), lambda step, more: (0, 0), lambda step, *, more: (0, 0)],
    )
    def test_a_wrong_signature(self, set_slot, wrong):
        with pytest.raises(TypeError, match=r"must take one argument, step, .*test_slots\.py:\d+"):
            set_slot(wrong)

    @pytest.mark.parametrize(
        "right",
        [drive, Driver(), Driver().drive, lambda *a: (0, 0), lambda step=None: (0, 0),
         lambda step, more=3, *, other=4: (0, 0), functools.partial(lambda a, step: (0, 0), 1),
         functools.lru_cache(drive), robsim.Spin(), robsim.GoToPoint(3, 4), min,
         operator.itemgetter(0)],
    )  # fmt: skip
    def test_what_can_be_called_right_is_accepted(self, set_slot, right):
        set_slot(right)


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


class CalledLater:
    async def __call__(self, step):
        return 0.1, 0.2


def with_gain(step, gain):
    return gain, gain


@pytest.mark.parametrize(
    ("wrong", "words"),
    [(drive_later, r"control must return its result, \(u1, u2\), but drive_later is an async "
      r"function: write def in place of async def \(test_slots.py:\d+\)"),
     (functools.partial(drive_later), "drive_later is an async function"),
     (CalledLater(), "CalledLater.__call__ is an async function"),
     (drive_on, "drive_on is a generator function: write return in place of yield"),
     (NoCall(), r"an object of NoCall, which has no method __call__\(self, step\): give its method "
      "control"),
     (NoSelf(), r"got NoSelf.__call__\(\) \(test_slots.py:\d+\): a method needs self before it"),
     (lambda step, other: None, r"control must take one argument, step, got lambda\(step, other\)"),
     (functools.partial(with_gain, gian=1), "with arguments that with_gain does not take"),
     ((0.1, 0.2), r"got \(0.1, 0.2\): give the function control\(step\) itself, not its result"),
     ("control.py", "give the function itself, not its name; from_folder reads files")],
)  # fmt: skip
def test_what_would_never_give_a_result_is_told_when_it_is_set(wrong, words):
    with pytest.raises(TypeError, match=words):
        Simulation(control=wrong)


def test_an_estimator_or_parameters_in_the_wrong_slot_are_told_where_they_belong():
    estimator = robsim.RecursiveLeastSquares(5, n_filters=3)
    for slot in ("init_parameter_estimator", "estimate_parameters"):
        with pytest.raises(TypeError, match=rf"{slot} must be callable.*what init_parameter_estim"):
            Simulation(**{slot: estimator})
    with pytest.raises(TypeError, match=r"define_model must be callable.*as the option model"):
        Simulation(define_model=robsim.RobotParameters())


def test_a_slot_called_with_voltages_says_what_it_is():
    with pytest.raises(
        TypeError, match=r"sim.control takes one callback, got 2 values: the decora"
    ):
        Simulation().control(0.1, 0.2)


@pytest.mark.parametrize(
    ("slot", "wrong", "words"),
    [("define_model", lambda x: None, r"define_model must take no argument, got lambda\(x\)"),
     ("define_model", Driver, "Driver is a class"),
     ("init_parameter_estimator", Driver, r"must take one argument, model, got .*\(\)"),
     ("control", True, "got True: True is for estimate_parameters and measure only"),
     ("control", False, "control must be callable, got False")],
)  # fmt: skip
def test_other_slots_are_checked_by_their_own_arguments(slot, wrong, words):
    with pytest.raises(TypeError, match=words):
        Simulation(**{slot: wrong})


def test_a_class_that_makes_the_result_is_a_callback():
    class Mine:
        def __init__(self, model):
            self.model = model

        def update(self, phi, y):
            return np.ones((3, 5))

    sim = Simulation(init_parameter_estimator=Mine, define_model=robsim.RobotModel)
    sim.run(5)
    assert isinstance(sim.estimator, Mine)


def test_an_update_with_other_arguments_is_told_at_the_start():
    class Mine:
        def update(self, phi):
            pass

    sim = Simulation(init_parameter_estimator=lambda model: Mine())
    with pytest.raises(TypeError, match=r"of class Mine, .* got method update\(phi\) \(test_slots"):
        sim.run(1)
    assert len(sim.trace) == 0


def test_the_model_is_set_by_its_slot():
    sim = Simulation()
    with pytest.raises(AttributeError, match=r"fill define_model, then call sim\.reset\(\)"):
        sim.model = robsim.RobotModel()


def test_a_misspelled_slot_is_suggested():
    with pytest.raises(TypeError, match=r"has no option 'mesure': did you mean 'measure'\?"):
        Simulation(mesure=True)


GOAL = {"control": robsim.GoToPoint(900, 300)}


def test_a_controller_without_what_it_needs_is_told_before_the_first_step():
    with pytest.raises(ValueError, match=r"control=GoToPoint.* needs .*; give measure=True$"):
        Simulation(**GOAL).run(1)
    Simulation(measure=True, **GOAL).run(1)
    estimate = robsim.Estimate((0, 0, 0), np.eye(3))
    Simulation(estimate_state=lambda step: estimate, **GOAL).run(1)


def test_a_callback_of_ones_own_may_say_what_it_needs():
    class Mine(Driver):
        needs = "parameters"

    with pytest.raises(ValueError, match=r"needs step\.parameters: no parameter estimator is on"):
        Simulation(control=Mine()).run(1)
    Simulation(control=Mine(), estimate_parameters=True).run(1)


def test_an_observation_may_bring_what_a_controller_needs():
    with pytest.raises(ValueError, match=r"needs step\.measurement .* Observation"):
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


def unpacks_measurement(step):
    pose = step.measurement
    x, y = pose
    return x, y


def estimate(step):
    return step.estimate.pose[:2]


@pytest.mark.parametrize(
    ("options", "reason"),
    [({"control": reads_measurement}, "step.measurement is None: no measurement is on; give"),
     ({"control": unpacks_measurement}, "step.measurement is None: no measurement is on; give"),
     ({"control": reads_measurement, "measure": lambda step: None},
      "step.measurement is None: the robot was not seen in this step"),
     ({"control": reads_measurement, "measure": True, "dropout": robsim.Dropout(0.9)},
      "step.measurement is None: the robot was not seen in this step: no blue blob was detected"),
     ({"estimate_parameters": reads_measurement, "measure": True},
      "step.measurement is None: measure comes after estimate_parameters in a step"),
     ({"control": estimate}, "step.estimate is None: there is no state estimator; give"),
     ({"control": lambda step: step.parameters[0][:2]},
      "step.parameters is None: no parameter estimator is on; give"),
     ({"control": lambda step: step.parameters[0][:2], "estimate_parameters": True},
      "step.parameters is None: no parameters have been estimated yet"),
     ({"estimate_parameters": lambda step: step.sample.phi}, "step.sample is None: there is no"),
     ({"measure": lambda step: step.detection.measurement},
      "step.detection is None: only the default measurement, measure=True, makes one"),
     ({"measure": reads_measurement}, "step.measurement is None: it is what this callback")],
)  # fmt: skip
def test_a_step_that_lacks_what_is_used_says_why(options, reason):
    error = raised(**options)
    assert len(error.__notes__) == 2
    assert error.__notes__[1].startswith(reason)


@pytest.mark.parametrize(
    "control",
    [lambda step: None.pose, lambda step: [][step.measurement is None],
     lambda step: (step.measurement is None).pose, lambda step: len(3)],
)  # fmt: skip
def test_what_is_not_the_cause_is_not_told(control):
    assert len(raised(control=control).__notes__) == 1


def sets_input(step):
    step.u = 0.1, 0.2


def sets_array(step):
    step.measurement.pose[2] = 0


def takes_a_row_for_the_sample(step):
    if step.sample is not None:
        np.eye(3) @ step.sample.phi[0]


@pytest.mark.parametrize(
    ("options", "note"),
    [({"control": lambda step: step.pose}, "did you mean step.measurement.pose?"),
     ({"control": lambda step: step.image}, "did you mean step.frame.image?"),
     ({"control": lambda step: step.pose_true}, "the truth is not for the robot's software"),
     ({"control": lambda step: step.measurement.x}, "a Measurement has "),
     ({"evaluate_model": lambda world: world.pose}, "a WorldState has dt, k, last_u, model, "),
     ({"control": lambda step: step.measurement[0]}, "a Measurement has "),
     ({"control": lambda step: [*step.measurement]}, "a Measurement has "),
     ({"control": lambda step: step.measurement - 1}, "a Measurement has "),
     ({"control": sets_input}, "what a callback gets is read-only: "),
     ({"control": sets_array}, "what a callback gets is read-only: "),
     ({"estimate_parameters": takes_a_row_for_the_sample},
      "the sample of this step has phi of shape (3, 5), a row for each of X, Y, heading, and y of "
      "shape (3,)")],
)  # fmt: skip
def test_what_was_used_wrongly_says_what_it_has(options, note):
    error = raised(**{"measure": True, **options})
    assert len(error.__notes__) == 2
    assert error.__notes__[1].startswith(note)


def test_a_stage_that_was_switched_off_in_between_is_not_named():
    sim = Simulation(measure=True, estimate_parameters=True)
    assert sim.step_stage() == "world"
    sim.estimate_parameters = None
    assert sim.step_stage() == "measure"


@pytest.mark.parametrize(
    ("name", "hint"),
    [("measurement", r"did you mean sim.last_step.measurement\?"),
     ("u", r"did you mean sim.last_step.u\?"),
     ("pose_true", r"did you mean sim.trace.pose_true\?"),
     ("pose", r"did you mean 'sim.trace.pose_true'\?"),
     ("controler", r"did you mean 'control'\?"),
     ("xyz", "Simulation has no attribute 'xyz'$")],
)  # fmt: skip
def test_what_a_simulation_does_not_have_is_told_where_it_is(name, hint):
    with pytest.raises(AttributeError, match=hint):
        getattr(Simulation(), name)
    assert not hasattr(Simulation(), "__array__")


def test_an_attribute_error_of_a_callback_that_an_attribute_calls_reaches_the_user():
    sim = Simulation(define_model=lambda: None.theta)
    with pytest.raises(AttributeError, match="'NoneType' object has no attribute 'theta'"):
        _ = sim.model


@pytest.mark.parametrize(
    ("name", "hint"),
    [("nosie", "did you mean 'noise'"), ("dt", r"part of the model: model=robsim.RobotParameters"),
     ("steps", "it is an argument of run"),
     ("run", r"run is a method of Simulation and cannot be set: call sim.run\(...\)")],
)  # fmt: skip
def test_what_cannot_be_set_is_told_where_it_belongs(name, hint):
    with pytest.raises(AttributeError, match=hint):
        setattr(Simulation(), name, 3)


def test_a_seed_or_steps_given_the_wrong_way_are_told_by_name():
    with pytest.raises(TypeError, match=r"^Simulation.reset takes nothing without a name, got 1 val"
                       r"ues: give options by name, such as seed=\.\.\."):  # fmt: skip
        Simulation().reset(2)
    with pytest.raises(TypeError, match=r"^Simulation.run has no option 'seconds'"):
        Simulation().run(seconds=2)


@pytest.mark.parametrize("how", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_simulation_that_is_copied_says_how_to_make_another(how):
    with pytest.raises(TypeError, match=r"a Simulation can be neither copied nor pickled.*: make "
                       r"another, robsim.Simulation\(sim.scenario, control=\.\.\.\)"):  # fmt: skip
        how(Simulation())
    with pytest.raises(TypeError, match="an Experiment can be neither"):
        how(Experiment([FRAME], area=SIZE))


def test_an_estimator_class_in_place_of_an_object_is_told():
    sim = Simulation(init_parameter_estimator=lambda model: robsim.RecursiveLeastSquares)
    with pytest.raises(TypeError, match=r"returned the class RecursiveLeastSquares, not an object o"
                       r"f it: return RecursiveLeastSquares\(\.\.\.\)"):  # fmt: skip
        sim.run(1)
