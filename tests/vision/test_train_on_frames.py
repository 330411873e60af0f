"""Colours trained on several frames: weak ones, drift, recordings in which the robot drives."""

import numpy as np
import pytest

import robsim
from foreign_frames import CASES, FADED, Case, frame_at, layout_of
from refusals import refuses
from robsim import ColorClass
from robsim.vision import detect, surrounding_chroma, train_color, train_markers

RED, FLOOR = (198, 36, 40), (150, 148, 146)
BOX = (40, 30, 59, 49)
SIZE = (300, 300)
MARKERS = layout_of(Case())
POSE = (300.0, 300.0, 0.5)


def picture(rgb=RED, light=1.0):
    """A floor with a square of 20 px."""
    image = np.full((100, 120, 3), FLOOR, np.uint8)
    image[30:50, 40:60] = rgb
    return (image * light).astype(np.uint8)


def box_at(frame, place, pose=POSE, half=2):
    """A region around a place on the robot (forward, right)."""
    x, y, heading = pose
    forward, right = place
    sine, cosine = np.sin(heading), np.cos(heading)
    place = x + forward * cosine - right * sine, y + forward * sine + right * cosine
    u, v = np.rint(frame.plane_map.to_pixel(place)).astype(int)
    return int(u - half), int(v - half), int(u + half), int(v + half)


def marker_boxes(frame, pose=POSE):
    return {
        name: box_at(frame, MARKERS.positions[role], pose) for role, name in MARKERS.colors.items()
    }


# --- what counts as a colour


WEAK = {
    "dark": Case(exposure=0.15),
    "dark and noisy": Case(exposure=0.15, gaussian=2),
    "dim and noisier": Case(exposure=0.3, gaussian=10),
    "faded": Case(colors=FADED),
    "faded and dim": Case(colors=FADED, exposure=0.5),
    "faded and noisy": Case(colors=FADED, gaussian=10),
    "wooden floor": CASES["wooden floor at 0.3"],
}


@pytest.mark.long
@pytest.mark.parametrize("case", WEAK.values(), ids=WEAK)
def test_weak_colours_that_stand_out_of_the_noise_are_trained_and_found(case):
    size = (600, 600)  # px, markers of 21 px
    frame = frame_at(case, POSE, size)
    classes = [
        ColorClass.from_region(frame, box_at(frame, MARKERS.positions[role], half=6), name=color)
        for role, color in MARKERS.colors.items()
    ]
    for pose in ((150.0, 400.0, 1.0), (480.0, 200.0, -2.0)):
        seen = frame_at(case, pose, size)
        blobs = robsim.find_blobs(seen, classes, markers=MARKERS)
        measurement = detect(blobs, MARKERS, plane_map=seen.plane_map).measurement
        assert measurement is not None
        assert np.hypot(*(measurement.pose[:2] - pose[:2])) < 1


def test_what_is_grey_in_this_light_is_refused():
    for case in (Case(exposure=0.2), Case(), WEAK["faded and noisy"], CASES["yellow"]):
        frame = frame_at(case, POSE, (600, 600))
        for place in ((20, 0), (0, 46), (90, 0)):  # body, wheel, floor
            with pytest.raises(ValueError, match="hardly any colour"):
                ColorClass.from_region(frame, box_at(frame, place), name="red")


def test_a_class_of_a_weak_colour_keeps_out_what_is_around_it():
    floor = np.full((140, 140, 3), (150, 140, 130), np.uint8)  # V 133
    marker = floor.copy()
    marker[14:28, 14:28] = (165, 130, 120)  # V 146
    color = ColorClass.from_region(marker, (15, 15, 26, 26), name="red")
    assert not robsim.vision.classify(floor, [color])["red"].any()
    assert robsim.vision.classify(marker, [color])["red"].sum() == 14**2


def test_the_chroma_of_what_is_around(rng):
    image = np.full((70, 140, 3), FLOOR, np.uint8)
    image[:20, :20] = RED
    np.testing.assert_array_equal(surrounding_chroma(image), [(126, 129), (0, 0)])
    noisy = np.clip(rng.normal(128, 20, (350, 350, 3)), 0, 255).astype(np.uint8)
    median, spread = surrounding_chroma(noisy)
    assert median == pytest.approx((127.5, 127.5), abs=1)
    # sd of U: 20 sqrt(22^2 + 42^2 + 64^2)/128 = 12.4, of V: 13.2; of a mean over 49 pixels 1/7
    assert spread == pytest.approx((12.4 / 7, 13.2 / 7), rel=0.15)


def test_histograms_may_come_with_what_is_around():
    image = picture((158, 144, 142))  # V 136
    histograms = robsim.vision.color_histograms(image, BOX)
    with pytest.raises(ValueError, match="hardly any colour"):
        ColorClass.from_histograms(histograms, name="red")
    with pytest.raises(ValueError, match="hardly any colour"):
        ColorClass.from_histograms(histograms, name="red", around=[(126, 129), (1, 3)])
    weaker = robsim.vision.color_histograms(picture((180, 130, 128)), BOX)
    quiet = ColorClass.from_histograms(weaker, name="red", around=[(126, 129), (1, 1)])
    assert quiet.v[0] > 129
    for wrong in ([(126, 300), (1, 1)], [(126, 129), (1, -1)], [1, 2]):
        refuses("around", ColorClass.from_histograms, weaker, name="red", around=wrong)


