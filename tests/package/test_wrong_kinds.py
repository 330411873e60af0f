"""Every argument of every public callable refuses values of a wrong kind by its name.

What there is comes from the signatures, what is wrong from the annotations: a new function is
covered without a line here, unless it needs an argument that has no example yet.
"""

import ast
import atexit
import importlib
import inspect
import re
import shutil
import tempfile
from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest

import robsim
from python_devices import SteppedCamera
from refusals import NO_IMAGE, NO_PAIR, NO_POLYGON, NO_POSE, NOT_FINITE, short
from robsim.teach import ClassResult
from robsim.teach.tasks.marks.calibration import shipped_calibrations

pytestmark = pytest.mark.long

#: Wrong kinds that are taken, or refused in another way, on purpose.
VALID = {
    # The items of an iterable are looked at one by one, in the run.
    "Experiment(frames)": [["a", "b"]],
    # Stages that True switches on; an estimator can be any object.
    "Experiment(measure)": [True],
    "Experiment(estimate_parameters)": [True],
    "Experiment(init_parameter_estimator)": [dict],
    "Simulation(area)": [None],
    "Simulation(measure)": [True],
    "Simulation(estimate_parameters)": [True],
    "Simulation(init_parameter_estimator)": [dict],
    # None = the default, off.
    "Scenario(measure)": [None],
    "Scenario(estimate_parameters)": [None],
    # Any number of dimensions.
    "cramer_rao_bound(phi)": [np.zeros((2, 2, 2, 2))],
    "convergence_time(estimate)": [np.zeros((2, 2, 2, 2))],
    "nees(error)": [np.zeros((2, 2, 2, 2))],
    "nis(innovation)": [np.zeros((2, 2, 2, 2))],
    "wrap_angle(angle)": [np.zeros((2, 2, 2, 2))],
    # Any sequence of values; a function that returns the text.
    "Row(values)": [np.zeros((2, 2, 2, 2)), np.array([1j, 2j, 3j]), ["a", "b"]],
    "Column(format)": [dict, "text"],
    "Quantity(format)": [dict, "text"],
    # An IndexError, as of a sequence.
    "Simulation.render_step(k)": [-1, 10**30, -(10**30)],
    # A margin that is negative makes a class narrower.
    "ColorClass.widened(margin)": [-1],
    # As much as there may be, and all times.
    "percent(fraction)": [np.inf],
    **{
        f"{call}({name}_tolerance)": [np.inf]
        for call in ("MarkerLayout", "MarkerLayout.from_markers", "MarkerLayout.from_positions")
        for name in ("area", "distance")
    },
    "Limits.applied(dt)": [np.inf],
}

#: Values of the right kind are all taken, or refused by the name of something else.
ANY_MEANING = {
    *("campaign(runs)", "calibrate_task(seed)"),
    *("Chessboard.find(image)", "Charuco.find(image)", "find_sheets(image)"),
}

#: The constant-velocity model has no inputs; what has a star has no name.
UNCHECKED = {
    "robsim.estimation.reference.ConstantVelocityKalmanFilter.predict(u)",
    "robsim.teach.Submission.call(arrays)",
}


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


@cache
def lab():
    return robsim.lab.SimulatedLab(robsim.Scenario(area=(300, 300), seed=1))


def trace():
    return run().trace


def image():
    return np.full((32, 32, 3), 90, np.uint8)


def camera():
    source = SteppedCamera([image()])
    source.permits.release()
    return source


def camera_check():
    with robsim.Camera(camera()) as opened:
        return robsim.lab.check_camera(opened, seconds=0.05)


lab_robot = cache(partial(robsim.load_robot, "lab"))


def report():
    return robsim.pose_errors(trace())


@cache
def campaign():
    return robsim.campaign(metrics="tracking", runs=2, steps=2, progress=False)


def red_square():
    picture = np.full((40, 40, 3), 150, np.uint8)
    picture[8:20, 8:20] = (200, 30, 30)
    return picture


def calibration(size=(64, 48)):
    return robsim.vision.Calibration(size=size, floor=robsim.vision.PlaneMap(), area=size)


@cache
def submission_folder():
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    Path(folder, "control.py").write_text("def control(step):\n    return 0, 0\n")
    Path(folder, "fit.py").write_text("def fit(*arrays):\n    return 0\n")
    return folder


def calibrated():
    return shipped_calibrations()["estimate"]


