"""Says in a sentence why steps of a run are without a detection, for ``run`` and ``track``."""

from __future__ import annotations

from collections.abc import Sequence

from robsim._core import MissedDetections

# The reasons that are not words yet; the others, such as "no blue blob", are.
_WORDS = {
    "noise": "the markers do not stand out of the noise",
    "at the border": "blobs at the border of the frame only",
    "distance": "no pair of blobs at the markers' distance",
    "areas": "no pair of blobs with the markers' areas",
    "ambiguous": "two pairs of blobs that fit equally well",
    "by chance": "blobs that may fit by chance",
    "dark": "a dark picture",
    "overexposed": "an overexposed picture",
    "small markers": "markers too small for the noise of the frame",
}


def explain_missed(missed: Sequence[MissedDetections], steps: int) -> str | None:
    """Return a sentence on the steps without a detection.

    Parameters
    ----------
    missed : sequence of MissedDetections
        The most frequent reason first.
    steps : int
        Steps of the run.

    Returns
    -------
    str or None
        The sentence, with the numbers of the first step that was missed for the most frequent
        reason; None if nothing was missed.
    """
    if not missed:
        return None
    total = sum(part.steps for part in missed)
    most = missed[0]
    share = f"in {most.steps}, " if len(missed) > 1 else ""
    return (
        f"no detection in {total} of {steps} steps: {share}first in step {most.first_k}, "
        f"{most.first.explanation}"
        + "".join(
            f"; in {part.steps}: {_WORDS.get(part.reason, part.reason)}" for part in missed[1:]
        )
    )
