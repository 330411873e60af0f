"""Before a robot drives: the check of its camera, and a simulated lab in real time."""

from robsim._base.public import present as _present
from robsim.live._camera_check import CameraCheck, check_camera
from robsim.live._camera_findings import CameraFinding
from robsim.live._faults import CameraFaults
from robsim.live._lab import SimulatedLab
from robsim.live._lens import Lens
from robsim.live._truth import LabTruth

__all__ = [
    "CameraCheck",
    "CameraFaults",
    "CameraFinding",
    "LabTruth",
    "Lens",
    "SimulatedLab",
    "check_camera",
]

_present(globals())
