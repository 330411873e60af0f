"""Sessions for the tests: frames whose number and pose can be read out of the picture."""

import errno
import os
from functools import cache

import numpy as np
from mcap.writer import CompressionType, Writer

import robsim
from robsim.trace.sessions import _ros
from robsim.trace.sessions.rows import Row
from robsim.trace.sessions.writer import SessionWriter

AREA = (300, 300)
SETUP = {"area": AREA, "dt": 0.2, "robot": "lab", "stop_input": (0.0, 0.0)}
_BITS, _SIDE = 16, 16  # of the number, px of a square: those of JPEG


@cache
def driven(steps=20):
    """Frames and poses of a robot that drives around."""
    drive = robsim.DriveAround()
    simulation = robsim.Simulation(seed=4, area=AREA, control=drive, measure=True)
    frames = [simulation.step().frame.image.copy() for _ in range(steps)]
    poses = robsim.Experiment(list(map(robsim.Frame, frames)), area=AREA).run().pose_measured
    assert np.isfinite(poses).all()
    return frames, poses


def numbered(k):
    """The frame of step k, with the number as black and white squares at its top, and its pose."""
    frames, poses = driven()
    pixels = frames[k % len(frames)].copy()
    for bit in range(_BITS):
        square = slice(_SIDE * bit, _SIDE * (bit + 1))
        pixels[:_SIDE, square] = 255 * (k >> bit & 1)
    return robsim.Frame(pixels, t=row_time(k), index=k), poses[k % len(poses)]


def number_of(frame):
    """The number that is drawn on a frame."""
    middle = _SIDE // 2
    row = frame.image[middle, middle : _SIDE * _BITS : _SIDE, 0]
    return int(sum(1 << bit for bit, level in enumerate(row) if level > 127))


def row_time(k):
    return 100 + 0.2 * k


def add(writer, k):
    """Record step k."""
    frame, pose = numbered(k)
    u = (k / 7, -k / 7)
    writer.add(Row(k=k, t=row_time(k), u=u, pose_measured=tuple(pose.tolist())), frame)


def record(path, steps, *, waits=True, **options):
    """Record a session of so many steps; return its writer, which is still open."""
    writer = SessionWriter(path, setup=SETUP, waits=waits, **options)
    for k in range(steps):
        add(writer, k)
    return writer


def fill_disk(monkeypatch):
    """Let every later write of a session fail."""

    def fails(file):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("robsim.trace.sessions.writer._AppendedFile.append", fails)


def write_file(path, setup, steps, compression=CompressionType.NONE, each=1):
    """Write the file of a session by hand: of lines and pictures as they are, so many a chunk."""
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=2**40, compression=compression)
        writer.start("ros2", "by hand")
        writer.add_metadata("robsim.setup", {"toml": setup})
        places = {}
        for topic, kind, text in _ros.channels():
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            places[topic] = writer.register_channel(topic, "cdr", schema)
        for k, (line, picture) in enumerate(steps):
            step = _ros._packed("std_msgs/String", line)
            writer.add_message(places[_ros.STEPS], k, step, k, k)
            if picture is not None:
                data = _ros._packed("sensor_msgs/CompressedImage", ((0, 0), "camera"), "", picture)
                writer.add_message(places[_ros.PICTURES], k, data, k, k)
            if (k + 1) % each == 0:
                writer.flush()
        writer.add_metadata("robsim.end", {"steps": str(len(steps))})
        writer.finish()


def check_agreement(session):
    """Rows, trace and pictures must tell of the same steps; return how many have a picture."""
    trace, with_frames = session.trace, []
    assert len(trace) == session.count
    np.testing.assert_array_equal(trace.k, np.arange(session.count))
    for k, observation in enumerate(session):
        assert observation.t == trace.t[k] == row_time(k)
        np.testing.assert_array_equal(trace.u[k], (k / 7, -k / 7))
        if observation.frame is not None:
            assert number_of(observation.frame) == observation.frame.index == k
            with_frames.append(observation)
    if with_frames:
        numbers = [observation.frame.index for observation in with_frames]
        seen = robsim.Experiment(with_frames, area=AREA).run().pose_measured
        np.testing.assert_allclose(seen, trace.pose_measured[numbers], atol=0.5)
    return len(with_frames)
