"""The poses that fit the markers' edges best."""

import robsim


def measure(step):
    return robsim.locate(step.blobs, step.markers, image=step.frame, colors=step.colors)
