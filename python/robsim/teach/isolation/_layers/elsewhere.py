"""Layers on Unix systems other than Linux, macOS for one: limits where the system has them."""

from __future__ import annotations

import sys

assert sys.platform != "win32"


from robsim.teach.isolation._layers.layer import Layer, missing_layers
from robsim.teach.isolation._layers.limits import limit
from robsim.teach.isolation.limits import Request


def shut_in_elsewhere(request: Request) -> list[Layer]:
    """Limit this process; say that the other layers are missing."""
    missing = missing_layers(sys.platform) if request.shut else []
    return [limit(request.limits, own_user=False), *missing]