@cache
def assignment():
    measure = robsim.teach.MeasureTask(steps=2, runs=1)
    test = robsim.teach.TaskTest(name="ekf", title="Measure", task=measure, points=1)
    return robsim.teach.Assignment(
        folder=Path(),
        name="hw3",
        title="Homework",
        slots=("measure",),
        given="frames",
        tests=(test,),
    )


@cache
def new_folder():
    """A folder that tests make nothing in: all of them refuse what comes with it."""
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@cache
def new_assignment():
    return robsim.teach.new_assignment("measure", Path(new_folder(), "hw1"), seed=1)


def answer():
    """An answer to an exercise."""
    return next(iter(robsim.teach.notebook_exercises().values()))[0].right


#: An example of an argument that has to be given, by name; by callable and name where they differ.
EXAMPLES = {
    "plot_runs.runs": lambda: {"one": trace()},
    "Score.floor": lambda: 0.1,
    "Score.statistic.values": lambda: [1.0, 2.0],
    "solution_folder.task": robsim.teach.MeasureTask,
    "solution_folder.solution": lambda: robsim.teach.MeasureTask().solutions[0],
    "try_solution.task": lambda: robsim.teach.MeasureTask(steps=2, runs=1),
    "Solution.load.is_right": lambda: True,
    "TaskCalibration.from_record.record": lambda: calibrated().as_record(),
    "TaskCalibration.stale.task": robsim.teach.EstimateTask,
    "TaskCalibration.for_task.task": robsim.teach.EstimateTask,
    "TaskCalibration.for_task.solutions": lambda: robsim.teach.EstimateTask().solutions,
    "calibrate_task.task": lambda: robsim.teach.EstimateTask(steps=20, runs=1),
    "Submission.call.name": lambda: "fit",
    "Submission.calls.name": lambda: "fit",
    "Intrinsics.matrix": lambda: [[50, 0, 20], [0, 50, 20], [0, 0, 1]],
    "new_assignment.template": lambda: "measure",
    **{f"{door}.answer": answer for door in ("check_answer", "checked")},
    "Exercise.right": answer,
    "Exercise.cases": lambda: lambda rng: (1.0, 2.0),
    "pack_feedback.result": lambda: ClassResult(name="hw1", results=()),
    "pack_gradescope.path": lambda: Path(new_folder(), "autograder.zip"),
    "calibrate_assignment.folder": lambda: new_assignment().folder,
    "check_assignment.folder": lambda: new_assignment().folder,
    "load_assignment.folder": lambda: new_assignment().folder,
    **{
        f"{door}.assignment": assignment
        for door in ("grade_submission", "grade_class", "regrade_class", "play_run")
    },
    "find_sheets.mark": lambda: 80.0,
    "save_sheet.path": lambda: "sheet.pdf",
    "save_sheet.pattern": lambda: robsim.lab.Chessboard(),
    "Lens.distorted.size": lambda: (64, 48),
    "Lens.ideal.size": lambda: (64, 48),
    "Blob.color": lambda: "red",
    "calibrate_floor.pixels": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "calibrate_floor.positions": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "calibrate_floor.area": lambda: (64, 48),
    "calibrate_floor_by_sheets.area": lambda: (64, 48),
    "calibrate_lens.board": lambda: robsim.lab.Chessboard(),
    "Calibration.size": lambda: (64, 48),
    "Calibration.check_frames.size": lambda: (64, 48),
    "Camera.source": camera,
    "check_camera.camera": lambda: robsim.Camera(camera()),
    "plot_campaign.metric": lambda: "tracking_seen",
    "plot_camera_check.check": camera_check,
    "CampaignResult.trace.case": lambda: 0,
    "Estimate.covariance": lambda: np.eye(3),
    "instrumental_variables.u": lambda: trace().u,
    "Key.noise_keys.frames": lambda: 3,
    "BlobMarker.polygon": lambda: [(0, 0), (9, 0), (9, 9)],
    "MarkerLayout.from_markers.markers": lambda: lab_robot().marker_layout().polygons,
    "MarkerLayout.from_positions.positions": lambda: {"right": (0, 9), "left": (0, 0)},
    "output_error.u": lambda: trace().u,
    "PlaneMap.from_points.positions": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "plot_batch.report": lambda: robsim.batch_estimate(trace()),
    "plot_consistency.report": lambda: robsim.pose_consistency(trace()),
    "posterior_cramer_rao_bound.P0": lambda: np.eye(2),
    "posterior_cramer_rao_bound.Q": lambda: np.eye(2),
    "posterior_cramer_rao_bound.R": lambda: np.eye(2),
    "Recording.source": lambda: "images",
    "RobotPanel.draw.polygon": lambda: [(0, 0), (9, 0), (9, 9)],
    "robot_from_image.image": lambda: lab_robot().image[::4, ::4],
    "RobotDefinition.alignment": lambda: 90.0,
    "RobotDefinition.image": lambda: lab_robot().image,
    "RobotDefinition.markers": lambda: lab_robot().markers,
    "RobotDefinition.outline": lambda: lab_robot().outline,
    "RobotMotion.jacobian.state": lambda: np.zeros(6),
    "Sample.y": lambda: np.zeros(3),
    "save_video.path": lambda: "video.mkv",
    "Scene.area": lambda: (300, 300),
    "score_path.waypoints": lambda: [(150, 150)],
    "VideoWriter.path": lambda: "video.mkv",
    "action": lambda: (0.1, 0.1),
    "address": lambda: "127.0.0.1:9",
    "before": lambda: (0.1, 0.2),
    "blobs": lambda: {"red": [], "blue": []},
    "bounding_box": lambda: (1, 1, 5, 5),
    "centre": lambda: (20, 20),
    "centroid": lambda: (1, 2),
    "color": lambda: robsim.load_colors()[0],
    "covariance": lambda: np.tile(np.eye(3), (40, 1, 1)),
    "error": lambda: np.ones((40, 3)),
    "F": lambda: np.eye(2)[None],
    "floor": lambda: (image(), image()),
    "frames": lambda: [robsim.Frame(image())],
    "H": lambda: np.eye(2),
    "histograms": lambda: np.ones((3, 256), int),
    "home": lambda: (image(), image()),
    "innovation": lambda: np.ones((40, 3)),
    "last_u": lambda: np.zeros(2),
    "make": lambda: robsim.Spin,
    "masks": lambda: {"red": np.zeros((32, 32), bool)},
    "metrics": lambda: "tracking",
    "n_parameters": lambda: 5,
    "name": lambda: "mine",
    "P0": lambda: np.eye(3),
    "phi": lambda: np.eye(5),
    "pixels": lambda: [(1, 2), (3, 4)],
    "poses": lambda: trace().pose_true,
    "Q": lambda: np.eye(3),
    "region": lambda: (1, 1, 5, 5),
    "regions": lambda: [(1, 1, 5, 5)],
    "report": report,
    "rng": lambda: np.random.default_rng(1),
    "S": lambda: np.tile(np.eye(3), (40, 1, 1)),
    "scene": lambda: robsim.simulation.Scene(
        **required("robsim.simulation.Scene", robsim.simulation.Scene)
    ),
    "sigma": lambda: 0.1,
    "simulation": run,
    "sprite": lambda: lab_robot().image,
    "states": lambda: np.zeros((2, 6)),
    "submission": submission_folder,
    "submissions": submission_folder,
    "test": lambda: "ekf",
    "theta": lambda: robsim.RobotModel().theta,
    "theta_true": lambda: np.zeros((3, 5)),
    "truth": lambda: np.ones((40, 3)),
    "u": lambda: np.zeros(2),
    "value": lambda: 1.0,
    "what": lambda: robsim.Simulation(area=(300, 300), seed=1),
}

