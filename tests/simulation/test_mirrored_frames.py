"""Frames in OpenCV's order that were taken for RGB: what tells, and what is no false alarm."""

import warnings

import numpy as np
import pytest

import robsim
from drawn_robots import box, painted
from robsim.simulation.mirrored_frames import drives_backwards
from robsim.vision import BlobMarker, RobotDefinition
from sizes import thorough

pytestmark = pytest.mark.long

SHIPPED = ["lab", "robot2", "sheep"]


def frames_of(robot, steps, *, bgr, **options):
    """Frames of a simulation, and its inputs; with BGR pixels that are taken for RGB."""
    options = {"resolution": (480, 480), "seed": 2} | options
    sim = robsim.Simulation(robot=robot, **options)
    frames, inputs = [], []
    for _ in range(steps):
        step = sim.step()
        frames.append(step.frame)
        inputs.append(step.u)
    if bgr:
        frames = [robsim.Frame.from_bgr(f.image, plane_map=f.plane_map, t=f.t) for f in frames]
    return frames, inputs


@pytest.mark.parametrize("robot", SHIPPED)
def test_one_frame_tells_by_the_image_of_the_robot(robot):
    for bgr, noise in (
        (True, robsim.GaussianNoise(10)),
        (False, robsim.GaussianNoise(10)),
        (True, None),
    ):
        (frame,), _ = frames_of(robot, 1, bgr=bgr, noise=noise)
        experiment = robsim.Experiment([frame], robot=robot)
        if bgr:
            with pytest.warns(UserWarning, match=r"BGR.*Frame\.from_bgr"):
                experiment.run()
        else:
            experiment.run()  # warnings are errors


def test_many_poses_and_floors_raise_no_false_alarm(rng):
    for robot in SHIPPED:
        for seed in range(thorough(6, 2)):
            floor = np.kron(rng.integers(0, 256, (60, 60, 3)), np.ones((20, 20, 1)))
            sim = robsim.Simulation(
                robot=robot,
                resolution=(600, 600),
                noise=robsim.GaussianNoise(20),
                seed=seed,
                start=(*rng.uniform(200, 1000, 2), rng.uniform(-3, 3)),
                background=floor.astype(np.uint8) if seed % 2 else None,
            )
            robsim.Experiment([sim.step().frame], robot=robot).run()


def unlike(rng, kind):
    """A robot with two square markers on a gray body, or a body of which parts are colourful."""
    red, blue = box(240, 240, 311, 311), box(96, 240, 167, 311)
    image = painted(red, blue, body=(*[rng.integers(30, 220)] * 3, 255))
    is_body = (image[..., 3] > 0) & (
        abs(image[..., :3].astype(int) - image[20, 200, :3]).max(2) < 9
    )
    if kind == "striped":
        is_body &= (np.indices(is_body.shape).sum(axis=0) // 40) % 2 == 0
        image[is_body, :3] = rng.integers(0, 256, 3)
    if kind == "front":
        is_body[200:] = False
        image[is_body, :3] = rng.integers(0, 256, 3)
    rim = 2 * np.pi * np.arange(40) / 40
    return RobotDefinition(
        name="unlike",
        image=image,
        size=120,
        alignment=90,
        outline=199.5 + 195 * np.column_stack((np.cos(rim), np.sin(rim))),
        markers={"right": BlobMarker(red, "red"), "left": BlobMarker(blue, "blue")},
    )


@pytest.mark.parametrize("kind", ["plain", "striped", "front"])
def test_a_robot_that_does_not_look_like_its_image_raises_no_false_alarm(rng, kind):
    seen = 0
    lab = robsim.load_robot("lab")
    for _ in range(3):
        robot = unlike(rng, kind)
        start = (*rng.uniform(200, 1000, 2), rng.uniform(-3, 3))
        sim = robsim.Simulation(robot=robot, start=start, resolution=(600, 600))
        seen += robsim.Experiment([sim.step().frame], robot=lab, markers=robot).run().seen.sum()
    assert seen > 1


@pytest.mark.parametrize("control", [robsim.DriveAround(), robsim.control.PseudoRandomBinary()])
def test_the_motion_tells_where_the_image_does_not(control):
    plain = unlike(np.random.default_rng(1), "plain")
    lab = robsim.load_robot("lab")
    for bgr in (True, False):
        frames, inputs = frames_of(plain, 40, bgr=bgr, control=control, resolution=(300, 300))
        replay = robsim.Replay(np.array(inputs))
        experiment = robsim.Experiment(frames, robot=lab, markers=plain, control=replay)
        if bgr:
            with pytest.warns(UserWarning, match="driving backwards"):
                experiment.run()
        else:
            experiment.run()


def test_a_robot_that_lags_is_not_driving_backwards(rng):
    voltage = np.repeat(rng.uniform(-0.5, 1.5, 20), 5)
    u = np.column_stack((voltage, voltage))
    for lag in range(6):
        speed = 6 * np.roll(voltage, lag)
        x = 100 + np.concatenate(([0], np.cumsum(speed)[:-1]))
        poses = np.column_stack((x, np.full(100, 300), np.zeros(100)))
        assert not drives_backwards(u, poses)
        poses[:, 2] = np.pi
        assert drives_backwards(u, poses)


def test_without_motion_nothing_is_said():
    u = np.ones((100, 2))
    path = np.column_stack((-5.0 * np.arange(100), np.zeros((100, 2))))
    assert drives_backwards(u, path)
    still, unseen, few = path.copy(), path * np.nan, path.copy()
    still[:, 0] = 300 + 0.1 * (np.arange(100) % 2)
    few[15:] = np.nan
    for poses in (still, unseen, few):
        assert not drives_backwards(u, poses)


def test_frames_are_looked_at_seldom():
    frames, _ = frames_of("lab", 6, bgr=True)
    experiment = robsim.Experiment(frames, robot="lab")
    said = []
    for _ in range(6):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            experiment.run(1)
        said.append(len(caught))
    assert said == [1, 1, 0, 1, 0, 0]
