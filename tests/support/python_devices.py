"""Cameras and motors in Python, whose tests set their acts."""

import threading

from robsim.lab import EndOfStream

#: s; for a camera whose frames come for sure, however busy the machine is.
PATIENT = {"open_timeout": 300, "frame_timeout": 300}


def read_on(camera):
    """Return the frames of a camera, and the error that ends them."""
    frames = []
    try:
        while True:
            frames.append(camera.read(300))
    except Exception as error:
        return frames, error


class SteppedCamera:
    """Delivers an image for each permit, in either order of colours."""

    def __init__(self, images, bgr=False, permits=0):
        self.images = iter(images)
        self.bgr = bgr
        self.permits = threading.Semaphore(permits)
        self.calls = []

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
    """Delivers small images as fast as it can; where it `hangs`, when `goes_on` is set."""

    def __init__(self, image, count=None):
        self.image = image
        self.left = count
        self.hangs = threading.Event()
        self.is_hanging = threading.Event()
        self.goes_on = threading.Event()

    def open(self):
        pass

    def read(self):
        if self.hangs.is_set():
            self.is_hanging.set()
            self.goes_on.wait(300)
        if self.left is not None:
            if self.left == 0:
                raise EndOfStream("over")
            self.left -= 1
        return self.image, None

    def close(self):
        pass


class Sender:
    """It keeps what it is sent, or raises its `error`."""

    def __init__(self):
        self.sent = []
        self.error = None

    def __call__(self, u):
        if self.error is not None:
            raise self.error
        self.sent.append(tuple(u))

    @property
    def stands(self):
        return self.sent[-1:] == [(0.0, 0.0)]
