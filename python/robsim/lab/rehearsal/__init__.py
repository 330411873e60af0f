"""Before a robot drives: the check of its camera, and a simulated lab in real time."""

from robsim.base.public import present as _present
from robsim.lab.rehearsal.camera_check import CameraCheck, check_camera
from robsim.lab.rehearsal.camera_findings import CameraFinding
from robsim.lab.rehearsal.faults import CameraFaults
from robsim.lab.rehearsal.lab import SimulatedLab
from robsim.lab.rehearsal.lens import Lens
from robsim.lab.rehearsal.truth import LabTruth

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
