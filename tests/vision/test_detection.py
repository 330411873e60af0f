"""The pose of a pair of blobs, its misfit, and the reason when there is none."""

import pickle
import re

import numpy as np
import pytest

import robsim
from robsim.vision import MarkerLayout, detect

LAYOUT = MarkerLayout(40, 14)
KNOWN = MarkerLayout.from_positions(
    {"right": (-14, 20), "left": (-14, -20)}, areas={"right": 441, "left": 441}
)
UNEQUAL = MarkerLayout.from_positions(
    {"right": (-14, 20), "left": (-14, -20)}, areas={"right": 225, "left": 441}
)

RED = ("red", 90, 100, 21)
BLUE = ("blue", 90, 60, 21)


def blobs_of(*squares):
    """The blobs of squares: (colour, u, v, side)."""
    image = np.full((200, 200, 3), 100, np.uint8)
    for color, u, v, side in squares:
        image[v : v + side, u : u + side] = {"red": (220, 30, 30), "blue": (30, 60, 220)}[color]
    return robsim.find_blobs(image, robsim.load_colors())


def located(markers, *squares, **options):
    return robsim.locate(blobs_of(*squares), markers, **options)


def test_the_pose_of_a_hand_made_pair():
    # Blue above red: the line from blue to red points down, so that the robot faces right; the
    # centre lies 14 px ahead of the midpoint.
    x, y, heading = located(LAYOUT, BLUE, RED).pose
    assert (x, y) == pytest.approx((100 + 14, 90))
    assert heading == pytest.approx(0)


def test_the_plane_map_takes_the_pose_to_the_work_area():
    plane_map = robsim.vision.PlaneMap.scaled((200, 200), (500, 500))
    x, y, heading = located(MarkerLayout(100, 35), BLUE, RED, plane_map=plane_map).pose
    assert (x, y) == pytest.approx(np.add(plane_map.to_world((100, 90)), (35, 0)))
    assert heading == pytest.approx(0)


def test_markers_in_any_place_give_the_pose(rng):
    red, blue = np.add(rng.uniform(-30, 30, (2, 2)), [[40, 0], [-40, 0]])  # front, back
    corners = 8 * np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]])
    markers = MarkerLayout.from_markers({"front": red + corners, "back": blue + corners})
    heading, centre = 0.7, np.array([101.0, 93.0])
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    places = [np.rint(centre + turn @ place - 8).astype(int) for place in (red, blue)]
    pose = located(markers, ("red", *places[0], 17), ("blue", *places[1], 17)).pose
    np.testing.assert_allclose(pose[:2], centre, atol=1.0)
    assert pose[2] == pytest.approx(heading, abs=0.02)


def test_a_pair_that_fits():
    detection = detect(blobs_of(RED, BLUE), KNOWN)
    assert detection.measurement == robsim.locate(blobs_of(RED, BLUE), KNOWN)
    assert detection.measurement.pose == pytest.approx((114, 90, 0))
    assert detection.misfit == pytest.approx(0, abs=1e-9)
    assert detection.runner_up == np.inf
    assert (detection.seen["right"].color, detection.seen["left"].color) == ("red", "blue")
    assert detection.seen["right"].centroid == pytest.approx((100, 110))
    assert detection.distance == pytest.approx(40)
    assert detection.reason is None
    assert "red and blue blobs 40.0 px" in detection.explanation


def test_the_misfit_is_the_sum_of_squared_deviations():
    # 2 px too far apart, the red area 361 in place of 441
    detection = detect(blobs_of(("red", 91, 103, 19), BLUE), KNOWN)
    area = np.log(361 / 441) / np.log(KNOWN.area_tolerance)
    assert detection.misfit == pytest.approx((2 / 40 / 0.12) ** 2 + area**2)


def test_the_runner_up_is_the_second_pair_that_fits():
    other = ("red", 90, 22, 21)  # 38 px from the blue one
    detection = detect(blobs_of(RED, BLUE, other), KNOWN)
    assert detection.measurement is not None
    assert detection.runner_up == pytest.approx((2 / 40 / 0.12) ** 2)


@pytest.mark.parametrize(
    ("squares", "reason", "words"),
    [
        ([], "no blobs", "no red and no blue"),
        ([BLUE], "no red blob", "right"),
        ([RED], "no blue blob", "left"),
        ([("blue", 90, 0, 21), ("red", 90, 40, 21)], "at the border", "border"),
        ([BLUE, ("red", 90, 160, 21)], "distance", "100.0 px"),
        ([BLUE, ("red", 80, 90, 41)], "areas", "1681 of 441 px^2, left marker (blue) 441"),
        ([RED, BLUE, ("red", 90, 20, 21)], "ambiguous", "0.00 and 0.00"),
    ],
)
def test_the_reasons(squares, reason, words):
    detection = detect(blobs_of(*squares), KNOWN)
    assert detection.measurement is None
    assert robsim.locate(blobs_of(*squares), KNOWN) is None
    assert detection.reason == reason
    assert words in detection.explanation
    if len(squares) < 2:
        assert detection.seen is None
        assert (detection.misfit, detection.runner_up) == (np.inf, np.inf)
        assert np.isnan(detection.distance)


