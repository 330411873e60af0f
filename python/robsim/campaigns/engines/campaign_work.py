"""The runs of a campaign as work for an engine."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable
from dataclasses import dataclass

from robsim.base.text import quoted, said_by
from robsim.campaigns.choices import Folder
from robsim.campaigns.runs import Job, Row, Worker
from robsim.campaigns.spec import CampaignSpec

#: The error of a run whose process dies.
DIED = "WorkerDied: the worker process ended in this run, whenever it was tried"


@dataclass(frozen=True)
class CampaignWork:
    """What is sent to those who do the runs of a campaign."""

    spec: CampaignSpec

    def doer(self) -> Callable[[Job], Row]:
        return Worker(self.spec).row

    def lost(self, job: Job, /) -> Row:
        return Row(*job, DIED, None, 0.0, {})


def check_can_be_sent(spec: CampaignSpec) -> None:
    """Raise TypeError for code that other processes cannot be sent."""
    parts: list[tuple[str, object]] = [
        (f"vary: {name} {label!r}", choice)
        for name, choices in spec.vary.items()
        for label, choice in choices.items()
        if not isinstance(choice, Folder)  # plain texts
    ]
    parts += [(f"metrics: {name!r}", metric) for name, metric in spec._functions.items()]
    for what, value in parts:
        remedy = f"define it in a module, or give executor='threads'; got {quoted(value)}"
        try:
            content = pickle.dumps(value)
        except Exception as error:
            raise TypeError(
                f"{what} cannot be sent to other processes ({said_by(error)}): {remedy}"
            ) from error
        if b"__main__" in content and not hasattr(sys.modules["__main__"], "__file__"):
            raise TypeError(f"{what} of a notebook or a prompt cannot be sent to others: {remedy}")
