"""A simulated lab on the virtual bus; each test asserts that it is the bus that is there."""

import ctypes
import os

import pytest

from doubles import VirtualBus, VirtualCamera
from waiting import wait_for

VENDOR = "robsim virtual bus"


@pytest.fixture(autouse=True)
def _bus_is_below_the_library():
    assert hasattr(ctypes.CDLL(None), "robsim_virtual_bus_is_there")


class OnTheBus:
    """Labs, and the bus that this process sees."""

    def __init__(self, cameras, options):
        # Here, as pytest reads this file where the extension is not built, too.
        from robsim import _firewire

        self.bus = VirtualBus(*cameras, **options)
        os.environ |= self.bus.environment
        wait_for(lambda: len(_firewire.cameras()) == len(cameras))
        assert all(vendor == VENDOR for _, vendor, _ in _firewire.cameras())

    def close(self):
        self.bus.close()
        del os.environ["ROBSIM_VIRTUAL_BUS"]


@pytest.fixture
def start():
    """Start a bus with cameras: ``start(lab, ...)`` or ``start(VirtualCamera(...), ...)``."""
    opened = []

    def begin(*cameras, **options):
        here = OnTheBus(cameras, options)
        opened.extend([here, *(c.lab if isinstance(c, VirtualCamera) else c for c in cameras)])
        return here.bus

    yield begin
    for one in opened:
        one.close()
