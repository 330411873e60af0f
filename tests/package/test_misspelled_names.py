"""Misspelled, misplaced and nameless arguments of the main classes, and misspelled choices."""

import inspect
import pickle
import traceback

import pytest

import robsim
from robsim import Dropout, Experiment, GoToPoint, Scenario, Simulation


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: Simulation(mesure=True),
            "Simulation has no option 'mesure': did you mean 'measure'?",
        ),
        (lambda: Scenario(noize=1), "Scenario has no option 'noize': did you mean 'noise'?"),
        (
            lambda: Experiment([], smothing=3),
            "Experiment has no option 'smothing': did you mean 'smoothing'?",
        ),
        (lambda: Dropout(p=0.1), "Dropout has no option 'p': there are probability, steps"),
        (
            lambda: GoToPoint(1, 2, maxspeed=3),
            "GoToPoint has no option 'maxspeed': did you mean 'maximum_speed'?",
        ),
        (
            lambda: Simulation(frames=[]),
            "Simulation has no option 'frames': frames from outside are for "
            "robsim.Experiment(frames, ...)",
        ),
        (
            lambda: Experiment([], boundary="bounce"),
            "Experiment has no option 'boundary': it is an option of robsim.Simulation, of its "
            "world",
        ),
        (
            lambda: Scenario(time_limit=1),
            "Scenario has no option 'time_limit': code is no data: give it to Simulation itself",
        ),
        (
            lambda: Simulation("lab"),
            "scenario must be a Scenario, got 'lab': give options by name, such as robot='lab'",
        ),
        (
            lambda: Scenario("lab"),
            "Scenario takes nothing without a name, got 1 values: give options by name, such as "
            "robot=...",
        ),
        (
            lambda: GoToPoint(1, 2, 3),
            "GoToPoint takes only x, y without a name, got 3 values: give options by name, such "
            "as maximum_voltage=...",
        ),
        (lambda: Dropout(1, 2, 3), "Dropout takes only probability, steps without a name, got 3"),
        (lambda: Experiment(), "Experiment must be given frames"),
        (lambda: GoToPoint(), "GoToPoint must be given x and y"),
    ],
)
def test_a_call_with_the_wrong_arguments(call, message):
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value).startswith(message)


def test_a_folder_with_a_misspelled_option(tmp_path):
    (tmp_path / "control.py").write_text("def control(step):\n    return 0, 0\n")
    with pytest.raises(TypeError, match="no option 'mesure': did you mean 'measure'"):
        Simulation.from_folder(tmp_path, mesure=True)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mesure", "Simulation has no slot 'mesure': did you mean 'measure'?"),
        ("area", r"area is fixed: give it to Simulation(area=...)"),
        ("model", "model cannot be set: fill define_model, then call sim.reset()"),
        ("zzz", "Simulation has no slot 'zzz': there are define_model, init_"),
    ],
)
def test_an_attribute_that_cannot_be_set(name, message):
    with pytest.raises(AttributeError) as caught:
        setattr(Simulation(), name, True)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    ("options", "meant"),
    [
        ({"boundary": "bonce"}, "bounce"),
        ({"identify_from": "mesurement"}, "measurement"),
        ({"robot": "lub"}, "lab"),
    ],
)
def test_a_misspelled_choice(options, meant):
    with pytest.raises(ValueError, match=rf"; did you mean '{meant}'\?$"):
        Scenario(**options)


def test_a_misspelled_file(tmp_path):
    robsim.vision.save_colors(tmp_path / "mine.toml", robsim.load_colors())
    Scenario().save(tmp_path / "world.toml")
    with pytest.raises(FileNotFoundError, match=r"did you mean 'mine\.toml'\?.*main\.toml"):
        robsim.load_colors(tmp_path / "main.toml")
    with pytest.raises(FileNotFoundError, match=r"did you mean 'world\.toml'\?"):
        Scenario.load(tmp_path / "wolrd.toml")


def test_an_error_within_the_call_is_left_as_it_is():
    class Own(GoToPoint):
        def __init__(self):
            super().__init__(1, "b")

    with pytest.raises(TypeError, match="y must be a number"):
        Own()


def test_signatures_and_pickles_are_those_of_the_class():
    assert list(inspect.signature(Dropout).parameters) == ["probability", "steps"]
    assert inspect.signature(Dropout.__init__).parameters["steps"].default == 1
    assert pickle.loads(pickle.dumps(Dropout(0.5))) == Dropout(0.5)


@pytest.mark.parametrize(
    ("name", "words"),
    [("nees", "module 'robsim' has no attribute 'nees': it is robsim.evaluation.nees"),
     ("ExtendedKalmanFilter", "it is robsim.reference.ExtendedKalmanFilter"),
     ("plot_trace", "did you mean 'plot_traces'"), ("goToPoint", "did you mean 'GoToPoint'"),
     ("xyz", "has no attribute 'xyz'$")],
)  # fmt: skip
def test_a_name_that_is_not_at_the_top_is_told_where_it_is(name, words):
    with pytest.raises(AttributeError, match=words):
        getattr(robsim, name)


@pytest.mark.parametrize(
    "look",
    [lambda: robsim.lokate, lambda: Simulation().contrl, lambda: Simulation().trace.pose_tru],
)
def test_what_may_be_meant_is_told_once(look):
    """Python, from 3.12 on, tells it for the attributes that it knows."""
    with pytest.raises(AttributeError) as caught:
        look()
    told = "".join(traceback.format_exception_only(caught.value))
    assert told.lower().count("did you mean") == 1
