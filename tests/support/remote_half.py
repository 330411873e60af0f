"""A robot half in a process of its own, and the slots of a simulation that forward to it.

A request goes over one pipe, the reply comes back over another; the pixels lie in a file that both
processes map.
"""

import math
import multiprocessing
import struct

import numpy as np

import robsim

AREA = (1200, 1200)
PATIENCE = 300  # s, after which a process that says nothing is dead

# Step, time (s), and the input that the robot got since the last step (V; NaN = as it was sent).
REQUEST = struct.Struct("=qddd")
# u, the parameters, the measured pose, the estimated one, its covariance, the further state; NaN =
# there is none.
REPLY = struct.Struct("=2d15d3d3d9d3d")
NO_PARAMETERS = np.full((3, 5), np.nan)
NO_POSE = np.full(3, np.nan)


def approach(step):
    """Drive to the middle of the area: feedback from the estimate."""
    x, y, heading = step.estimate.pose
    turn = robsim.wrap_angle(math.atan2(600 - y, 600 - x) - heading)
    return 0.6 + 0.4 * turn, 0.6 - 0.4 * turn


CONTROLS = {"drive around": robsim.DriveAround(), "approach": approach}


def pixels_in(path, resolution, mode):
    """Return the pixels in a file, mapped."""
    return np.memmap(path, np.uint8, mode=mode, shape=(resolution[1], resolution[0], 3))


def _reply_of(step, u):
    parameters = NO_PARAMETERS if step.parameters is None else step.parameters
    measured = NO_POSE if step.measurement is None else step.measurement.pose
    estimate = step.estimate
    values = (u, parameters, measured, estimate.pose, estimate.covariance, estimate.state)
    return REPLY.pack(*np.concatenate([np.ravel(value) for value in values]))


def robot_half(requests, replies, folder, resolution, control, seed):
    """The process: an experiment whose frames come over a pipe, until that is closed."""
    pixels = pixels_in(folder / "pixels", resolution, "r")
    plane_map = robsim.vision.PlaneMap.scaled(resolution, AREA)

    def frames():
        while True:
            try:
                k, t, *last_u = REQUEST.unpack(requests.recv_bytes())
            except EOFError:
                return
            frame = robsim.Frame(pixels, copy=False, t=t, index=k, plane_map=plane_map, headings=36)
            yield robsim.Observation(frame, last_u=None if math.isnan(last_u[0]) else last_u)

    experiment = robsim.Experiment(
        frames(),
        send=lambda u: replies.send_bytes(_reply_of(experiment.last_step, u)),
        frame_timeout=math.inf,
        seed=seed,
        estimate_parameters=True,
        estimate_state=robsim.estimation.reference.ExtendedKalmanFilter(),
        control=CONTROLS[control],
    )
    experiment.run().save(folder / "trace.npz")


class RemoteHalf:
    """The slots of a simulation, filled by a robot half in another process."""

    def __init__(self, sim, folder, *, control, seed, limit=None):
        self.sim = sim
        self.folder = folder
        self.limit = limit
        self.pixels = pixels_in(folder / "pixels", sim.resolution, "w+")
        self.reply = None
        self.last_u = (math.nan, math.nan)
        context = multiprocessing.get_context("spawn")
        theirs, self.requests = context.Pipe(duplex=False)
        self.replies, back = context.Pipe(duplex=False)
        self.process = context.Process(
            target=robot_half, args=(theirs, back, folder, sim.resolution, control, seed)
        )
        self.process.start()
        # So that each side sees the other one end.
        theirs.close()
        back.close()
        for slot in ("estimate_parameters", "measure", "estimate_state", "control"):
            setattr(sim, slot, getattr(self, slot))

    def receive(self):
        """Return the next reply, in its parts."""
        assert self.replies.poll(PATIENCE)
        values = np.array(REPLY.unpack(self.replies.recv_bytes()))
        u, parameters, measured, pose, covariance, state = np.split(
            values, np.cumsum((2, 15, 3, 3, 9))
        )
        return u, parameters.reshape(3, 5), measured, pose, covariance.reshape(3, 3), state

    def estimate_parameters(self, step):
        """The first stage: it exchanges all that goes over in this step."""
        self.sim.render_step(step.k, out=self.pixels)
        self.requests.send_bytes(REQUEST.pack(step.k, step.t, *self.last_u))
        self.reply = self.receive()
        return None if np.isnan(self.reply[1]).any() else self.reply[1]

    def measure(self, step):
        return None if np.isnan(self.reply[2]).any() else self.reply[2]

    def estimate_state(self, step):
        return robsim.Estimate(*self.reply[3:])

    def control(self, step):
        u = self.reply[0]
        if self.limit is not None:
            self.last_u = u = np.clip(u, -self.limit, self.limit)
        return u

    def end(self):
        """End the other process; return the last input that it sent, and its trace."""
        self.requests.close()
        stop, *_ = self.receive()
        self.process.join(PATIENCE)
        assert self.process.exitcode == 0
        while self.replies.poll(0):
            try:
                again, *_ = self.receive()
            except EOFError:
                break
            assert tuple(again) == tuple(stop), "the last message was not the stop input"
        return stop, robsim.Trace.load(self.folder / "trace.npz")

    def abandon(self):
        """Leave no process behind, whatever has happened."""
        self.requests.close()
        self.replies.close()
        self.process.join(PATIENCE)
