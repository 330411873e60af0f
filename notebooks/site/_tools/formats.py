"""Tables of the page `formats.md`: the keys of each file, from the code that reads the file."""

import dataclasses
import inspect
import json
import re
import tomllib
from datetime import date
from pathlib import Path

from numpydoc.docscrape import NumpyDocString

from robsim.base.files import codec
from robsim.campaigns import spec_file
from robsim.campaigns.spec import CampaignSpec
from robsim.gui.panels.replay_file import ReplayFile
from robsim.simulation import options, scenario_file
from robsim.teach import results
from robsim.teach.assignments import assignment, assignment_file, limits_file
from robsim.teach.isolation.limits import WorkerLimits
from robsim.teach.tasks.score import ScoreLimit
from robsim.trace.run_info import RunInfo
from robsim.trace.sessions import _ros, _setup, rows
from robsim.vision.imaging import calibration, calibration_file
from robsim.vision.markers import color_files
from robsim.vision.robots import definition, files

PAGE = Path(__file__).parents[1] / "formats.md"
HEADING = "key", "type", "default", "meaning and unit"
#: Meanings of keys without a separate docstring, by file.
MEANINGS = {
    "scenario.toml": {
        "format": "Version of the format",
        "headings": 'Number of drawn headings, or `"continuous"`',
    },
    "robot.toml": {
        "name": "Name of the robot",
        "image": "Name of the image beside this file; the surroundings are transparent",
        "markers.NAME.kind": "Kind of the marker",
        "markers.NAME.color": "Name of a colour class",
        "markers.NAME.polygon": "Polygon around the marker (px of the image)",
    },
    "colors.toml": {
        "NAME.y": "Smallest and largest brightness Y",
        "NAME.u": "Smallest and largest U: a larger U is bluer",
        "NAME.v": "Smallest and largest V: a larger V is redder",
    },
    "camera.toml": {
        "format": "Version of the format",
        "date": "Time of the calibration, with its zone",
        "frames.region": "Left, top, width and height of the used part of the sensor (px)",
        "lens.matrix": "Focal lengths and centre (px), 3 x 3",
        "lens.distortion": "k1, k2, p1, p2, k3 of OpenCV",
        "floor.matrix": "Map from the ideal lens to the floor, 3 x 3",
        "floor.area": "Width and height of the work area (px)",
        "floor.mm_per_px": "Length of a px of the work area (mm)",
        "floor.marker_height": "Height of the markers above the floor (mm)",
        "features.NAME": "Setting of the camera: a number, text or boolean",
        "marks": "Position of each mark of the floor sheets in the frame (px), by its number",
    }
    | {
        f"{part}.{name}": meaning
        for part in ("lens", "floor")
        for name, meaning in {
            "rms": "Root mean square of the residuals (px of the frame)",
            "worst": "Largest residual (px of the frame)",
            "points": "Number of points",
            "pictures": "Number of pictures",
        }.items()
    },
    "campaign.toml": {
        "runs": "Number of runs of each case",
        "steps": "Number of steps of a run",
        "seed": "Seed of the campaign; run i has the same seed in each case",
        "metrics": "Names of metrics, `module:function`, or tables with the kind of a score",
        "scenario": "Options of all runs, or the name of a scenario file",
        "vary.NAME": "Values of an option: a list, or a table with a label for each value",
    },
    "assignment.toml": {
        "name": "Name of the assignment",
        "title": "Title of the assignment",
        "slots": "Slots of the submission; default: the slots of the tasks",
        "functions": "Functions of the submission for the teacher's tests",
        "given": "Data of each step, `frames`, `blobs` or `pose`; default: by the tasks",
        "imports": "Modules that a submission may import; default: all",
        "masked": "Names that a submission cannot use; default: by the tasks",
        "seeds": "Owner of the hidden seeds: each `student`, or the whole `class`",
        "isolation": "Level of the sandbox",
        "points": "Points of all tests together, also of tests in other folders",
        "limits.submission": "Time of all tests of a submission together (s)",
        "late.free_days": "Number of days without a loss",
        "late.most_days": "Number of days after which the submission has no points",
        "by_hand": "Points of the teacher, by name",
        "tests.name": "Name of the test in files, and for the key",
        "tests.title": "Title of the test; default: the title of the task",
        "tests.number": "Number of the test",
        "tests.task": "Kind of the task",
        "tests.points": "Points of the test",
        "tests.parameters": "Parameters of the task",
        "files.path": "File of the teacher's tests, for pytest",
        "files.public": "Whether students get the file",
    },
    "limits.json": {
        "limits.NAME.full": "Largest value with full points",
        "limits.NAME.zero": "Smallest value without points, above `full`",
        "limits.NAME.low": "Smallest value with full points",
        "limits.NAME.low_zero": "Largest value without points, below `low`",
        "reference.NAME": "Values of the reference solution in each run",
        "calibration": "Origin of the limits, by `robsim assignment calibrate`",
        "provisional": "Reason of provisional limits; empty: the limits are exact",
    },
    "robsim.setup": {
        "area": "Width and height of the work area (px)",
        "dt": "Sample time (s)",
        "plane_map.matrix": "Map from frame to work area, 3 x 3",
        "plane_map.intrinsics.matrix": "Focal lengths and centre (px), 3 x 3",
        "plane_map.intrinsics.distortion": "k1, k2, p1, p2, k3 of OpenCV",
        "mm_per_px": "Length of a px of the work area (mm)",
        "stop_input": "Voltages that stop the robot (V)",
        "colors.name": "Name of the colour class",
        "colors.y": "Smallest and largest brightness Y",
        "colors.u": "Smallest and largest U",
        "colors.v": "Smallest and largest V",
        "markers.distance_tolerance": "Tolerance of the distance of the markers (fraction)",
        "markers.area_tolerance": "Tolerance of the areas of the markers (ratio)",
        "markers.maximum_blobs": "Number of the largest blobs of each colour in the search",
        "markers.NAME.color": "Name of the colour class",
        "markers.NAME.position": "Position, forward and right of the robot's centre (px)",
        "markers.NAME.area": "Area (px^2)",
        "markers.NAME.polygon": "Corners, forward and right of the robot's centre (px)",
        "model.dt": "Sample time of the model (s)",
        "model.theta": "Parameters: rows X, Y, P, columns a1, a2, b1, b2, d1",
        "robot": "Name of the robot",
        "started": "Start of the run, with its zone",
    },
    "/robsim/steps": {
        "k": "Number of the step",
        "frame_index": "Number of the frame",
        "t": "Time of the step (s)",
        "t_arrival": "Arrival of the frame (s)",
        "t_sent": "Time of the input (s)",
        "u": "Sent voltages of the left and the right motor (V)",
        "last_u": "Received voltages since the last step, if they differ (V)",
        "pose_measured": "x, y (px of the work area), heading (rad)",
        "reason": "Reason of a missing measurement",
        "left_out": "Reason of a missing picture",
        "interrupted": "Whether the robot was stopped after the last step",
        "headings": "Number of headings of the drawn robot",
        "plane_map.matrix": "Map of the frame, if the set-up has another one",
        "plane_map.intrinsics.matrix": "Focal lengths and centre (px), 3 x 3",
        "plane_map.intrinsics.distortion": "k1, k2, p1, p2, k3 of OpenCV",
    },
    "info": {"scenario": "The scenario as TOML"},
    "run.replay": {
        "scenario": "The scenario as TOML",
        "slots": "Slots with a file",
        "files": "Source of each Python file, by its name without `.py`",
        "changes": "Each change: step, stage, message of the browser or new files",
        "steps": "Number of steps",
        "digest": "SHA-256 of the columns of the trace",
        "format": "Version of the format",
    },
    "SubmissionResult": {
        "assignment": "Name of the assignment",
        "title": "Title of the assignment",
        "submission_digest": "SHA-256 of the submission",
        "assignment_digest": "SHA-256 of the assignment",
    },
    "TestResult": {
        "name": "Name of the test",
        "title": "Title of the test",
        "points": "Points of the submission, in hundredths",
        "most": "Points of the test",
    },
    "ScoreResult": {
        "name": "Name of the score",
        "title": "Title of the score",
        "unit": "Unit of the numbers",
        "values": "Numbers of the completed runs",
        "reference": "Numbers of the reference solution in these runs",
        "statistic": "Statistic of the numbers; null: no run was completed",
        "limit": "Largest statistic with full points",
        "zero": "Smallest statistic without points, above `limit`",
        "low": "Smallest statistic with full points",
        "low_zero": "Largest statistic without points, below `low`",
        "fraction": "Part of the score's points, 0 to 1",
        "share": "Share of the score in the points of the test; 0: a factor of all others",
    },
    "FailedRun": {
        "run": "Number of the run",
        "reason": "Reason of the failure",
        "slot": "Slot of the failure",
        "step": "Number of the step",
        "file": "File of the failure",
        "line": "Line of the failure",
        "cause": "Kind of the failure, as in `SubmissionError`",
    },
}
WORDS = {
    r", (optional|default: .*)": "",
    r"( \||,| or) None": "",
    r"Scenario or ": "",
    r"(array|MarkerLayout|\(|Any).*": "list",
    r"(mapping|Mapping|dict|ByHand|TaskCalibration).*": "table",
    r"Sequence.*": "list",
    r"tuple of \w+Re?(sult|un)": "list of tables",
    r"tuple": "list",
    r"\bint\b": "integer",
    r"\bfloat\b": "number",
    r"\bstr\b": "text",
    r"\bbool\b": "boolean",
}


