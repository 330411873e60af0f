"""Rehearsals in real time: a simulated lab with a camera, a robot and a motor line."""

from robsim._base.public import present as _present
from robsim.live._faults import CameraFaults
from robsim.live._lab import SimulatedLab
from robsim.live._lens import Lens
from robsim.live._truth import LabTruth

__all__ = ["CameraFaults", "LabTruth", "Lens", "SimulatedLab"]

_present(globals())
