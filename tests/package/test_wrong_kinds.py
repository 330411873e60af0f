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
from functools import cache
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest

import robsim
from python_cameras import SteppedCamera
from robsim.tasks._marks.files import shipped_calibrations

pytestmark = pytest.mark.long

#: Wrong kinds that are taken, or refused in another way, on purpose.
VALID = {
    # The items of an iterable are looked at one by one, in the run.
    "Experiment(frames)": [["a", "b"]],
    # Stages that True switches on; an estimator can be any object.
    "Experiment(measure)": [True],
    "Experiment(estimate_parameters)": [True],
    "Experiment(init_parameter_estimator)": [dict],
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
    "Simulation.render_step(k)": [-1],
    # A margin that is negative makes a class narrower.
    "ColorClass.widened(margin)": [-1],
}

#: The constant-velocity model has no inputs; what has a star has no name.
UNCHECKED = {
    "robsim.reference.ConstantVelocityKalmanFilter.predict(u)",
    "robsim.grading.Submission.call(arrays)",
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
    return robsim.live.SimulatedLab(robsim.Scenario(area=(300, 300), seed=1))


def virtual_bus():
    """A bus as far as its methods look at what they are given: it may not be built here."""
    bus = object.__new__(robsim.live.VirtualBus)
    bus.cameras, bus._server = (lab(),), MagicMock()
    return bus


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
        return robsim.live.check_camera(opened, seconds=0.05)


def report():
    return robsim.pose_errors(trace())


@cache
def campaign():
    return robsim.campaign(metrics="tracking", runs=2, steps=2, progress=False)


#: An example of an argument that has to be given, by name; by callable and name where they differ.


def red_square():
    picture = np.full((40, 40, 3), 150, np.uint8)
    picture[8:20, 8:20] = (200, 30, 30)
    return picture


def calibration(size=(64, 48)):
    return robsim.imaging.Calibration(size=size, floor=robsim.imaging.PlaneMap(), area=size)


@cache
def submission_folder():
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder)
    Path(folder, "control.py").write_text("def control(step):\n    return 0, 0\n")
    Path(folder, "fit.py").write_text("def fit(*arrays):\n    return 0\n")
    return folder


def calibrated():
    return shipped_calibrations()["estimate"]


