"""Workers: processes that run submissions in a sandbox, with limits and a certain end."""

from robsim.teach.isolation._process import WorkerProcess
from robsim.teach.isolation.check import IsolationReport, check_isolation
from robsim.teach.isolation.ending import Ending
from robsim.teach.isolation.limits import Isolation, WorkerLimits
from robsim.teach.isolation.start import IsolationError, start_worker

__all__ = [
    "Ending",
    "Isolation",
    "IsolationError",
    "IsolationReport",
    "WorkerLimits",
    "WorkerProcess",
    "check_isolation",
    "start_worker",
]
