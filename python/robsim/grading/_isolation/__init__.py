"""Workers: processes in which submissions run, shut in, limited, and certainly ended."""

from robsim.grading._isolation._check import IsolationReport, check_isolation
from robsim.grading._isolation._ending import Ending
from robsim.grading._isolation._limits import Limits
from robsim.grading._isolation._process import WorkerProcess
from robsim.grading._isolation._request import Isolation
from robsim.grading._isolation._start import IsolationError, start_worker

__all__ = [
    "Ending",
    "Isolation",
    "IsolationError",
    "IsolationReport",
    "Limits",
    "WorkerProcess",
    "check_isolation",
    "start_worker",
]
