"""What `detect` says of its choice: the pair, its misfit, the reason when there is none."""

import copy
import pickle
import re

import numpy as np
import pytest

import robsim
from robsim.vision import MarkerLayout, detect
from robsim.vision._missed_detections import explain_missed

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


def test_a_pair_that_fits():
    detection = detect(blobs_of(RED, BLUE), KNOWN)
    assert detection.measurement == robsim.locate(blobs_of(RED, BLUE), KNOWN)
    assert detection.measurement.pose == pytest.approx((114, 90, 0))
    assert detection.misfit == pytest.approx(0, abs=1e-9)
    assert detection.runner_up == np.inf
    assert (detection.pair["right"].color, detection.pair["left"].color) == ("red", "blue")
    assert detection.pair["right"].centroid == pytest.approx((100, 110))
    assert detection.distance == pytest.approx(40)
    assert detection.reason is None
    assert detection.explanation.startswith("red and blue blobs 40.0 px of the work area apart fit")


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
    ("squares", "reason", "explanation"),
    [
        ([], "no blobs", "no red and no blue blob was detected"),
        ([BLUE], "no red blob", "no red blob was detected that could be the right marker"),
        ([RED], "no blue blob", "no blue blob was detected that could be the left marker"),
        ([("blue", 90, 0, 21), ("red", 90, 40, 21)], "at the border", "touch the border"),
        ([BLUE, ("red", 90, 160, 21)], "distance", "100.0 px of the work area apart, the markers"),
        (
            [BLUE, ("red", 80, 90, 41)],
            "areas",
            "right marker (red) 1681 of 441 px^2, left marker (blue) 441",
        ),
        ([RED, BLUE, ("red", 90, 20, 21)], "ambiguous", r"(misfits 0.00 and 0.00)"),
    ],
)
def test_the_reasons(squares, reason, explanation):
    detection = detect(blobs_of(*squares), KNOWN)
    assert detection.measurement is None
    assert robsim.locate(blobs_of(*squares), KNOWN) is None
    assert detection.reason == reason
    assert explanation in detection.explanation
    assert reason in repr(detection)


def test_without_a_pair_there_are_no_numbers():
    detection = detect(blobs_of(RED), KNOWN)
    assert detection.pair is None
    assert (detection.misfit, detection.runner_up) == (np.inf, np.inf)
    assert np.isnan(detection.distance)


def test_the_pair_most_like_the_markers_is_named():
    # A speck at the right distance from the blue blob is less like a marker than a square as large.
    speck = ("red", 98, 108, 5)
    detection = detect(blobs_of(BLUE, ("red", 90, 145, 21), speck), KNOWN)
    assert (detection.reason, detection.pair["right"].area) == ("distance", 441)


def test_everything_at_another_scale_is_told():
    small = [("red", 95, 110, 11), ("blue", 95, 90, 11)]
    assert "another size of the work area" in detect(blobs_of(*small), KNOWN).explanation
    assert "another size of the work area" not in detect(blobs_of(*small), LAYOUT).explanation
    half = [("red", 95, 110, 11), ("blue", 90, 80, 21)]
    assert detect(blobs_of(*half), KNOWN).explanation.endswith("40.0 px: is it another robot?")


def test_areas_too_small_are_told_as_dark():
    faint = [("red", 94, 104, 13), ("blue", 94, 64, 13)]
    assert "darker" in detect(blobs_of(*faint), KNOWN).explanation


def test_an_area_too_small_and_one_too_large_are_told_as_another_robot():
    unequal = [("red", 80, 90, 41), ("blue", 94, 64, 13)]
    assert detect(blobs_of(*unequal), KNOWN).explanation.endswith("px^2: is it another robot?")


@pytest.mark.parametrize(
    ("squares", "areas"),
    [
        (
            [BLUE, ("red", 80, 90, 41)],
            "right marker (red) 1681 of 441 px^2, left marker (blue) 441 of 1681",
        ),
        (
            [RED, ("blue", 80, 50, 41)],
            "right marker (red) 441 of 1681 px^2, left marker (blue) 1681 of 441",
        ),
    ],
)
def test_markers_of_unknown_area_are_to_be_as_large_as_each_other(squares, areas):
    detection = detect(blobs_of(*squares), LAYOUT)
    assert detection.reason == "areas"
    assert areas in detection.explanation


