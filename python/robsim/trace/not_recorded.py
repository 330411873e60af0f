"""The error of a run that did not record what is needed, and how to record it."""

from __future__ import annotations

from collections.abc import Mapping

_TRUTH = "only a simulation knows the truth, recorded frames do not have it"
_NOT_FITTED = (
    "run with measure=True; a measure of your own must return that of robsim.locate with "
    "image=..., or a Measurement with it"
)
_UNSEEN = "the robot was never seen; a measure of your own must return its Measurement"

# How a group of columns is recorded.
_HOW = {
    "pose_true": _TRUTH,
    "theta_true": _TRUTH,
    "u": "there was no controller: give control=..., or control=robsim.Replay(u) for inputs that "
    "were recorded with the frames",
    "pose_measured": "run with measure=True",
    "pose_held": "run with measure=True",
    "covariance_measured": _NOT_FITTED,
    "misfit": _NOT_FITTED,
    "signal_to_noise": _NOT_FITTED,
    "missed": "the default measurement missed no frame, or there was none: run with measure=True",
    "pose_estimated": "run with estimate_state=...",
    "covariance": "run with estimate_state=...",
    "parameters": "run with estimate_parameters=True",
    "standard_errors_unscaled": "run with estimate_parameters=True",
    "t_arrival": "only a live camera says when frames arrived: give one to robsim.Experiment",
    "t_sent": "no input went out: give send=... to robsim.Experiment",
}

# Why a group that was recorded has no number.
_WHY_UNKNOWN = {
    "pose_true": _TRUTH,
    "pose_measured": _UNSEEN,
    "pose_held": _UNSEEN,
    "parameters": "let estimate_parameters return the parameters, (3, 5)",
    "covariance": "let estimate_state return Estimate(pose, covariance)",
    "standard_errors_unscaled": "an estimator of your own gives none",
}


class NotRecordedError(ValueError):
    """A run did not record what is needed of it.

    Attributes
    ----------
    columns : tuple of str
        What the trace does not have: ``("pose_estimated",)``.
    remedy : str
        How to record it, or why it is not known: ``"run with estimate_state=..."``.
    """

    def __init__(self, columns: tuple[str, ...], remedy: str) -> None:
        super().__init__(columns, remedy)
        self.columns = columns
        self.remedy = remedy

    def __str__(self) -> str:
        return f"the trace has no {', '.join(self.columns)}: {self.remedy}"


def how_recorded(name: str) -> str:
    return _HOW.get(name, "it was not recorded in this run")


def not_recorded(missing: Mapping[str, bool], *, steps: int) -> NotRecordedError:
    """Return the error for columns that are not known.

    Parameters
    ----------
    missing : mapping of str to bool
        The columns, and whether each was recorded, but is not known in any step.
    steps : int
        Number of steps of the run.
    """
    if not steps:
        return NotRecordedError(tuple(missing), "it has no steps")
    remedies = (
        _WHY_UNKNOWN.get(name, "it is not known in any step") if is_recorded else how_recorded(name)
        for name, is_recorded in missing.items()
    )
    return NotRecordedError(tuple(missing), "; ".join(dict.fromkeys(remedies)))