def test_the_pair_most_like_the_markers_is_named():
    # A speck at the right distance from the blue blob is less like a marker than a square as large.
    speck = ("red", 98, 108, 5)
    detection = detect(blobs_of(BLUE, ("red", 90, 145, 21), speck), KNOWN)
    assert (detection.reason, detection.seen["right"].area) == ("distance", 441)


def explained(layout, *squares):
    return detect(blobs_of(*squares), layout).explanation


def test_causes_in_the_pair():
    small = [("red", 95, 110, 11), ("blue", 95, 90, 11)]  # half as large, half as far apart
    assert "another size of the work area" in explained(KNOWN, *small)
    assert "another size of the work area" not in explained(LAYOUT, *small)
    half = [("red", 95, 110, 11), ("blue", 90, 80, 21)]
    assert "another robot" in explained(KNOWN, *half)
    faint = [("red", 94, 104, 13), ("blue", 94, 64, 13)]
    assert "darker" in explained(KNOWN, *faint)
    assert "another robot" in explained(KNOWN, ("red", 80, 90, 41), ("blue", 94, 64, 13))


def test_exchanged_colours_are_told_where_the_areas_differ():
    mirrored = [("red", 90, 100, 21), ("blue", 93, 63, 15)]
    detection = detect(blobs_of(*mirrored), UNEQUAL)
    assert detection.measurement is not None
    assert detection.misfit > 0.1
    assert "Frame.from_bgr" in detection.explanation
    right = detect(blobs_of(("red", 93, 103, 15), BLUE), UNEQUAL)
    assert right.misfit == pytest.approx(0, abs=1e-9)
    assert "BGR" not in right.explanation
    # markers of the same area cannot tell
    assert "BGR" not in detect(blobs_of(RED, BLUE), KNOWN).explanation


def test_a_step_has_the_detection_of_the_default_measurement():
    sim = robsim.Simulation(measure=True, seed=1, resolution=(600, 600))
    step = sim.step()
    assert step.detection.measurement == step.measurement
    assert step.detection == detect(step.blobs, sim.markers, image=step.frame)
    sim.measure = lambda step: robsim.Measurement((1, 2, 3))
    assert sim.step().detection is None
    unmeasured = robsim.Simulation(seed=1).step()
    assert unmeasured.detection is None
    ready = robsim.Experiment([robsim.Observation(unmeasured.frame, measurement=(1, 2, 3)), None])
    assert ready.step().detection is None
    assert ready.missed_detections == []


def missed(frames, **options):
    experiment = robsim.Experiment([robsim.Frame(image) for image in frames], **options)
    experiment.run()
    return experiment


def test_what_was_missed_in_a_run():
    image = robsim.Simulation(seed=1).frame.image
    small = np.full_like(image, 100)
    small[:600, :600] = image[::2, ::2]
    experiment = missed([image, image // 100, small, image // 100])
    dark, half = experiment.missed_detections
    assert (dark.reason, dark.steps, dark.first_k) == ("dark", 2, 1)
    assert (half.reason, half.steps, half.first_k) == ("distance", 1, 2)
    assert half.first.distance == pytest.approx(21.5, abs=0.5)
    experiment.reset()
    experiment.run(1)
    assert experiment.missed_detections == []


def overexposed(image):
    return np.clip(image.astype(int) * 6, 0, 255).astype(np.uint8)


@pytest.mark.long
@pytest.mark.parametrize(
    ("disturb", "reason", "explanation"),
    [
        (lambda image: image // 10, "dark", "dark"),
        (overexposed, "overexposed", "overexposed"),
        (
            lambda image: image[::30, ::30],
            "small markers",
            r"0\.7 px wide.* 2\.\d px",
        ),
        (lambda image: np.full_like(image, 150), "no blobs", "no red and no blue"),
    ],
)
def test_causes_in_the_frame(disturb, reason, explanation):
    sim = robsim.Simulation(seed=1)
    image = np.ascontiguousarray(disturb(sim.frame.image))
    size = image.shape[1::-1]
    plane_map = robsim.vision.PlaneMap.scaled(size, sim.area)
    frame = robsim.Frame(image, plane_map=plane_map)
    blobs = robsim.find_blobs(frame, sim.colors, markers=sim.markers)
    for picture in (frame, image):
        detection = detect(blobs, sim.markers, plane_map=plane_map, image=picture)
        assert detection.reason == reason
        assert re.search(explanation, detection.explanation)
        assert pickle.loads(pickle.dumps(detection)) == detection
    # without the picture nothing is known of it
    assert detect(blobs, sim.markers, plane_map=plane_map).reason not in ("dark", "overexposed")


def test_a_dark_floor_is_no_fault_where_the_robot_is_found():
    image = np.zeros((200, 200, 3), np.uint8)
    for color, u, v, side in (RED, BLUE):
        image[v : v + side, u : u + side] = {"red": (220, 30, 30), "blue": (30, 60, 220)}[color]
    blobs = robsim.find_blobs(image, robsim.load_colors())
    assert detect(blobs, KNOWN, image=image).reason is None