def tables():
    """Return the tables by their names on the page."""
    roles = next(iter(files.ROBOT_KEYS["markers"].keys.values()))
    robot = dataclasses.replace(
        files._FILE, keys=files._FILE.keys | {"markers": codec.named(roles)}
    )
    robots = definition.RobotDefinition, definition.BlobMarker
    cameras = calibration.Calibration, calibration.Residuals
    teachers = assignment.Assignment, assignment.TaskTest, assignment.LateRule, WorkerLimits
    found = {
        "scenario": keys("scenario.toml", scenario_file._FILE, options.Options),
        "values": table(("kind", "keys"), map(values, scenario_file.TABLES.items())),
        "robot": keys("robot.toml", robot, *robots),
        "colors": keys("colors.toml", codec.named(color_files.COLOR)),
        "calibration": keys("camera.toml", calibration_file._FILE, *cameras),
        "campaign": keys("campaign.toml", spec_file._table(Path()), CampaignSpec),
        "assignment": keys("assignment.toml", assignment_file._table(Path()), *teachers),
        "limits": keys("limits.json", limits_file._TEST, limits_file.RecordedTest, ScoreLimit),
        "steps": keys("/robsim/steps", rows._STEP, rows.Row),
        "info": attributes(RunInfo, "info"),
        "replay": attributes(ReplayFile, "run.replay"),
        "setup": keys("robsim.setup", of_session()),
        "topics": table(("topic", "type"), [map(code, row) for row in _ros._TOPICS.items()]),
        "by_hand": ", ".join(map(code, assignment.BY_HAND)),
    }
    for kind in ("SubmissionResult", "TestResult", "ScoreResult", "FailedRun", "ByHand"):
        found[kind] = attributes(getattr(results, kind), kind)
    return found