@cache
def assignment():
    measure = robsim.tasks.Measure(steps=2, runs=1)
    test = robsim.assignments.TaskTest(name="ekf", title="Measure", task=measure, points=1)
    return robsim.assignments.Assignment(
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
    atexit.register(shutil.rmtree, folder)
    return folder


@cache
def new_assignment():
    return robsim.assignments.new_assignment("measurement", Path(new_folder(), "hw1"), seed=1)


EXAMPLES = {
    "SubmissionResult.from_json.text": lambda: "{}",
    "plot_runs.runs": lambda: {"one": trace()},
    "Limit.full": lambda: 1.1,
    "Limit.zero": lambda: 4.0,
    "Limit.fraction.statistic": lambda: 1.5,
    "Score.name": lambda: "error",
    "Score.title": lambda: "error of the position",
    "Score.floor": lambda: 0.1,
    "Score.worst": lambda: 10.0,
    "Score.statistic.values": lambda: [1.0, 2.0],
    "Score.statistic.reference": lambda: [1.0, 1.0],
    "Solution.choice.task": robsim.tasks.Measure,
    "Solution.read.folder": lambda: robsim.tasks.Measure().solutions[0].folder,
    "Solution.read.slots": lambda: "measure",
    "Solution.read.is_right": lambda: True,
    "TaskCalibration.from_record.record": lambda: calibrated().as_record(),
    "TaskCalibration.stale.task": robsim.tasks.EstimateState,
    "calibrate.task": lambda: robsim.tasks.EstimateState(steps=20, runs=1),
    "Submission.path": submission_folder,
    "Submission.call.name": lambda: "fit",
    "Submission.calls.name": lambda: "fit",
    "Submission.calls.arguments": lambda: [(1.0,)],
    "Intrinsics.matrix": lambda: [[50, 0, 20], [0, 50, 20], [0, 0, 1]],
    "draw_grid.calibration": lambda: calibration((32, 32)),
    "new_assignment.template": lambda: "measurement",
    "new_assignment.folder": lambda: Path(new_folder(), "hw2"),
    "pack_gradescope.assignment": new_assignment,
    "pack_gradescope.path": lambda: Path(new_folder(), "autograder.zip"),
    "pack_students.assignment": new_assignment,
    "pack_students.path": lambda: Path(new_folder(), "students.zip"),
    "calibrate_assignment.folder": lambda: new_assignment().folder,
    "check_assignment.folder": lambda: new_assignment().folder,
    "find_sheets.mark": lambda: 80.0,
    "load_calibration.path": lambda: "camera.toml",
    "Residuals.points": lambda: 9,
    "Residuals.rms": lambda: 0.1,
    "Residuals.worst": lambda: 0.2,
    "save_calibration.calibration": lambda: calibration(),
    "save_calibration.path": lambda: "camera.toml",
    "sheet_shifts.calibration": lambda: calibration((32, 32)),
    "save_sheet.path": lambda: "sheet.pdf",
    "save_sheet.pattern": lambda: robsim.calibration.Chessboard(),
    "Lens.distorted.size": lambda: (64, 48),
    "Lens.ideal.size": lambda: (64, 48),
    "Blob.centroid": lambda: (1.0, 2.0),
    "Blob.color": lambda: "red",
    "BoardPicture.corners": lambda: 40,
    "calibrate_floor.pixels": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "calibrate_floor.positions": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "calibrate_floor.area": lambda: (64, 48),
    "calibrate_floor.mm_per_px": lambda: 2.0,
    "calibrate_floor_by_sheets.area": lambda: (64, 48),
    "calibrate_floor_by_sheets.mm_per_px": lambda: 2.0,
    "calibrate_floor_by_sheets.pictures": lambda: [image()],
    "calibrate_lens.board": lambda: robsim.calibration.Chessboard(),
    "calibrate_lens.pictures": lambda: [image()],
    "Calibration.size": lambda: (64, 48),
    "Calibration.check_frames.size": lambda: (64, 48),
    "Camera.source": camera,
    "check_camera.camera": lambda: robsim.Camera(camera()),
    "plot_campaign.result": campaign,
    "plot_campaign.metric": lambda: "tracking_seen",
    "plot_camera_check.check": camera_check,
    "check_estimator.make": lambda: lambda: run().estimate_state,
    "check_parameter_estimator.make": lambda: lambda: robsim.RecursiveLeastSquares(5, n_filters=3),
    "CampaignResult.trace.case": lambda: 0,
    "CampaignResult.trace.run": lambda: 0,
    "CampaignSpec.seed_of.run": lambda: 0,
    "campaign.metrics": lambda: "tracking",
    "campaign.runs": lambda: 1,
    "campaign.steps": lambda: 1,
    "ColorClass.from_histograms.histograms": lambda: np.eye(3, 256, 200, int),
    "train_color.images": lambda: [red_square()],
    "train_color.regions": lambda: [(9, 9, 19, 19)],
    "Column.title": lambda: "time",
    "convergence_time.estimate": lambda: np.ones((9, 2)),
    "convergence_time.truth": lambda: np.ones(2),
    "cramer_rao_bound.phi": lambda: np.random.default_rng(1).normal(size=(9, 2)),
    "Experiment.record": lambda: "session",
    "Estimate.covariance": lambda: np.eye(3),
    "FollowPath.waypoints": lambda: [(1, 2)],
    "GigeServer.lab": lab,
    "VirtualBus.cameras": lab,
    "VirtualCamera.lab": lab,
    "instrumental_variables.u": lambda: trace().u,
    "Key.frame_noise.index": lambda: 0,
    "Key.noise_keys.frames": lambda: 3,
    "Key.write.path": lambda: "key",
    "least_squares.y": lambda: np.ones(5),
    "load_image.path": lambda: "images/0.png",
    "MarkerLayout.from_markers.markers": lambda: robsim.load_robot("lab").marker_layout().polygons,
    "MarkerLayout.from_positions.positions": lambda: {"right": (0, 9), "left": (0, 0)},
    "output_error.u": lambda: trace().u,
    "PlaneMap.at_height.height": lambda: 9.0,
    "PlaneMap.from_points.pixels": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "PlaneMap.from_points.positions": lambda: [(0, 0), (9, 0), (9, 9), (0, 9)],
    "PlaneMap.scaled.area": lambda: (300, 300),
    "plot_batch.report": lambda: robsim.batch_estimate(trace()),
    "plot_color_histograms.color": lambda: robsim.load_colors()[0],
    "plot_consistency.report": lambda: robsim.pose_consistency(trace()),
    "PoseNoise.covariance": lambda: np.eye(3),
    "posterior_cramer_rao_bound.P0": lambda: np.eye(2),
    "posterior_cramer_rao_bound.Q": lambda: np.eye(2),
    "posterior_cramer_rao_bound.R": lambda: np.eye(2),
    "Recording.source": lambda: "images",
    "RobotPanel.draw.part": lambda: "outline",
    "RobotPanel.draw.polygon": lambda: [(0, 0), (9, 0), (9, 9)],
    "RecursiveLeastSquares.update.phi": lambda: np.ones(5),
    "RecursiveLeastSquares.update.y": lambda: 1.0,
    "regression.u": lambda: trace().u,
    "robot_from_image.image": lambda: robsim.load_robot("lab").image[::4, ::4],
    "RobotDefinition.alignment": lambda: 90.0,
    "RobotDefinition.image": lambda: robsim.load_robot("lab").image,
    "RobotDefinition.markers": lambda: robsim.load_robot("lab").markers,
    "RobotDefinition.name": lambda: "lab",
    "RobotDefinition.outline": lambda: robsim.load_robot("lab").outline,
    "RobotMotion.jacobian.state": lambda: np.zeros(6),
    "Row.values": lambda: [1, 2],
    "Sample.phi": lambda: np.zeros((3, 5)),
    "Sample.y": lambda: np.zeros(3),
    "save_video.path": lambda: "video.mkv",
    "Scene.alignment": lambda: 0.0,
    "Scene.area": lambda: (300, 300),
    "score_path.waypoints": lambda: [(150, 150)],
    "Trace.poses_from.source": lambda: "truth",
    "VideoWriter.path": lambda: "video.mkv",
    "action": lambda: (0.1, 0.1),
    "address": lambda: "127.0.0.1:9",
    "alignment": lambda: 0.0,
    "angle": lambda: 0.1,
    "area": lambda: 9,
    "background": image,
    "before": lambda: (0.1, 0.2),
    "blobs": lambda: {"red": [], "blue": []},
    "blue": lambda: [(0, 0), (4, 0), (4, 4)],
    "bounding_box": lambda: (1, 1, 5, 5),
    "end": lambda: 1.0,
    "port": lambda: "/dev/robsim-nothing",
    "start": lambda: 0.0,
    "centre": lambda: (20, 20),
    "color": lambda: robsim.load_colors()[0],
    "colors": robsim.load_colors,
    "columns": lambda: [],
    "covariance": lambda: np.tile(np.eye(3), (40, 1, 1)),
    "degrees": lambda: 90.0,
    "distance": lambda: 40.0,
    "dt": lambda: 0.2,
    "error": lambda: np.ones((40, 3)),
    "estimate": lambda: np.ones((40, 3)),
    "F": lambda: np.eye(2)[None],
    "floor": lambda: (image(), image()),
    "folder": lambda: "folder",
    "fps": lambda: 5.0,
    "fraction": lambda: 0.5,
    "frame": lambda: robsim.Frame(image()),
    "frames": lambda: [robsim.Frame(image())],
    "H": lambda: np.eye(2),
    "heading": lambda: 0.1,
    "headings": lambda: 36,
    "histograms": lambda: np.ones((3, 256), int),
    "home": lambda: (image(), image()),
    "image": image,
    "innovation": lambda: np.ones((40, 3)),
    "k": lambda: 0,
    "key": lambda: "time",
    "kind": lambda: "bye",
    "last_u": lambda: (0.1, 0.2),
    "make": lambda: robsim.Spin,
    "margin": lambda: 5,
    "markers": lambda: robsim.load_robot().marker_layout(),
    "masks": lambda: {"red": np.zeros((32, 32), bool)},
    "metrics": lambda: "tracking",
    "model": robsim.RobotModel,
    "n": lambda: 3,
    "n_parameters": lambda: 5,
    "name": lambda: "mine",
    "offset": lambda: 5.0,
    "P0": lambda: np.eye(3),
    "path": lambda: "file",
    "percent": lambda: 5.0,
    "phi": lambda: np.eye(5),
    "picture": image,
    "pixel": lambda: (230, 160),
    "pixels": lambda: [(1, 2), (3, 4)],
    "point": lambda: 1,
    "points": lambda: [(1, 2), (3, 4)],
    "pose": lambda: (1, 2, 0.1),
    "pose_1": lambda: (1, 2, 0.1),
    "pose_2": lambda: (1, 2, 0.1),
    "poses": lambda: trace().pose_true,
    "position": lambda: (300, 300),
    "positions": lambda: [(1, 2), (3, 4)],
    "probability": lambda: 0.1,
    "Q": lambda: np.eye(3),
    "R": lambda: np.eye(3),
    "red": lambda: [(0, 9), (4, 9), (4, 14)],
    "region": lambda: (1, 1, 5, 5),
    "regions": lambda: [(1, 1, 5, 5)],
    "report": report,
    "resolution": lambda: (32, 32),
    "rng": lambda: np.random.default_rng(1),
    "robot": robsim.load_robot,
    "rows": lambda: [],
    "S": lambda: np.tile(np.eye(3), (40, 1, 1)),
    "scenario": lambda: robsim.Scenario(area=(300, 300)),
    "run": lambda: 0,
    "runs": lambda: 1,
    "scene": lambda: robsim.simulation.Scene(**required("robsim.Scene", robsim.simulation.Scene)),
    "secret": lambda: bytes(32),
    "seed": lambda: 1,
    "shadow_factor": lambda: 0.5,
    "shadow_left": lambda: 20,
    "sigma": lambda: 0.1,
    "simulation": run,
    "seconds": lambda: 0.1,
    "size": lambda: 80.0,
    "slots": lambda: "control",
    "source": lambda: "lab",
    "sprite": lambda: robsim.load_robot("lab").image,
    "states": lambda: np.zeros((2, 6)),
    "student": lambda: "s001",
    "submission": submission_folder,
    "submissions": submission_folder,
    "out": lambda: "out",
    "t": lambda: 0.1,
    "test": lambda: "ekf",
    "text": lambda: "seed = 1",
    "theta": lambda: robsim.RobotModel().theta,
    "theta_true": lambda: np.zeros((3, 5)),
    "title": lambda: "time",
    "tolerance": lambda: 0.1,
    "trace": trace,
    "step": robsim.Step,
    "steps": lambda: 1,
    "traces": trace,
    "truth": lambda: np.ones((40, 3)),
    "u": lambda: np.zeros(2),
    "unit": lambda: 1.0,
    "value": lambda: 1.0,
    "verdict": lambda: "well",
    "x": lambda: 1.0,
    "what": lambda: robsim.Simulation(area=(300, 300), seed=1),
    "y": lambda: 2.0,
    "z": lambda: (1, 2, 0.1),
}

#: What else has to be given, so that the other arguments are looked at.
ALSO = {
    "calibrate_floor": lambda: {"size": (64, 48)},
    "Experiment.from_folder": lambda: {"frames": []},
    "Simulation.run": lambda: {"steps": 1},
    "add_robot": lambda: {"overwrite": True},
}


def session():
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "setup.toml").write_text("format = 1")
        return robsim.sessions.Session(folder)


