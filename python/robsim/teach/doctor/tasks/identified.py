"""What the worst run of a parameter estimator shows, beside the reference in the same run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robsim.base.check_report import Problem
from robsim.base.checks import Floats
from robsim.teach.doctor.tasks.seen_run import SeenRun
from robsim.teach.tasks.trial import TaskTrial

_TAKEN = 0.8  # of the samples that the reference takes
_EARLY, _LATE = 0.2, 0.6  # of a run: up to here it learns most, from here on it should have settled
_UNREST = 0.2  # late beside early; right ones have up to 0.03


def parameter_findings(trial: TaskTrial) -> Iterator[Problem]:
    """Yield what the worst run of a parameter estimator shows."""
    if (run := SeenRun.of(trial)) is None:
        return
    own, others = (_changes(one.parameters) for one in (run.trace, run.reference))
    taken, offered = int((own > 0).sum()), int((others > 0).sum())
    if not taken:
        yield run.problem("no adaptation", "its parameters never change")
        return
    if taken < _TAKEN * offered:
        yield run.problem(
            "leaves samples out",
            f"its parameters change in {taken} steps, those of the reference in {offered}: it "
            "leaves samples out, and each of them tells something",
        )
    unrest, least = (_unrest(moves) for moves in (own, others))
    if unrest < _UNREST:
        return
    moves = (
        f"in the last 40 % of the run its parameters move {unrest:.2g} times as far as in the "
        f"first 20 %, those of the reference {least:.2g} times"
    )
    if unrest > 1:
        yield run.problem(
            "gain stays",
            f"{moves}: its gain does not become smaller with the samples that it has seen. P is to "
            "be reduced by each, P = P - outer(K, phi @ P); a gradient method has no P",
        )
    else:
        yield run.problem(
            "does not settle",
            f"{moves}: either it forgets too fast, and the forgetting factor must be nearer to 1; "
            "or it begins with too small a P, and learns too slowly: begin with a large one",
        )


def _unrest(moves: Floats) -> float:
    """Return how far parameters move late in a run, relative to early."""
    n = len(moves)
    late, early = moves[round(_LATE * n) :].sum(), moves[: round(_EARLY * n)].sum()
    return float(late / early) if early else 0.0


def _changes(theta: Floats) -> Floats:
    """Return how far the parameters (N, 3, 5) move in each step; 0 where there are none yet."""
    moves = np.diff(np.nan_to_num(theta), axis=0).reshape(len(theta) - 1, -1)
    is_first = ~np.isfinite(theta[:-1]).all(axis=(1, 2))
    return np.where(is_first, 0.0, np.linalg.norm(moves, axis=1))
