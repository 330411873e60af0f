"""Every argument of every public callable in Python refuses values of a wrong kind by its name.

What there is comes from the signatures, what is wrong from the annotations: a new function is
covered without a line here, unless it needs an argument that has no example yet.
"""

import importlib
import inspect
import re
from functools import cache

import numpy as np
import pytest

import robsim

#: TO BE EMPTIED: arguments that are not refused by name as yet. One that is mended fails the test
#: until it is taken out.
NOT_YET = {
    "robsim.GaussianNoise.add": "index seed",
    "robsim.Recording": "plane_map source",
    "robsim.Trace.load": "path",
    "robsim.Trace.save": "path",
    "robsim.Trace.to_csv": "path",
    "robsim.UniformNoise.add": "index seed",
    "robsim.batch_estimate": "identify_from method select",
    "robsim.evaluation.cramer_rao_bound": "phi",
    "robsim.evaluation.estimation_errors": "names source units",
    "robsim.evaluation.posterior_cramer_rao_bound": "P0 Q R",
    "robsim.identification.convergence_time": "estimate",
    "robsim.identification.regression_of": "identify_from select",
    "robsim.imaging.Clip": "frames",
    "robsim.imaging.Clip.save": "path",
    "robsim.imaging.VideoWriter": "path",
    "robsim.imaging.VideoWriter.write": "frame",
    "robsim.imaging.load_image": "mode path",
    "robsim.imaging.save_image": "image path",
    "robsim.imaging.save_video": "frames path",
    "robsim.load_robot": "robot",
    "robsim.play": "overlay simulation start stop",
    "robsim.plot_batch": "ax",
    "robsim.plot_consistency": "ax",
    "robsim.plot_ellipses": "ax",
    "robsim.plot_errors": "bound",
    "robsim.plot_frame": "ax blobs frame measurement outline trace",
    "robsim.plot_parameters": "standard_errors trace",
    "robsim.plot_traces": "axes show_blobs",
    "robsim.plotting.annotated_frames": "frames simulation trace",
    "robsim.plotting.draw_overlay": "blobs estimate frame measurement outline path text",
    "robsim.plotting.plot_color_histograms": "color histograms others",
    "robsim.plotting.plot_robot": "ax",
    "robsim.robots.add_robot": "ignore_colors overwrite",
    "robsim.robots.check_colors": "robot",
    "robsim.robots.remove_robot": "name",
    "robsim.robots.robot_from_image": "image",
    "robsim.robots.rotate_robot": "name",
    "robsim.robots.save_robot": "folder",
    "robsim.robots.set_default_robot": "name",
    "robsim.trace.RunInfo": "boundary",
    "robsim.vision.score_color": "smoothing",
}
EXPECTED_FAILURES = {f"{name}({one})" for name, all_ in NOT_YET.items() for one in all_.split()}

#: Wrong kinds that are taken, or refused in another way, on purpose.
VALID = {
    # The items of an iterable are looked at one by one, in the run.
    "robsim.Experiment(frames)": [["a", "b"]],
    # None = the default, off.
    "robsim.Scenario(measure)": [None],
    "robsim.Scenario(estimate_parameters)": [None],
    # Any number of dimensions before the last.
    "robsim.evaluation.nees(error)": [np.zeros((2, 2, 2, 2))],
    "robsim.evaluation.nis(innovation)": [np.zeros((2, 2, 2, 2))],
    # An IndexError, as of a sequence.
    "robsim.Simulation.render_step(k)": [-1],
}

#: Called in every step of a filter: the model refuses what is no pose.
UNCHECKED = {"robsim.reference.RobotMotion.move(states)"}


@cache
def run():
    """A simulation that has all that functions ask for."""
    sim = robsim.Simulation(
        area=(300, 300),
        measure=True,
        estimate_parameters=True,
        control=robsim.DriveAround(),
        estimate_state=lambda step: robsim.Estimate((150, 150, 0), np.eye(3)),
        seed=1,
    )
    sim.run(40)
    return sim


def trace():
    return run().trace


def image():
    return np.full((32, 32, 3), 90, np.uint8)


def report():
    return robsim.pose_errors(trace())


