"""Before a robot drives: the check of its camera, and a simulated lab in real time."""

from robsim.lab.rehearsal.camera_check import CameraCheck, check_camera
from robsim.lab.rehearsal.camera_faults import CameraFaults
from robsim.lab.rehearsal.camera_findings import CameraFinding
from robsim.lab.rehearsal.lab import SimulatedLab
from robsim.lab.rehearsal.lab_truth import LabTruth
from robsim.lab.rehearsal.lens import Lens

__all__ = [
    "CameraCheck",
    "CameraFaults",
    "CameraFinding",
    "LabTruth",
    "Lens",
    "SimulatedLab",
    "check_camera",
]