def floor_panel():
    tool = robsim.gui.floor_panel()
    tool.add((230, 160), (300, 300))
    return tool


#: What methods are called on, where the class cannot be made of the examples alone.
OBJECTS = {
    "TaskCalibration": calibrated,
    "Task": robsim.tasks.Measure,
    "Solution": lambda: robsim.tasks.Measure().solutions[0],
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
    "SubmissionResult": lambda: robsim.assignments.SubmissionResult,
    "Session": session,
    "Simulation": run,
    "Trace": trace,
    "SimulatedLab": lab,
    "Submission": lambda: robsim.grading.Submission(
        submission_folder(), slots="control", functions="fit"
    ),
    "LabTruth": lambda: lab().truth,
    "VirtualBus": virtual_bus,
}


def public_callables():
    """Name, function or class, and the class that a method is called on, if there is one."""
    for room in ["", *robsim._ROOMS]:
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


def cases():
    for name, function, owner in public_callables():
        types = annotations(function)
        for parameter in inspect.signature(function).parameters.values():
            case = f"{name}({parameter.name})"
            is_one = parameter.name != "self" and parameter.kind is not parameter.VAR_KEYWORD
            if is_one and case not in UNCHECKED:
                yield pytest.param(name, function, owner, parameter, types[parameter.name], id=case)


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


@pytest.mark.parametrize(("name", "function", "owner", "parameter", "kind"), list(cases()))
@pytest.mark.filterwarnings("ignore")
def test_a_value_of_a_wrong_kind_is_refused_by_name(name, function, owner, parameter, kind):
    call = bound(name, function, owner)
    given = ALSO.get(without_room(name), dict)() | required(name, function)
    case = f"{without_room(name)}({parameter.name})"
    taken = {short(value) for value in VALID.get(case, ())}
    for value in wrong_kinds(kind):
        fault = fault_of(call, given, parameter, value)
        if short(value) in taken:
            assert fault, f"{name}({parameter.name}={short(value)}) is refused: delete its line"
        else:
            assert not fault, f"{name}({parameter.name}={short(value)}): {fault}"


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
    known = {f"{without_room(one.values[0])}({one.values[3].name})" for one in cases()}
    assert VALID.keys() <= known


@pytest.mark.parametrize(
    "call",
    [
        lambda: robsim.Spin(True),
        lambda: robsim.DriveAround(hold=True),
        lambda: robsim.Frame(image(), copy=1.5),
        lambda: robsim.Frame(image(), copy=None),
    ],
)
def test_native_types_are_told_from_each_other(call):
    with pytest.raises(TypeError):
        call()
