"""What a trace tells of the run it is the record of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from robsim._core import RobotModel
from robsim.base.seeds import seed_record
from robsim.simulation.slotted import is_code
from robsim.trace import RunInfo

if TYPE_CHECKING:
    from robsim.simulation.runner import Runner


def run_info(runner: Runner) -> RunInfo:
    """Return what describes the run of a simulation or an experiment."""
    core = runner._core
    return RunInfo(
        dt=core.model.dt if core.has_started else RobotModel().dt,
        theta_true=runner._theta_true(),
        seed=seed_record(runner._seed),
        identify_from=runner.identify_from,
        area=runner.area,
        boundary=runner.boundary,
        robot=runner.robot.name,
        marker_colors=(*runner.markers.colors.values(),),
        scenario=runner._described(),
        changed=runner._changed,
        mm_per_px=runner._mm_per_px(),
        headings=runner._headings(),
        callbacks=tuple(slot for slot, value in runner._callbacks.items() if is_code(value)),
    )