#: An example of any other argument, by a word of its annotation.
EXAMPLES_BY_TYPE = {
    "Trace": trace,
    "Frame": lambda: robsim.Frame(image()),
    "Pixels|uint8": image,
    "Calibration": calibration,
    "RobotDefinition": robsim.load_robot,
    "RobotModel": robsim.RobotModel,
    "ColorClass": robsim.load_colors,
    "MarkerLayout": lambda: robsim.load_robot().marker_layout(),
    "Simulation": run,
    "Scenario": lambda: robsim.Scenario(area=(300, 300)),
    "Step": robsim.Step,
    "SimulatedLab": lab,
    "CampaignResult": campaign,
    "Assignment": new_assignment,
    "bytes": lambda: bytes(32),
    "PathLike": lambda: "file",
    r"tuple\[": lambda: (64, 48),
    "float": lambda: 1.0,
    "int": lambda: 1,
    "str": lambda: "text",
    "ArrayLike|Floats": lambda: np.ones(3),
    "Sequence|Iterable": list,
}

#: What else has to be given, so that the other arguments are looked at.
ALSO = {
    "calibrate_floor": lambda: {"size": (64, 48)},
    "Experiment.from_folder": lambda: {"frames": []},
    "Sample": lambda: {"phi": np.ones((3, 5))},
    "Simulation.run": lambda: {"steps": 1},
    "add_robot": lambda: {"overwrite": True},
}


