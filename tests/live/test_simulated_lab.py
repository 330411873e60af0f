"""The simulated lab: poses by its truth, never times by a clock."""

import gc
import os
import threading
import weakref
from contextlib import suppress

import numpy as np
import pytest

import robsim
from python_devices import PATIENT, read_on
from robsim.lab import (
    CameraFaults,
    CaptureError,
    FrameTimeoutError,
    Lens,
    MotorReceiver,
    SimulatedLab,
    UdpMotors,
    UnpluggedError,
)
from threads import forks, in_fork, in_thread
from waiting import wait_for

SCENARIO = robsim.Scenario(
    area=(1200, 900), resolution=(320, 240), headings=None, start=(400, 420, 0.4), seed=3
)
CORNERS = [(0, 0), (1199, 0), (1199, 899), (0, 899)]
OBLIQUE = robsim.vision.PlaneMap.from_points([(102, 60), (541, 57), (630, 455), (12, 460)], CORNERS)
LENS = robsim.vision.Intrinsics([[500, 0, 320], [0, 500, 240], [0, 0, 1]], (-0.1, 0, 0, 0, 0))
DRIVE = (8.0, 5.0)


def lab_of(scenario=SCENARIO, **options):
    return SimulatedLab(scenario, **({"fps": 100} | options))


def camera_of(lab, **options):
    return robsim.Camera(lab, **PATIENT | options)


def driven_frames(lab, count):
    """Return frames of a robot that drives a curve."""
    with camera_of(lab) as camera:
        return drive(lab, camera, count)


def drive(lab, camera, count):
    frames = []
    with UdpMotors(lab.address, ttl=60) as motors:
        while len(frames) < count:
            frames.append(camera.read())
            motors(DRIVE)
    return frames


def has_driven(lab):
    return np.isclose(lab.truth.last_u, DRIVE).all(axis=1).any()


def tick_of(lab, frame):
    return lab.truth.tick_of(frame)


@pytest.mark.long
def test_frames_are_those_of_the_true_poses_and_these_those_of_the_model():
    with lab_of() as lab:
        frames = driven_frames(lab, 25)
        truth = lab.truth
    renderer = robsim.simulation.Renderer(lab._world.scene)
    assert np.ptp(truth.pose[:, 0]) > 1  # it has moved
    for frame in frames:
        tick = truth.tick_of(frame)
        assert truth.shown[tick] == tick
        assert np.array_equal(frame.image, renderer.render(truth.pose_of(frame)))
        assert frame.t_arrival >= frame.t
        assert frame.plane_map == lab.plane_map
    assert (truth.last_u[0] == 0).all()
    assert has_driven(lab)
    for k in range(2, len(truth)):
        predicted = lab.true_model.predict(truth.pose[k - 1], truth.pose[k - 2], truth.last_u[k])
        assert np.array_equal(truth.pose[k], predicted)
    assert np.allclose(np.diff(truth.t), lab.dt, rtol=1e-6)


def test_a_lens_leads_back():
    pixels = np.array([(0.0, 0.0), (639.0, 479.0), (320.0, 100.0)])
    lens = Lens(0.1, -0.02)
    assert np.allclose(lens.distorted(lens.ideal(pixels, (640, 480)), (640, 480)), pixels)
    with pytest.raises(ValueError, match="k1"):
        Lens(-0.3).ideal(pixels, (640, 480))


@pytest.mark.long
def test_faults_are_counted_and_never_wrong():
    faults = CameraFaults(dropped=0.2, repeated=0.2, torn=0.2, late=0.2, late_by=0.015)
    with lab_of(faults=faults) as lab, camera_of(lab) as camera:
        frames = drive(lab, camera, 50)
        truth, counts = lab.truth, camera.counts
        assert lab.skipped_frames >= 0
    renderer = robsim.simulation.Renderer(lab._world.scene)
    ticks = [truth.tick_of(frame) for frame in frames]
    for frame, tick in zip(frames, ticks, strict=True):
        assert np.array_equal(frame.image, renderer.render(truth.pose[truth.shown[tick]]))
    # A repeated frame shows where the robot was, and nothing says so.
    assert (truth.shown[ticks] < ticks).any()
    assert counts.torn > 0
    assert counts.delivered == 50
    assert ticks == sorted(set(ticks))
    assert ticks[-1] + 1 > 50 + counts.torn  # some were dropped


def last_tick(lab, camera):
    """The tick of the last frame that comes before none does, or an error."""
    frame = None
    with suppress(FrameTimeoutError, UnpluggedError):
        while True:
            frame = camera.read(0.2)
    return -1 if frame is None else tick_of(lab, frame)


@pytest.mark.long
def test_the_world_goes_on_while_the_camera_is_stalled():
    with lab_of(camera_delay=0.05) as lab, camera_of(lab, frame_timeout=0.05) as camera:
        frame = camera.read(300)
        assert frame.t_arrival - frame.t >= 0.05 - 1e-9
        before = tick_of(lab, frame)
        lab.stall(300)
        wait_for(lambda: camera.counts.timeouts and len(lab.truth) > before + 30)
        last_tick(lab, camera)
        lab.stall(0)
        assert tick_of(lab, camera.read(300)) > before + 30


@pytest.mark.long
@pytest.mark.parametrize("reopen", [False, True])
def test_the_world_goes_on_while_the_camera_is_unplugged(reopen):
    with lab_of() as lab:
        with camera_of(lab, reopen=reopen) as camera:
            before = tick_of(lab, camera.read())
            lab.unplug()
            wait_for(lambda: len(lab.truth) > before + 30)
            last_tick(lab, camera)
            if not reopen:
                with pytest.raises(UnpluggedError):
                    camera.read()
                with pytest.raises(CaptureError, match="plug"):
                    robsim.Camera(lab)
            lab.plug_in()
            if reopen:
                wait_for(lambda: camera.counts.reopened)
                assert tick_of(lab, camera.read()) > before + 29
                return
        with camera_of(lab) as camera:
            assert tick_of(lab, camera.read()) > before + 29


