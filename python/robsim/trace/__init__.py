"""The recorded run: named columns, slices, files."""

from robsim._base.public import present as _present
from robsim.trace._trace import PARAMETER_NAMES, RunInfo, Trace, TrackingStatistics

__all__ = [
    "PARAMETER_NAMES",
    "RunInfo",
    "Trace",
    "TrackingStatistics",
]

_present(globals())
