"""Layers on systems other than Linux: limits where the system has them."""

from __future__ import annotations

import sys

from robsim.grading._isolation._layers.layer import (
    CALLS,
    FILES,
    LIMITS,
    MEMORY,
    NETWORK,
    PIDS,
    USER,
    Layer,
)
from robsim.grading._isolation._request import Request


def shut_in_elsewhere(request: Request) -> list[Layer]:
    """Limit this process; say that the other layers are missing."""
    layers = [_limited(request)]
    if request.shut:
        reason = f"robsim knows no way on {sys.platform}"
        layers += [Layer(n, False, reason) for n in (USER, MEMORY, FILES, CALLS, PIDS, NETWORK)]
    return layers


def _limited(request: Request) -> Layer:
    try:
        from robsim.grading._isolation._layers.limits import limit
    except ImportError:
        return Layer(LIMITS, False, "the system has none")
    return limit(request.limits, own_user=False)