def of_session():
    """Return the table of a set-up, with one role for all markers."""
    layout = files.LAYOUT
    plain = {key: row for key, row in layout.keys.items() if not isinstance(row, codec.Table)}
    role = next(row for row in layout.keys.values() if isinstance(row, codec.Table))
    markers = dataclasses.replace(layout, keys=plain | {"NAME": role})
    return dataclasses.replace(_setup._SETUP, keys=_setup._SETUP.keys | {"markers": markers})


def values(item):
    """Return the row of a class: its name, and its keys with their units."""
    kind, entry = item
    keys = [code(key) + (f" ({unit})" if unit else "") for key, unit in units(entry)]
    return code(kind.__name__), ", ".join(keys)


def units(entry):
    """Yield each key of a table with its unit, without the keys of markers and images."""
    for place, one, _ in flat(entry):
        if "." not in place:
            yield place, one.unit


def examples():
    """Return the examples of the page, by the name of the file in their first line."""
    text = PAGE.read_text(encoding="utf-8")
    blocks = re.findall(r"^`([\w./]+)`:\n\n```\w+\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    return dict(blocks)


def keys(file, entry, *kinds):
    """Return the table of a file's keys; the classes have meanings and defaults of its values."""
    example = parsed(file)
    known = {}
    for kind in reversed(kinds):
        known |= about(kind)
    rows = []
    for place, one, is_needed in flat(entry):
        kind, default, meaning = known.get(place.rpartition(".")[2], ("", "", ""))
        default = default.replace("required", "")  # by the class, which has more arguments
        given = value_at(example, place.split("."))
        kind = kind if given is None else type_of(given)
        meaning = MEANINGS[file].get(place) or meaning or one.unit
        rows.append((code(place), kind, "required" if is_needed else default, meaning))
    return table(HEADING, rows)


def attributes(kind, file):
    """Return the table of the fields of a class that a file has."""
    meanings = MEANINGS.get(file, {})
    rows = [
        (code(name), type_, default, meanings.get(name, meaning))
        for name, (type_, default, meaning) in about(kind).items()
    ]
    return table(HEADING, rows)


def parsed(file):
    """Return the example of a file as a value; an empty one without an example."""
    text = examples().get(file, "{}")
    if file == "limits.json":
        return json.loads(text)["tests"]["park"]
    is_toml = file.endswith((".toml", ".setup"))
    return tomllib.loads(text) if is_toml else json.loads(text)


def flat(entry, place=""):
    """Yield the path of each key of a table, its entry, and whether the file needs the key."""
    if isinstance(entry, codec.Table):
        for name, row in entry.keys.items():
            one = codec._entry(row)
            if isinstance(one, codec.Table) or one.each is not None:
                yield from flat(one, f"{place}{name}.")
            else:
                yield place + name, one, name in entry._needed
    elif isinstance(entry.each, codec.Table):
        is_list = place in ("tests.", "files.", "colors.")
        yield from flat(entry.each, place if is_list else f"{place}NAME.")
    else:
        yield f"{place}NAME", entry.each, False


def value_at(value, path):
    """Return the value at a path of an example; the first part of a list, or of NAME, counts."""
    if isinstance(value, list) and path and isinstance(value[0], dict):
        return next((one for part in value if (one := value_at(part, path)) is not None), None)
    if not path or not isinstance(value, dict):
        return None if path else value
    parts = value.values() if path[0] == "NAME" else [value.get(path[0])]
    return next((one for part in parts if (one := value_at(part, path[1:])) is not None), None)


def about(kind):
    """Return type, default and meaning of each field of a dataclass, from its docstring."""
    documented = {}
    if "----" in (text := inspect.getdoc(kind)):
        doc = NumpyDocString(text)
        for one in (*doc["Parameters"], *doc["Attributes"]):
            for name in one.name.split(", "):
                documented[name] = one.type, " ".join(one.desc)
    found = {}
    for field in dataclasses.fields(kind):
        option = field.metadata.get("option")
        given = (option.kind, option.doc) if option else documented.get(field.name)
        type_, meaning = given or (field.type, "")
        if option and option.types:
            type_ = "dict"
        found[field.name] = words_of(type_), default_of(field), meaning
    return found


def type_of(value):
    """Return the type of a value of TOML or JSON, in words."""
    if isinstance(value, list):
        return f"list of {type_of(value[0]).replace('list', 'lists')}s".replace("ss", "s")
    names = {bool: "boolean", int: "integer", float: "number", str: "text", dict: "table"}
    return "date" if isinstance(value, date) else names[type(value)]


def words_of(annotation):
    """Return a type of Python in the words of files."""
    for pattern, word in WORDS.items():
        annotation = re.sub(pattern, word, annotation)
    return re.sub(r"(list of \w+[^s])$", r"\1s", annotation)


def default_of(field):
    """Return the default of a field, empty for a default in words."""
    given = field.default
    if given is dataclasses.MISSING:
        return "required" if field.default_factory is given else "empty"
    text = json.dumps(given) if type(given) in (bool, int, float, str, tuple) else ""
    is_known = text.strip('"[]') and not re.search("NaN|Infinity", text)
    return code(text) if is_known else ""


def code(text):
    return f"`{text}`"


def table(heading, rows):
    """Return a table in Markdown."""
    lines = [heading, ["---"] * len(heading), *rows]
    cells = [[str(cell).replace("|", r"\|") for cell in line] for line in lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
