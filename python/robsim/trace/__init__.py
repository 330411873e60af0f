"""The recorded run: named columns with units, slices, files."""

from robsim._base.public import present as _present
from robsim.trace._columns import PARAMETER_NAMES
from robsim.trace._not_recorded import NotRecordedError
from robsim.trace._run_info import RunInfo
from robsim.trace._summary import TraceSummary
from robsim.trace._timing import TimingReport
from robsim.trace._trace import Trace
from robsim.trace._tracking import TrackingStatistics

__all__ = [
    "PARAMETER_NAMES",
    "NotRecordedError",
    "RunInfo",
    "TimingReport",
    "Trace",
    "TraceSummary",
    "TrackingStatistics",
]

_present(globals())