def test_exchanged_colours_are_told_where_the_areas_differ():
    mirrored = [("red", 90, 100, 21), ("blue", 93, 63, 15)]
    detection = detect(blobs_of(*mirrored), UNEQUAL)
    assert detection.measurement is not None
    assert detection.exchanged_misfit == pytest.approx(0, abs=1e-9) != detection.misfit
    assert "Frame.from_bgr" in detection.explanation
    right = detect(blobs_of(("red", 93, 103, 15), BLUE), UNEQUAL)
    assert right.misfit == pytest.approx(0, abs=1e-9)
    assert "BGR" not in right.explanation
    # markers of the same area cannot tell
    assert detect(blobs_of(RED, BLUE), KNOWN).exchanged_misfit == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("squares", [[RED, BLUE], [RED], [BLUE, ("red", 90, 160, 21)]])
def test_a_detection_is_a_value(squares):
    detection = detect(blobs_of(*squares), LAYOUT)
    again = detect(blobs_of(*squares), LAYOUT)
    for other in (again, copy.deepcopy(detection), pickle.loads(pickle.dumps(detection))):
        assert other == detection
        assert hash(other) == hash(detection)
        assert other.explanation == detection.explanation
        assert repr(other.pair) == repr(detection.pair)
    assert detection != detect(blobs_of(*squares), KNOWN)


def test_a_measurement_is_a_value():
    measurement = robsim.Measurement((1, 2.5, 0.1))
    assert repr(measurement) == "Measurement([1.0, 2.5, 0.1])"
    known = robsim.Measurement(
        (1, 2.5, 0.1), covariance=np.diag((4e-4, 9e-4, 1e-6)), signal_to_noise=12.34
    )
    assert repr(known) == (
        "<Measurement: x 1.00 px, y 2.50 px, heading 0.1000 rad; "
        "+- 0.02 px, 0.03 px, 0.001 rad; signal to noise 12.3>"
    )
    for other in (copy.copy(measurement), pickle.loads(pickle.dumps(measurement))):
        assert other == measurement
        assert hash(other) == hash(measurement)
    assert measurement != robsim.Measurement((1, 2.5, 0.2))


def test_a_step_has_the_detection_of_the_default_measurement():
    sim = robsim.Simulation(measure=True, seed=1, resolution=(600, 600))
    step = sim.step()
    assert step.detection.measurement == step.measurement
    assert step.detection == detect(step.blobs, sim.markers, image=step.frame)
    sim.measure = lambda step: robsim.Measurement((1, 2, 3))
    assert sim.step().detection is None
    assert robsim.Simulation(seed=1).step().detection is None


def test_a_ready_measurement_has_no_detection():
    frame = robsim.Simulation(seed=1).frame
    experiment = robsim.Experiment([robsim.Observation(frame, measurement=(1, 2, 3)), None])
    assert experiment.step().detection is None
    assert experiment.missed_detections == []


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
    sentence = explain_missed(experiment.missed_detections, 4)
    assert sentence.startswith(
        "no detection in 3 of 4 steps: in 2, first in step 1, the picture is"
    )
    assert sentence.endswith("; in 1: no pair of blobs at the markers' distance")
    experiment.reset()
    experiment.run(1)
    assert experiment.missed_detections == []
    assert explain_missed([], 1) is None


@pytest.mark.long
@pytest.mark.parametrize(
    ("disturb", "reason", "explanation"),
    [
        (lambda image: image // 10, "dark", r"the picture is dark: mean level \d+ of 255"),
        (
            lambda image: np.clip(image.astype(int) * 6, 0, 255).astype(np.uint8),
            "overexposed",
            r"the picture is overexposed: \d+ % of its pixels are white",
        ),
        (
            lambda image: image[::30, ::30],
            "small markers",
            r"the markers are 0\.7 px wide in the frame, and its noise is .* markers of 2\.\d px",
        ),
        (lambda image: np.full_like(image, 150), "no blobs", "no red and no blue blob"),
    ],
)
def test_causes_in_the_frame(disturb, reason, explanation):
    sim = robsim.Simulation(seed=1)
    image = np.ascontiguousarray(disturb(sim.frame.image))
    size = image.shape[1::-1]
    plane_map = robsim.imaging.PlaneMap.scaled(size, sim.area)
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


def test_another_robot():
    sim = robsim.Simulation(robot="robot2", markers="lab", resolution=(600, 600), measure=True)
    sim.run(3)
    assert [missed.reason for missed in sim.missed_detections] == ["distance"]
    assert "the markers 43.0 px: is it another robot?" in explain_missed(sim.missed_detections, 3)