def session():
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "setup.toml").write_text("format = 2")
        return robsim.trace.Session(folder)


def floor_panel():
    tool = robsim.gui.floor_panel()
    tool.add((230, 160), (300, 300))
    return tool


#: What methods are called on, where the class cannot be made of the examples alone.
OBJECTS = {
    "TaskCalibration": calibrated,
    "Task": robsim.teach.MeasureTask,
    "Solution": lambda: robsim.teach.MeasureTask().solutions[0],
    "Experiment": lambda: robsim.Experiment([robsim.Frame(image())]),
    "CampaignResult": campaign,
    "CampaignSpec": lambda: campaign().spec,
    "ColorPanel": lambda: robsim.gui.color_panel(image()),
    "FloorPanel": floor_panel,
    "Panel": lambda: robsim.panel(run()),
    "RobotPanel": robsim.gui.robot_panel,
    "Identifiability": lambda: robsim.identifiability(trace()),
    "Report": report,
    "Assignment": assignment,
    "SubmissionResult": lambda: robsim.teach.SubmissionResult,
    "Session": session,
    "Simulation": run,
    "Trace": trace,
    "SimulatedLab": lab,
    "Submission": lambda: robsim.teach.Submission(
        submission_folder(), slots="control", functions="fit"
    ),
    "LabTruth": lambda: lab().truth,
}


def public_callables():
    """Name, function or class, and the class that a method is called on, if there is one."""
    for room in ["", *robsim._WINGS, "estimation.reference", "teach.gym"]:
        module = importlib.import_module(f"robsim.{room}".rstrip("."))
        for name in module.__all__:
            value = getattr(module, name)
            if getattr(value, "__module__", None) != module.__name__:
                continue  # presented by another room
            if isinstance(value, type) and not issubclass(value, Exception):
                # What documents no parameters is a result that robsim makes.
                if "Parameters\n" in f"{value.__doc__}{value.__init__.__doc__}":
                    yield f"{module.__name__}.{name}", value, None
                for method in methods(value):
                    yield f"{module.__name__}.{name}.{method}", getattr(value, method), value
            elif not isinstance(value, type) and callable(value):
                yield f"{module.__name__}.{name}", value, None


def methods(cls):
    """Names of the public methods of a class, with those of private classes that it is made of."""
    for name in dir(cls):
        home = next(one for one in cls.__mro__ if name in vars(one))
        is_public = not name.startswith("_") and (home is cls or "._" in home.__module__)
        if is_public and callable(getattr(cls, name)) and inspect.isroutine(getattr(cls, name)):
            yield name


def native_signature(function):
    """The signature with types, the first line of the doc of what is native; else None."""
    doc = (function.__init__ if isinstance(function, type) else function).__doc__ or ""
    line = re.match(r"\w+\(.*\) -> .*", doc)
    return line and line[0]


def annotations(function):
    """Argument to its type as text."""
    native = native_signature(function)
    if native is None:
        parameters = inspect.signature(function).parameters.values()
        return {one.name: str(one.annotation) for one in parameters}
    arguments = ast.parse(f"def {native}: ...").body[0].args
    return {
        one.arg: ast.unparse(one.annotation) for one in (*arguments.args, *arguments.kwonlyargs)
    }


def parameters_of(name, function):
    """The arguments that are tried."""
    for parameter in inspect.signature(function).parameters.values():
        is_one = parameter.name != "self" and parameter.kind is not parameter.VAR_KEYWORD
        if is_one and f"{name}({parameter.name})" not in UNCHECKED:
            yield parameter


def cases():
    for name, function, owner in public_callables():
        if any(parameters_of(name, function)):
            yield pytest.param(name, function, owner, id=name)


def without_room(name):
    parts = name.split(".")[1:]
    wing = parts[0] in robsim._WINGS
    apart = parts[:2] in (["estimation", "reference"], ["teach", "gym"])
    return ".".join(parts[wing + apart :])


