"""The page of errors: a row for each class of the package, and for errors of Python."""

import inspect

#: What to do about each class.
REMEDIES = {
    "SmallMarkersWarning": "Larger markers, a closer camera, or a larger resolution",
    "NotRecordedError": "Rerun with the option that the message names",
    "CallbackError": "Correct the line of the callback that the message names",
    "CallbackTypeError": "Return the type that the message names",
    "CallbackValueError": "Return the shape and the range that the message names",
    "CaptureError": "Catch all errors of cameras, and print the message",
    "CameraBusyError": "Close the other program",
    "EndOfStream": "End the loop; open the file again for a second pass",
    "FrameTimeoutError": "Read again; check cable, exposure and frame rate if the error repeats",
    "NoBackEndError": "Install the package that the message names",
    "NoBandwidthError": "Reduce frame rate or resolution, or use another bus",
    "NoBusError": "Check the adapter and its driver",
    "NoCameraError": "Run `robsim cameras` and choose an address of its list",
    "NoPermissionError": "Give the user access to the device as the message says",
    "UnpluggedError": "Check the cable; `Camera` opens the camera again",
    "HaltedError": "Call `resume` when frames come again",
    "LineError": "Check the address, the cable and the robot's power",
    "GradingError": "Catch all errors of grading; `whose` names the origin",
    "AssignmentError": "Correct the file of the assignment; `robsim assignment check` repeats it",
    "GraderError": "Rerun on another machine; no submission loses points",
    "IsolationError": "Grade on Linux or in a container, or choose a lower level",
    "SubmissionError": "Report file and line to the student",
}
#: Errors of Python: when they occur, and what to do.
OF_PYTHON = (
    (
        "TypeError, ValueError",
        "An argument or a key of a file is invalid.",
        "The message names the argument, the expectation and the value. Correct the value.",
    ),
    ("FileNotFoundError, OSError", "A file cannot be read or written.", "Check path and rights"),
    (
        "ImportError",
        "An optional package is missing.",
        "Install the package that the message names",
    ),
    ("PermissionError", "A replay file has code.", "Read the code, then use ``trust=True``"),
    (
        "TimeoutError",
        "A callback exceeds the time limit, or no frame arrives.",
        "Shorten the callback, or increase the limit",
    ),
)


def page(classes):
    """Return the page for classes by their full names."""
    rows = [
        (
            f":obj:`~{name}`",
            ", ".join(base.__name__ for base in kind.__bases__),
            " ".join(inspect.getdoc(kind).partition("\n\n")[0].split()).replace("`", "``"),
            REMEDIES[name.rpartition(".")[2]].replace("`", "``"),
        )
        for name, kind in classes.items()
    ]
    own = table("Errors of robsim", ("error", "is also", "when", "remedy"), rows)
    others = table("Errors of Python", ("error", "when", "remedy"), OF_PYTHON)
    return f"Errors and warnings\n===================\n\n{own}\n{others}"


def table(title, heading, rows):
    lines = "".join("   * - " + "\n     - ".join(row) + "\n" for row in (heading, *rows))
    return f".. list-table:: {title}\n   :header-rows: 1\n\n{lines}"
