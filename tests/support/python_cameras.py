"""Cameras in Python that do what a test says."""

import threading

from robsim import _core
from robsim.capture import EndOfStream


def read_on(camera):
    """Return the frames of a camera, and the error that ends them."""
    frames = []
    try:
        while True:
            frames.append(camera.read(10))
    except Exception as error:
        return frames, error


class SteppedCamera:
    """Delivers an image for each permit, in either order of colours."""

    def __init__(self, images, bgr=False):
        self.images = iter(images)
        self.bgr = bgr
        self.permits = threading.Semaphore(0)
        self.calls = []

    def _open_device(self):
        return _core.PythonCamera(self, bgr=self.bgr)

    def open(self):
        self.calls.append("open")

    def read(self):
        if not self.permits.acquire(timeout=0.02):
            return None
        try:
            image = next(self.images)
        except StopIteration:
            raise EndOfStream("over") from None
        if isinstance(image, Exception):
            raise image
        return (image[:, :, ::-1].copy() if self.bgr else image), None

    def close(self):
        self.calls.append("close")


class EndlessCamera:
    """Delivers small images as fast as it can, or waits for ever."""

    def __init__(self, image, count=None):
        self.image = image
        self.left = count
        self.hangs = threading.Event()
        self.goes_on = threading.Event()

    def _open_device(self):
        return _core.PythonCamera(self)

    def open(self):
        pass

    def read(self):
        if self.hangs.is_set():
            self.goes_on.wait(60)
        if self.left is not None:
            if self.left == 0:
                raise EndOfStream("over")
            self.left -= 1
        return self.image, None

    def close(self):
        pass