def example(name, argument, kind):
    for key in (f"{without_room(name)}.{argument}", argument):
        if key in EXAMPLES:
            return EXAMPLES[key]()
    for word, value in EXAMPLES_BY_TYPE.items():
        if re.search(rf"\b{word}\b", kind):
            return value()
    raise KeyError(f"EXAMPLES needs one of {argument!r} for {name}")


def required(name, function):
    types = annotations(function)
    return {
        one.name: example(name, one.name, types[one.name])
        for one in inspect.signature(function).parameters.values()
        if one.default is one.empty
        if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY) and one.name != "self"
    }


def bound(name, function, owner):
    """The function, as a method of an object if it is one."""
    home, _, method = name.rpartition(".")
    if owner is None or isinstance(
        inspect.getattr_static(owner, method), (classmethod, staticmethod)
    ):
        return function
    of = owner.__name__
    made = OBJECTS[of]() if of in OBJECTS else owner(**required(home, owner))
    return getattr(made, method)


def wrong_kinds(text):
    """Values that are none of what an annotation says."""

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
        yield from (float("nan"), 1.5, -1)
    if not says("bool", "Array", "Floats"):
        yield True


def wrong_values(argument, kind):
    """Values of the right kind that do not have its meaning."""
    if "None" in kind:
        return
    if kind == "int":
        yield from (10**30, -(10**30))
    if kind == "float":
        yield from NOT_FINITE
    if kind == "tuple[int, int]":
        yield from NO_PAIR
    if argument == "image":
        yield from NO_IMAGE
    if argument == "pose" and "ArrayLike" in kind:
        yield from NO_POSE
    if argument in ("outline", "red", "blue"):
        yield from NO_POLYGON


@pytest.fixture(autouse=True, scope="module")
def _here(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        here = tmp_path_factory.mktemp("here")
        patch.chdir(here)
        patch.setenv("ROBSIM_DATA", str(here / "data"))
        (here / "images").mkdir()
        robsim.vision.save_image("images/0.png", image())
        robsim.vision.add_robot("mine", "lab")
        (here / "folder").mkdir()
        (here / "folder" / "control.py").write_text("def control(step):\n    return 0, 0\n")
        yield


@pytest.mark.parametrize(("name", "function", "owner"), list(cases()))
@pytest.mark.filterwarnings("ignore")
def test_wrong_values_are_refused_by_the_name_of_their_argument(name, function, owner):
    wrong = []
    types = annotations(function)
    for parameter in parameters_of(name, function):
        call = bound(name, function, owner)
        given = required(name, function) | ALSO.get(without_room(name), dict)()
        case = f"{without_room(name)}({parameter.name})"
        taken = {short(value) for value in VALID.get(case, ())}
        kind = types[parameter.name]
        values = [*wrong_kinds(kind)]
        if case not in ANY_MEANING:
            values += wrong_values(parameter.name, kind)
        for value in values:
            fault = fault_of(call, given, parameter, value)
            is_taken = short(value) in taken
            if is_taken != (fault is not None):
                wrong.append(f"{case} = {short(value)}: {fault or 'refused, delete its line'}")
    assert not wrong, "\n".join(wrong)


def fault_of(call, given, parameter, value):
    """What is wrong with the way that a call refuses a value of an argument; None = nothing."""
    name = parameter.name
    try:
        if parameter.kind is parameter.VAR_POSITIONAL:
            call(value, **given)
        else:
            result = call(**(given | {name: value}))
            if isinstance(result, Iterator):
                next(result)
    except (TypeError, ValueError) as error:
        named = re.search(rf"\b{name}\b", str(error))
        return None if named else f"{type(error).__name__}: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "taken"


def test_every_exception_is_that_of_an_argument():
    known = {
        f"{without_room(name)}({parameter.name})"
        for name, function, _ in (case.values for case in cases())
        for parameter in parameters_of(name, function)
    }
    assert VALID.keys() <= known


def test_native_types_are_told_from_each_other():
    for call in (
        lambda: robsim.Spin(True),
        lambda: robsim.DriveAround(hold=True),
        lambda: robsim.Frame(image(), copy=1.5),
        lambda: robsim.Frame(image(), copy=None),
    ):
        with pytest.raises(TypeError):
            call()
