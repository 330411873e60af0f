"""The recorded run: named columns with units, slices, files; sessions, which include frames."""

from robsim.trace.columns import PARAMETER_NAMES, NotRecordedError
from robsim.trace.run_info import RunInfo
from robsim.trace.sessions.session import Session
from robsim.trace.summary import TraceSummary
from robsim.trace.timing import TimingReport
from robsim.trace.trace import Trace
from robsim.trace.tracking import TrackingStatistics

__all__ = [
    "PARAMETER_NAMES",
    "NotRecordedError",
    "RunInfo",
    "Session",
    "TimingReport",
    "Trace",
    "TraceSummary",
    "TrackingStatistics",
]
