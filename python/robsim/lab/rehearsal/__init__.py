"""Before a robot drives: the check of its camera, and a simulated lab in real time."""

from robsim.lab.rehearsal.camera_check import CameraCheck, check_camera
from robsim.lab.rehearsal.camera_findings import CameraFinding
from robsim.lab.rehearsal.faults import CameraFaults, LabTruth, Lens
from robsim.lab.rehearsal.lab import SimulatedLab

__all__ = [
    "CameraCheck",
    "CameraFaults",
    "CameraFinding",
    "LabTruth",
    "Lens",
    "SimulatedLab",
    "check_camera",
]