@pytest.mark.long
def test_noise_and_exposure_change_the_pixels_after_the_optics():
    noisy = SCENARIO.replace(noise=robsim.GaussianNoise(5))
    faults = CameraFaults(drift=0.5, drift_period=0.4)
    with lab_of(noisy, faults=faults) as lab, camera_of(lab) as camera:
        frames = [camera.read() for _ in range(25)]
        truth = lab.truth
    clean = robsim.simulation.Renderer(lab._world.scene)
    for frame in frames:
        tick = truth.tick_of(frame)
        factor = 1 + 0.5 * np.sin(2 * np.pi * tick * lab.dt / 0.4)
        expected = np.minimum(factor * clean.render(truth.pose_of(frame)), 255.0)
        rest = frame.image - expected
        inside = (expected > 60) & (expected < 195)
        if inside.sum() > 20_000:
            assert abs(rest[inside].mean()) < 0.5
            assert 12 < rest[inside].std() < 13.5


def test_a_lab_ends_for_good():
    lab = lab_of()
    camera = camera_of(lab)
    lab.close()
    assert "closed" in str(read_on(camera)[1])
    camera.close()
    with pytest.raises(CaptureError, match="closed"):
        robsim.Camera(lab)
    assert lab.receiver.is_closed
    assert len(lab.truth) == len(lab.truth) > 0
    lab.close()


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="needs /proc")
def test_no_thread_outlives_it():
    def threads():
        return set(os.listdir("/proc/self/task"))

    before = threads()
    lab = lab_of()
    with camera_of(lab):
        assert len(threads() - before) >= 3
    reference = weakref.ref(lab)
    del lab
    gc.collect()
    assert reference() is None
    wait_for(lambda: threads() <= before)


@pytest.mark.long
@forks
def test_a_forked_process_is_told_that_the_lab_is_another_s():
    def look():
        for use in (lambda: lab.truth, lab.unplug, lambda: lab.stall(1), lab._open_device):
            with pytest.raises(RuntimeError, match="made in another process"):
                use()
        lab.close()
        with lab_of() as own, camera_of(own) as camera:
            camera.read()

    with lab_of() as lab, camera_of(lab) as camera:
        in_fork(look)
        camera.read()


@pytest.mark.long
def test_the_seed_says_which_frames_are_dropped():
    dropped = {3, 5, 6, 12}
    scenario = SCENARIO.replace(seed=2)
    with lab_of(scenario, faults=CameraFaults(dropped=0.3)) as lab, camera_of(lab) as camera:
        while tick_of(lab, frame := camera.read()) < 20:
            assert tick_of(lab, frame) not in dropped
        assert not dropped & set(np.flatnonzero(lab.truth.shown >= 0))


@pytest.mark.long
@pytest.mark.threads
def test_reader_motors_and_commands_at_once():
    faults = CameraFaults(dropped=0.1, repeated=0.1, torn=0.1, late=0.1, late_by=0.02)
    is_over = threading.Event()
    with lab_of(faults=faults) as lab, camera_of(lab) as camera:

        def send():
            with UdpMotors(lab.address) as motors:
                while not is_over.wait(0.003):
                    motors(DRIVE)

        def command():
            while not is_over.wait(0.02):
                lab.stall(0.005)
                assert len(lab.truth)
                assert lab.skipped_frames >= 0

        with in_thread(send), in_thread(command):
            frames = [camera.read() for _ in range(40)]
            is_over.set()
        ticks = [lab.truth.tick_of(frame) for frame in frames]
    assert ticks == sorted(set(ticks))


def test_what_cannot_be_is_refused():
    nowhere = robsim.vision.PlaneMap([[1, 0, 9000], [0, 1, 0], [0, 0, 1]])
    for options, word in (
        ({"scenario": SCENARIO.replace(camera_delay=1)}, "camera_delay"),
        ({"scenario": SCENARIO.replace(motor_delay=1)}, "motor_delay"),
        ({"scenario": SCENARIO.replace(boundary="unlimited")}, "boundary"),
        ({"scenario": SCENARIO.replace(model=robsim.RobotModel())}, "fps=5"),
        ({"lens": Lens(-0.5)}, "k1"),
        ({"lens": Lens(-0.1), "plane_map": robsim.vision.PlaneMap(OBLIQUE.matrix, LENS)}, "lens"),
        ({"plane_map": nowhere}, "plane_map"),
    ):
        with pytest.raises(ValueError, match=word):
            lab_of(**options)
    for faults in (
        *({"late": 1.1}, {"torn": -1}, {"stall": (1, -1)}, {"drift_period": 0}),
        *({"late_by": np.nan}, {"unplug": (-1, 1)}),
    ):
        with pytest.raises(ValueError, match=next(iter(faults))):
            CameraFaults(**faults)


def test_a_model_with_the_lab_s_sample_time_is_taken():
    model = robsim.RobotModel(robsim.RobotParameters(dt=0.01))
    with lab_of(SCENARIO.replace(model=model)) as lab:
        assert lab.true_model == model
    with lab_of(SCENARIO.replace(model=robsim.RobotParameters(mass=0.5))) as lab:
        assert lab.true_model == robsim.RobotModel(robsim.RobotParameters(mass=0.5, dt=0.01))


def test_a_receiver_of_ones_own_is_used():
    receiver = MotorReceiver(actuation_delay=0.03)
    with lab_of(receiver=receiver) as lab:
        assert lab.receiver is receiver
        assert str(receiver.port) in lab.address
    assert receiver.is_closed