#: An example of an argument that has to be given, by name; by callable and name where they differ.
EXAMPLES = {
    "FollowPath.waypoints": lambda: [(1, 2)],
    "PoseNoise.covariance": lambda: np.eye(3),
    "Recording.source": lambda: "images",
    "RobotDefinition.name": lambda: "lab",
    "RobotDefinition.image": lambda: robsim.load_robot("lab").image,
    "RobotDefinition.outline": lambda: robsim.load_robot("lab").outline,
    "RobotDefinition.red": lambda: robsim.load_robot("lab").red,
    "RobotDefinition.blue": lambda: robsim.load_robot("lab").blue,
    "Trace.poses_from.source": lambda: "truth",
    "VideoWriter.path": lambda: "video.mkv",
    "check_estimator.make": lambda: lambda: run().estimate_state,
    "check_parameter_estimator.make": lambda: lambda: robsim.RecursiveLeastSquares(5, n_filters=3),
    "convergence_time.estimate": lambda: np.ones((9, 2)),
    "convergence_time.truth": lambda: np.ones(2),
    "cramer_rao_bound.phi": lambda: np.random.default_rng(1).normal(size=(9, 2)),
    "instrumental_variables.u": lambda: trace().u,
    "output_error.u": lambda: trace().u,
    "load_image.path": lambda: "images/0.png",
    "plot_batch.report": lambda: robsim.batch_estimate(trace()),
    "plot_color_histograms.color": lambda: robsim.load_colors()[0],
    "plot_consistency.report": lambda: robsim.pose_consistency(trace()),
    "robot_from_image.image": lambda: robsim.load_robot("lab").image,
    "save_video.path": lambda: "video.mkv",
    "score_path.waypoints": lambda: [(150, 150)],
    "F": lambda: np.eye(2)[None],
    "H": lambda: np.eye(2)[None],
    "P0": lambda: np.eye(3),
    "Q": lambda: np.eye(3),
    "R": lambda: np.eye(3),
    "posterior_cramer_rao_bound.P0": lambda: np.eye(2),
    "posterior_cramer_rao_bound.Q": lambda: np.eye(2),
    "posterior_cramer_rao_bound.R": lambda: np.eye(2),
    "S": lambda: np.tile(np.eye(3), (40, 1, 1)),
    "alignment": lambda: 0.0,
    "background": image,
    "color": lambda: robsim.load_colors()[0],
    "colors": robsim.load_colors,
    "covariance": lambda: np.tile(np.eye(3), (40, 1, 1)),
    "degrees": lambda: 90.0,
    "dt": lambda: 0.2,
    "error": lambda: np.ones((40, 3)),
    "estimate": lambda: np.ones((40, 3)),
    "folder": lambda: "folder",
    "fps": lambda: 5.0,
    "frame": lambda: robsim.Frame(image()),
    "frames": lambda: [robsim.Frame(image())],
    "heading": lambda: 0.1,
    "histograms": lambda: np.ones((3, 256), int),
    "image": image,
    "innovation": lambda: np.ones((40, 3)),
    "k": lambda: 0,
    "masks": lambda: {"red": np.zeros((32, 32), bool)},
    "model": robsim.RobotModel,
    "n": lambda: 3,
    "name": lambda: "mine",
    "path": lambda: "file",
    "percent": lambda: 5.0,
    "phi": lambda: np.eye(5),
    "points": lambda: [(1, 2), (3, 4)],
    "poses": lambda: trace().pose_true,
    "probability": lambda: 0.1,
    "regions": lambda: [(1, 1, 5, 5)],
    "report": report,
    "rng": lambda: np.random.default_rng(1),
    "robot": robsim.load_robot,
    "seed": lambda: 1,
    "sigma": lambda: 0.1,
    "simulation": run,
    "size": lambda: 80.0,
    "source": lambda: "lab",
    "states": lambda: np.zeros((2, 6)),
    "t": lambda: 0.1,
    "text": lambda: "seed = 1",
    "theta_true": lambda: np.zeros((3, 5)),
    "tolerance": lambda: 0.1,
    "trace": trace,
    "traces": trace,
    "truth": lambda: np.ones((40, 3)),
    "u": lambda: np.zeros(2),
    "verdict": lambda: "determined",
    "x": lambda: 1.0,
    "y": lambda: 2.0,
}

#: What else has to be given, so that the other arguments are looked at.
ALSO = {
    "Experiment.from_folder": lambda: {"frames": []},
    "Simulation.run": lambda: {"steps": 1},
    "add_robot": lambda: {"overwrite": True},
}

#: What methods are called on, where the class cannot be made of the examples alone.
OBJECTS = {
    "Identifiability": lambda: robsim.identifiability(trace()),
    "Simulation": run,
    "Trace": trace,
}


def members(cls):
    for name in dir(cls):
        kind = inspect.getattr_static(cls, name)
        if not name.startswith("_") and (
            inspect.isfunction(kind) or isinstance(kind, (classmethod, staticmethod))
        ):
            yield name, getattr(cls, name)


