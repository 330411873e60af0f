"""Results of grading, made by hand, and with any texts in them."""

from hypothesis import strategies as st

from robsim.teach import reports as reports
from robsim.teach import results as _results
from robsim.teach.reports.pages import class_page, student_page
from robsim.teach.results import FailedRun

__all__ = ["FailedRun", "class_page", "reports", "student_page"]

#: What stands in a hidden test, and is nobody's to see.
SECRET = "kept secret"

#: Where a submission fails.
PLACE = {"slot": "estimate_state", "file": "estimate_state.py", "line": 23}


def score(name="position", **changes):
    """Return a score of ten runs, between its limits."""
    reference = tuple(2.0 + i / 10 for i in range(10))
    fields = {
        "title": f"error of the {name}",
        "unit": "px",
        "values": tuple(1.5 * value for value in reference),
        "reference": reference,
        "statistic": 1.5,
        "limit": 1.14,
        "zero": 3.2,
        "fraction": 0.73,
        "share": 1.0,
    }
    return _results.ScoreResult(name=name, **fields | changes)


def graded(name="estimate", **changes):
    """Return a public test with all that a test can have."""
    fields = {
        "title": "Estimate the state",
        "number": "1.1",
        "points": 2.92,
        "most": 4.0,
        "status": "partial",
        "sentence": "The estimate stays behind while the robot is hidden.",
        "scores": (score(),),
        "runs": 10,
        "failed": (FailedRun(run=7, reason="ValueError: no covariance", step=17, **PLACE),),
        "worst": 4,
        "picture": f"{name}.png",
        "caption": "The estimate is 43 px off in step 33.",
        "finding": "wrap the innovation",
        "output": "printed by me",
        "seconds": 3.0,
    }
    return _results.TestResult(name=name, **fields | changes)


def hidden(name="others", **changes):
    """Return a hidden test that has a secret in all that is nobody's to see."""
    secret = {
        "scores": (score(SECRET, title=SECRET),),
        "failed": (FailedRun(run=1, reason=SECRET, slot=SECRET, file=SECRET, line=4711),),
        "picture": f"{SECRET}.png",
        "caption": SECRET,
        "finding": SECRET,
        "output": SECRET,
        "whose": "submission",
    }
    fields = {"title": "In other worlds", "number": "1.2", "public": False, "points": 1.0}
    return graded(name, **secret | fields | {"sentence": "Not as good there."} | changes)


def submission(student="s001", tests=None, **changes):
    """Return a graded submission: a public test, and a hidden one."""
    fields = {
        "assignment": "hw3",
        "title": "A state estimator",
        "notes": ("plot.py is not used",),
        "isolation": "isolation: process, files (Landlock 7)",
        "submission_digest": "ab" * 32,
        "assignment_digest": "cd" * 32,
        "versions": {"robsim": "0.1.0", "python": "3.11.7"},
        "is_done": True,
        "seconds": 12.5,
    }
    tests = (graded(), hidden()) if tests is None else tuple(tests)
    return _results.SubmissionResult(student=student, tests=tests, **fields | changes)


#: A program that somebody may hand in.
PROGRAM = """
import numpy as np

# The state is a pose.
class Filter:
    def __init__(self, model):
        self.model = model
        self.pose = np.zeros(3)
        self.P = np.diag([4.0, 4.0, 0.01])

    def predict(self, u):
        jacobian = self.model.jacobian(self.pose, u)
        self.pose = self.model.predict(self.pose, u)
        self.P = jacobian @ self.P @ jacobian.T + np.diag([0.1, 0.1, 1e-4])

    def correct(self, measured):
        innovation = measured - self.pose
        innovation[2] = np.arctan2(np.sin(innovation[2]), np.cos(innovation[2]))
        gain = self.P @ np.linalg.inv(self.P + np.diag([1.0, 1.0, 0.001]))
        self.pose = self.pose + gain @ innovation
        self.P = (np.eye(3) - gain) @ self.P
"""

#: What breaks formats: ends of tags, quotes, fences and formulas, controls, directions, halves.
NASTY = (
    *("<script>alert(1)</script>", "</pre><img src=x onerror=alert(1)>", '"><b>', "&amp;", "'"),
    *("```\n# heading", "]]>", "<!--", "-->", "${7*7}", "{{7*7}}", "javascript:alert(1)"),
    *("=cmd|' /C calc'!A0", "+1+1", "-1+1", "@SUM(A1)", "\t=1+1", "\uff1d1+1", "a,b\r\nc;d"),
    *("\x00\x07\x1b[31mred\x1b]0;title\x07", "\ud800", "\ufffe", "\u202egnp.exe", "\u2028"),
    "e\u0301" * 3,
    *("a" + "\u0301" * 50, "x" * 500, "../../etc/passwd", "%00", "\N{PILE OF POO}", ""),
)


def saying(text, test=None, **changes):
    """Return a submission with a text wherever one can stand; `test`: changes of its tests."""
    says = dict.fromkeys(("title", "number", "sentence", "caption", "finding", "output"), text)
    says["scores"] = (score(title=text, unit=text),)
    says["failed"] = (FailedRun(run=1, reason=text, slot=text, file=text, line=1),)
    says |= test or {}
    tests = [graded("test0", **says), graded("test1", public=False, **says)]
    facts = {"assignment": text, "title": text, "notes": (text,), "isolation": text}
    return submission(text, tests, versions={"robsim": text}, **facts | changes)


texts = st.one_of(st.sampled_from(NASTY), st.text(st.characters(), max_size=60))


@st.composite
def any_submissions(draw):
    """Draw a result with any text, and numbers that need not fit together."""
    text, most, numbers = draw(texts), draw(st.sampled_from((1.0, 2.5, 4.0))), st.floats()
    values = tuple(draw(st.lists(numbers, max_size=3)))
    wild = {"values": values, "reference": (1.0, 0.0, 2.0), "statistic": draw(numbers)}
    test = {
        "most": most,
        "points": most * draw(st.floats(0, 1)),
        "status": draw(st.sampled_from(("passed", "partial", "failed", "error", "not run"))),
        "whose": draw(st.sampled_from((None, "submission", "assignment", "grader"))),
        "scores": (score(title=text, unit=text, fraction=draw(st.floats(0, 1)), **wild),),
    }
    return saying(text, test, is_done=draw(st.booleans()))