# --- several images


def test_the_class_of_several_images_is_as_wide_as_all_of_theirs():
    images = [picture(), picture(light=0.6), picture(light=0.2)]
    trained = train_color(images, [BOX] * 3, name="red")
    for image in images:
        one = ColorClass.from_region(image, BOX, name="red")
        assert trained.color.v[0] <= one.v[0]
        assert robsim.vision.classify(image, [trained.color])["red"].sum() == 400
    assert trained.color.v[0] == min(
        ColorClass.from_region(image, BOX, name="red").v[0] for image in images
    )
    assert trained.frames.tolist() == [0, 1, 2]
    assert trained.histograms.sum() == 3 * 3 * 400


def test_one_image_is_as_from_region():
    trained = train_color(picture(), BOX, name="red", margin=30)
    assert trained.color == ColorClass.from_region(picture(), BOX, name="red", margin=30)
    assert trained.verdict is None
    halves = train_color(picture(), [(40, 30, 49, 49), (50, 30, 59, 49)], name="red", margin=30)
    assert halves.color == trained.color
    frame = robsim.Frame(picture())
    assert train_color([frame], [BOX], name="red", margin=30).color == trained.color


def test_drift_shows_level_chroma_and_margin():
    trained = train_color([picture(), picture(light=0.5)], [BOX] * 2, name="red")
    # Y, U, V of (198, 36, 40) and (99, 18, 20)
    assert trained.medians.tolist() == [[84, 102, 208], [42, 115, 168]]
    assert trained.color.v == (148, 255)  # half of the 40 levels that are left in the dark
    assert trained.margins.tolist() == [60, 20]
    assert trained.shares.tolist() == [1, 1]
    assert (trained.drift, trained.least_margin) == (40, 20)
    assert trained.is_at_risk
    calm = train_color([picture(), picture(light=0.95)], [BOX] * 2, name="red")
    assert not calm.is_at_risk
    assert not calm.remarks
    rows = trained.to_dict()["levels"]
    assert rows["frame 1"] == {"y": 42, "u": 115, "v": 168, "margin": 20, "share": 1}


def test_wrong_images_and_regions():
    for images, regions, words in (
        (picture(), [], "regions"),
        ([picture()] * 2, BOX, "regions.*got 1 regions for 2 images"),
        (picture(), (0, 0, 500, 500), "120 x 100 px"),
    ):
        with pytest.raises((TypeError, ValueError), match=words):
            train_color(images, regions, name="red")
    with pytest.raises(ValueError, match="hardly any colour") as caught:
        train_color([picture(), picture(FLOOR)], [BOX] * 2, name="red")
    assert "2 of 2" in caught.value.__notes__[0]


# --- a recording


def drive(lights):
    """Frames of a robot on its way from left to right, one in each light."""
    for k, light in enumerate(lights):
        pose = (100.0 + 400 * k / len(lights), 300.0, 0.3 * k)
        yield frame_at(light, pose, SIZE)


def test_both_markers_are_trained_wherever_the_robot_drives():
    lights = [Case(exposure=e) for e in (1, 0.7, 0.4, 0.2)]
    red, blue = train_markers(drive(lights), MARKERS)
    assert (red.color.name, blue.color.name) == ("red", "blue")
    for one in (red, blue):
        assert one.frames.tolist() == [0, 1, 2, 3]
        assert one.missed == 0
        assert (np.diff(one.medians[:, 0]) < 0).all()  # darker and darker
        assert one.is_at_risk
    for frame in drive(lights):  # no second chance is needed any more
        blobs = robsim.find_blobs(frame, [red.color, blue.color], markers=MARKERS)
        assert detect(blobs, MARKERS, plane_map=frame.plane_map).measurement is not None


def test_colours_that_robsim_does_not_know_are_trained_from_regions_in_the_first_frame():
    green, yellow = (40.0, 150.0, 50.0), (200.0, 180.0, 30.0)
    lights = [Case(exposure=e, colors=(green, yellow)) for e in (1, 0.8)]
    with pytest.raises(ValueError, match=r"frames.*red"):
        train_markers(drive(lights), MARKERS)
    first = next(drive(lights))
    boxes = marker_boxes(first, (100.0, 300.0, 0.0))
    red, blue = train_markers(drive(lights), MARKERS, regions=boxes)
    assert len(red.frames) == len(blue.frames) == 2
    assert red.medians[0, 2] < 128  # green in the place of red


def test_frames_without_the_robot_are_counted():
    first, last = drive([Case(), Case(exposure=0.8)])
    empty = frame_at(Case(), None, SIZE)
    red, _ = train_markers([first, empty, robsim.Observation(last), robsim.Observation()], MARKERS)
    assert len(red.frames) == 2
    assert red.missed == red.to_dict()["missed"] == 1


def test_wrong_recordings():
    boxes = {"red": BOX, "blue": BOX}
    for frames, options, words in (
        ([], {}, "frames"),
        ([picture()], {"regions": {"red": BOX}}, "regions.*'red' and 'blue'"),
        ([picture()], {"regions": boxes, "colors": robsim.load_colors()}, "colors and regions"),
    ):
        with pytest.raises((TypeError, ValueError), match=words):
            train_markers(frames, MARKERS, **options)