def public_callables():
    """Name, function or class, and the class that a method is called on, if there is one."""
    for room in ["", *robsim._ROOMS]:
        module = importlib.import_module(f"robsim.{room}".rstrip("."))
        for name in module.__all__:
            value = getattr(module, name)
            if getattr(value, "__module__", None) != module.__name__:
                continue  # presented by another room
            if inspect.isfunction(value):
                yield f"{module.__name__}.{name}", value, None
            elif isinstance(value, type) and hasattr(value.__init__, "__wrapped__"):
                yield f"{module.__name__}.{name}", value, None
                for method, function in members(value):
                    yield f"{module.__name__}.{name}.{method}", function, value


def cases():
    for name, function, owner in public_callables():
        # What documents no parameters is a result that robsim makes, or a step of a filter.
        if "Parameters\n" not in (function.__doc__ or ""):
            continue
        for parameter in inspect.signature(function).parameters.values():
            case = f"{name}({parameter.name})"
            is_one = parameter.name != "self" and parameter.kind is not parameter.VAR_KEYWORD
            if is_one and case not in UNCHECKED:
                is_left = case in EXPECTED_FAILURES
                marks = [pytest.mark.xfail(reason="to be mended", strict=True)] if is_left else []
                yield pytest.param(name, function, owner, parameter, id=case, marks=marks)


def without_room(name):
    parts = name.split(".")[1:]
    return ".".join(parts[1:] if parts[0] in robsim._ROOMS else parts)


def example(name, argument):
    for key in (f"{without_room(name)}.{argument}", argument):
        if key in EXAMPLES:
            return EXAMPLES[key]()
    raise KeyError(f"EXAMPLES needs one of {argument!r} for {name}")


def required(name, function):
    return {
        one.name: example(name, one.name)
        for one in inspect.signature(function).parameters.values()
        if one.default is one.empty and one.kind is not one.VAR_KEYWORD and one.name != "self"
    }


def bound(name, function, owner):
    """The function, as a method of an object if it is one."""
    method = name.rpartition(".")[2]
    if owner is None or not inspect.isfunction(inspect.getattr_static(owner, method)):
        return function
    of = owner.__name__
    home = name.rpartition(".")[0]
    made = OBJECTS[of]() if of in OBJECTS else owner(**required(home, owner))
    return getattr(made, method)


def wrong_kinds(annotation):
    """Values that are none of what an annotation says."""
    text = str(annotation)

    def says(*words):
        return any(re.search(rf"\b{word}", text) for word in words)

    if says("Any$"):
        return
    is_path = says("str", "PathLike", "options.Colors", "options.Markers", "options.Background")
    is_number = says("int", "float", "Seed", "ArrayLike", "Floats")
    yield object()
    yield b"x"
    yield np.zeros((2, 2, 2, 2))
    yield np.array([1j, 2j, 3j])
    if not says("None", "Seed", "options", "Any"):
        yield None
    if not says("Callable"):
        yield dict
    if not says("Mapping", "dict", "Any"):
        yield {"a": 1}
    if not is_path:
        yield "text"
    if not says(r"Sequence\[str", r"tuple\[str", r"Iterable\[str"):
        yield ["a", "b"]
    if not is_number:
        yield 1.5
    if says("int") and not says("float", "Array", "Floats"):
        yield float("nan")
        yield 1.5
    if says("int") and not says("float", "Array", "Floats"):
        yield -1
    if not says("bool", "Array", "Floats"):
        yield True


def short(value):
    return re.sub(r" at 0x\w+|\s+", " ", repr(value))[:40]


@pytest.fixture(autouse=True, scope="module")
def _here(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        here = tmp_path_factory.mktemp("here")
        patch.chdir(here)
        patch.setenv("ROBSIM_DATA", str(here / "data"))
        (here / "images").mkdir()
        robsim.imaging.save_image("images/0.png", image())
        robsim.robots.add_robot("mine", "lab")
        (here / "folder").mkdir()
        (here / "folder" / "control.py").write_text("def control(step):\n    return 0, 0\n")
        yield


@pytest.mark.parametrize(("name", "function", "owner", "parameter"), list(cases()))
@pytest.mark.filterwarnings("ignore")
def test_a_value_of_a_wrong_kind_is_refused_by_name(name, function, owner, parameter):
    call = bound(name, function, owner)
    given = ALSO.get(without_room(name), dict)() | required(name, function)
    valid = [short(value) for value in VALID.get(f"{name}({parameter.name})", ())]
    for value in wrong_kinds(parameter.annotation):
        if short(value) not in valid:
            fault = fault_of(call, given | {parameter.name: value}, parameter.name)
            assert fault is None, f"{name}({parameter.name}={short(value)}): {fault}"


def fault_of(call, arguments, name):
    """What is wrong with the way that a call refuses an argument; None = nothing."""
    try:
        call(**arguments)
    except (TypeError, ValueError) as error:
        named = re.search(rf"\b{name}\b", str(error))
        return None if named else f"{type(error).__name__}: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "taken"
