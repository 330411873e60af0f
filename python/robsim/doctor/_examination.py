"""One checkup, whatever the estimator."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from robsim._base.checks import number
from robsim.doctor._check_report import Checkup, Finding
from robsim.doctor._errors import finding_of_make
from robsim.doctor._trial import NoEstimator, Patient, Slot

BUDGET = 0.02  # s a call: a tenth of the default dt

Battery = Callable[[Patient], Iterable[Finding | str]]


def examine(make: Callable[[], Any], slot: Slot, budget: float, battery: Battery) -> Checkup:
    """Return what a battery finds in an estimator: findings, and remarks as strings.

    Parameters
    ----------
    make : callable
        Returns a fresh estimator.
    slot : Slot
        What it is for.
    budget : float
        Time that a call may take, in the median (s).
    battery : callable
        ``battery(patient)``: what is found, one after the other, the cause first.
    """
    if not callable(make):
        raise TypeError(
            f"make must be callable and return a fresh estimator, such as its class, got {make!r}"
        )
    patient = Patient(make, slot, number("budget", budget, "s", above=0))
    findings: list[Finding] = []
    remarks: list[str] = []
    try:
        for item in battery(patient):
            if isinstance(item, Finding):
                findings.append(item)
            else:
                remarks.append(item)
    except NoEstimator as none:
        findings.append(finding_of_make(patient, none.reason))
    return Checkup(
        name=patient.name,
        findings=(*findings, *_printed(patient)),
        remarks=tuple(remarks),
    )


def _printed(patient: Patient) -> list[Finding]:
    text = patient.ear.text
    if not text:
        return []
    text = text if len(text) <= 40 else f"{text[:40]} ..."
    sentence = f"it prints, {text!r} at first: in a run of 800 steps nobody can read that"
    return [Finding(kind="prints", sentence=sentence, line=patient.ear.line or patient.line)]
