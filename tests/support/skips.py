"""Which reasons a test may be left out for: those of tests/skips.txt, any other one fails it."""

import os
import re
from functools import cache
from pathlib import Path

FILE = Path(__file__).parents[1] / "skips.txt"


@cache
def allowed():
    """Return the reasons that are allowed here, as one pattern."""
    sections = re.split(r"^\[(.*)\]$", FILE.read_text(), flags=re.MULTILINE)[1:]
    lines = [
        line
        for title, text in zip(sections[::2], sections[1::2], strict=True)
        if not (title.startswith("unless ROBSIM_NEEDS") and os.environ.get("ROBSIM_NEEDS"))
        for line in text.split("\n")
        if line and not line.startswith("#")
    ]
    return re.compile("|".join(f"(?:{line})" for line in lines))


def fail_if_unlisted(report):
    """Return a report of pytest: failed, if it was skipped for a reason that is not listed."""
    if report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[2].removeprefix("Skipped: ")
        if not allowed().fullmatch(reason):
            report.outcome = "failed"
            report.longrepr = f"left out for a reason that is not in {FILE.name}: {reason}"
    return report
