"""Runs that are small and quick, for the tests of the panel."""

import threading

import numpy as np

import robsim

IMAGE = np.zeros((64, 64, 3), np.uint8)
SOON = 300  # s


def simulation(**options):
    small = {"area": (300, 300), "resolution": (75, 75), "seed": 1}
    return robsim.Simulation(**{"control": robsim.DriveAround(), **small, **options})


def frames(count=5):
    return [robsim.Frame(IMAGE)] * count


def experiment(source, **options):
    given = {"area": (64, 64), "measure": False, "identify_from": "truth", "frame_timeout": 1000}
    return robsim.Experiment(source, **(given | options))


def robsim_threads():
    return {thread for thread in threading.enumerate() if thread.name.startswith("robsim")}


def done(future):
    return future.result(SOON)
