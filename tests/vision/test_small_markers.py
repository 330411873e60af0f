"""Small markers and noise: windows, means, false poses."""

import dataclasses

import numpy as np
import pytest

import robsim
from robsim.vision import MarkerLayout, SmallMarkersWarning, detect
from scenes import AREA, false_poses, poses_within, renderer
from sizes import thorough

# --- small markers


LAB = robsim.load_robot("lab").marker_layout()
COLORS = robsim.load_colors()


def frame_of(size, noise=None, index=0):
    """A frame of a camera of size x size px, which sees the lab robot in the work area."""
    image = renderer(resolution=(size, size)).render((500, 600, 0.4))
    if noise is not None:
        image = noise.add(image, 3, index)
    return robsim.Frame(image, plane_map=robsim.vision.PlaneMap.scaled((size, size), AREA))


def window_of(frame, markers=LAB):
    """The smoothing that find_blobs chooses."""
    options = {"markers": markers, "minimum_area": 1, "maximum_count": 10_000}
    chosen = robsim.find_blobs(frame, COLORS, **options)
    same = [
        window
        for window in (1, 3, 5, 7)
        if robsim.find_blobs(frame, COLORS, smoothing=window, **options) == chosen
    ]
    assert len(same) == 1, "a frame in which every window finds other blobs"
    return same[0]


@pytest.mark.parametrize(
    ("size", "percent", "window"),
    [
        *((200, 15, 3), (200, 40, 3), (370, 15, 3), (200, 5, 1), (370, 5, 1)),
        *((480, 5, 3), (480, 40, 3), (800, 40, 5), (1200, 5, 7)),
    ],
)
def test_the_window_suits_the_marker_and_the_noise(size, percent, window):
    assert window_of(frame_of(size, robsim.GaussianNoise(percent))) == window


def test_the_window_suits_the_smaller_marker_and_the_far_end_of_the_floor():
    frame = frame_of(1200, robsim.GaussianNoise(10))
    unequal = MarkerLayout.from_positions(
        {"right": (-14, 22), "left": (-14, -22)}, areas={"right": 900, "left": 100}
    )
    one_known = MarkerLayout.from_positions(
        {"right": (-14, 22), "left": (-14, -22)}, areas={"right": 100}
    )
    assert window_of(frame, unequal) == window_of(frame, one_known) == 3
    # the far end, at the top, is seen at half the scale
    oblique = robsim.vision.PlaneMap.from_points(
        [(300, 0), (899, 0), (1199, 1199), (0, 1199)], [(0, 0), (1200, 0), (1200, 1200), (0, 1200)]
    )
    assert window_of(robsim.Frame(frame.image, plane_map=oblique)) < 7


def test_the_width_of_a_marker():
    assert LAB.width_in(frame_of(1200)) == pytest.approx(np.sqrt(LAB.areas["right"]))
    assert LAB.width_in(frame_of(240)) == pytest.approx(np.sqrt(LAB.areas["right"]) / 5)
    assert np.isnan(MarkerLayout(43, 14).width_in(frame_of(240)))
    one_known = MarkerLayout.from_positions(
        {"right": (-14, 22), "left": (-14, -22)}, areas={"left": 100}
    )
    assert one_known.width_in(frame_of(1200)) == pytest.approx(10)


def measured(camera, noise, poses):
    """Measured minus true poses (N, 3), NaN where none was found; nan poses = empty floor."""
    draw = renderer(resolution=camera)
    plane_map = robsim.vision.PlaneMap.scaled(camera, AREA)
    errors = np.full((len(poses), 3), np.nan)
    for i, pose in enumerate(poses):
        image = noise.add(draw.render(np.nan_to_num(pose, nan=-9 * AREA[0])), 1, i)
        frame = robsim.Frame(image, plane_map=plane_map)
        blobs = robsim.find_blobs(frame, COLORS, markers=LAB)
        found = detect(blobs, LAB, image=frame, colors=COLORS).measurement
        if found is not None:
            errors[i] = found.pose - np.nan_to_num(pose)
            errors[i, 2] = robsim.wrap_angle(errors[i, 2])
    return errors


def rates(camera, noise, count, *, empty):
    """Of some frames those with a pose and with a false one, and of empty floors those with one."""
    errors = measured(camera, noise, poses_within(np.random.default_rng(1), count, margin=70))
    nowhere = measured(camera, noise, np.full((empty, 3), np.nan))
    found = np.isfinite(errors[:, 0])
    return found.sum(), false_poses(errors[found]).sum(), np.isfinite(nowhere[:, 0]).sum()


# Without the count of false alarms, 10 to 40 poses of 40 are false.
@pytest.mark.long
@pytest.mark.parametrize("camera", [(240, 240), (320, 240)])
@pytest.mark.parametrize("noise", [robsim.GaussianNoise(40), robsim.UniformNoise(60)])
def test_hardly_a_false_pose_in_strong_noise(camera, noise):
    _, false, on_empty_floor = rates(camera, noise, 40, empty=80)
    assert false <= 3
    assert on_empty_floor <= 4  # at most 1 in 200 is to be expected


@pytest.mark.long
def test_small_markers_are_found_in_noise():
    for noise in (robsim.GaussianNoise(20), robsim.UniformNoise(40)):
        found, *wrong = rates((320, 240), noise, 25, empty=25)
        assert found >= 23
        assert wrong == [0, 0]


# --- pairs by chance


def blobs_of(rng, count, *pairs):
    """Specks of a marker's area anywhere on a floor of 1000 x 1000 px, and pairs of markers."""

    def blob(color, u, v, area):
        box = (int(u), int(v), int(u) + 20, int(v) + 20)
        return robsim.vision.Blob(color, area=area, centroid=(u, v), bounding_box=box)

    found = {"red": [], "blue": []}
    for color, blobs in found.items():
        for u, v in rng.uniform(50, 950, (count, 2)):
            blobs.append(blob(color, u, v, int(rng.uniform(200, 900))))
    for (u, v), area in pairs:
        found["red"].append(blob("red", u, v + 43, area))
        found["blue"].append(blob("blue", u, v, area))
    return found


def ring_probability(tolerance):
    """Of a distance within a fraction of 43 px of this, if both blobs lie anywhere."""
    return 4 * np.pi * tolerance * 43**2 / 900**2


def test_false_alarms_are_the_pairs_to_be_expected_by_chance(rng):
    blobs = blobs_of(rng, 12, ((500, 500), 531), ((100, 100), 900))  # the second is too far off
    detection = detect(blobs, LAB)
    areas = {
        color: (np.log([b.area / LAB.areas["right"] for b in found]) / np.log(LAB.area_tolerance))
        ** 2
        for color, found in blobs.items()
    }
    others = {
        color: areas[color][[b != best for b in blobs[color]]]
        for color, best in (("red", detection.seen["right"]), ("blue", detection.seen["left"]))
    }
    sums = others["red"][others["red"] <= 1][:, None] + others["blue"][others["blue"] <= 1]
    rest = np.clip(detection.misfit - sums, 0, 1)
    expected = np.sqrt(rest).sum() * ring_probability(LAB.distance_tolerance)
    assert detection.false_alarms == pytest.approx(expected, rel=0.3)  # the floor is estimated


def test_a_pair_among_many_specks_must_fit_well():
    rng = np.random.default_rng(5)
    good, poor = ((500, 500), 531), ((500, 500), 300)
    assert detect(blobs_of(rng, 0, poor), LAB).reason is None  # nothing else is about
    results = [detect(blobs_of(rng, 25, pair), LAB) for pair in 20 * [good]]
    # a perfect pair is taken unless another pair happens to fit as well
    assert sum(result.measurement is not None for result in results) >= 12
    results = [detect(blobs_of(rng, 25, pair), LAB) for pair in 20 * [poor]]
    assert {result.reason for result in results} <= {"by chance", "ambiguous"}
    refused = next(result for result in results if result.reason == "by chance")
    assert refused.false_alarms > 0.005
    assert "by chance" in refused.explanation


def test_without_a_robot_specks_are_taken_for_one_in_one_of_200_frames_at_most():
    rng = np.random.default_rng(6)
    reported = sum(
        detect(blobs_of(rng, int(rng.integers(1, 40))), LAB).measurement is not None
        for _ in range(400)
    )
    assert reported <= 8  # 2 are to be expected at most


# --- what the noise asks of the markers


# Nine in ten are found at 1.25 times the trusted width, hardly one at 0.6 of it.
@pytest.mark.long
@pytest.mark.parametrize(("percent", "px"), [(10, 143), (40, 317)])
def test_the_trusted_width_is_where_robots_begin_to_be_found(percent, px):
    """The width is that of the warning, in a camera of so many px."""
    noise = robsim.GaussianNoise(percent)
    poses = poses_within(np.random.default_rng(3), 40, margin=70)

    def seen(times):
        errors = measured((round(times * px),) * 2, noise, poses)
        return np.isfinite(errors[:, 0]).sum()

    assert seen(1.25) >= 36
    assert seen(0.6) <= 12


# --- the warning


def noisy_camera(percent=30, **options):
    options = {
        **{"noise": robsim.GaussianNoise(percent), "measure": True, "resolution": (200, 200)},
        **options,
    }
    return robsim.Simulation(robot="lab", seed=1, **options)


def test_the_warning_comes_once_and_names_size_noise_figure_and_limit():
    sim = noisy_camera()
    with pytest.warns(SmallMarkersWarning, match=r"3\.8 px.*76\.5 grey.*30 %.*4\.3 px") as caught:
        sim.run(2)
    (warning,) = caught
    assert warning.filename == __file__
    assert warning.message.width == pytest.approx(3.84, abs=0.01)
    assert warning.message.noise == pytest.approx(76.5)
    assert warning.message.signal_to_noise == pytest.approx(3.08, abs=0.01)
    assert warning.message.trusted_width == pytest.approx(4.27, abs=0.01)
    sim.run(2)
    sim.reset()
    sim.run(2)  # warnings are errors here
    with pytest.warns(SmallMarkersWarning):
        noisy_camera().step()


def test_more_noise_is_looked_at_again():
    sim = noisy_camera(percent=5)
    sim.run(2)
    sim.noise = robsim.UniformNoise(60)
    with pytest.warns(SmallMarkersWarning, match=r"88\.3 grey"):
        sim.run(2)


def test_an_experiment_measures_the_noise():
    for size, percent in ((60, 2), (90, 10), (90, 20), (200, 30)):
        with pytest.warns(SmallMarkersWarning) as caught:
            robsim.Experiment([frame_of(size, robsim.GaussianNoise(percent))], robot="lab").run()
        told = caught[0].message
        assert told.noise == pytest.approx(2.55 * percent, rel=0.27)  # some of it is clipped
        assert told.width == pytest.approx(23.04 * size / 1200, abs=0.01)
    robsim.Experiment([frame_of(200, robsim.GaussianNoise(10))], robot="lab").run()


def test_a_frame_without_a_robot_says_what_the_noise_asks_for():
    image = np.full((200, 200, 3), 128, np.uint8)
    plane_map = robsim.vision.PlaneMap.scaled((200, 200), AREA)

    def explained(noise):
        frame = robsim.Frame(noise.add(image, 1), plane_map=plane_map)
        return detect({"red": [], "blue": []}, LAB, image=frame)

    assert explained(robsim.GaussianNoise(10)).reason == "no blobs"
    small = explained(robsim.GaussianNoise(35))
    assert small.reason == "small markers"
    assert "3.8 px" in small.explanation


def test_no_warning_without_need():
    for options in (
        {"measure": False},  # nobody measures
        {"percent": 20},
        {"resolution": (320, 320)},
        {"area": (300, 300)},
        {"measure": lambda step: None},  # by code of one's own
    ):
        noisy_camera(**options).run(2)  # warnings are errors here


# --- means of windows


# share of frames in which the robot is found; rms of the place (px) and the heading (degrees)
ASKED = {1200: (0.995, 0.7, 1.3), 480: (0.95, 2.0, 4.0)}


def check_the_default_measurement(noise, camera, *, steps, seed):
    sim = robsim.Simulation(
        robot="lab",
        resolution=(camera, camera),
        headings=None,
        noise=noise,
        measure=True,
        control=robsim.DriveAround(),
        seed=seed,
    )
    tracking = sim.run(steps).tracking()
    share, rmse_xy, rmse_heading_deg = ASKED[camera]
    assert tracking.seen >= share * steps
    assert tracking.false_poses == 0
    assert tracking.rmse_xy < rmse_xy
    assert tracking.rmse_heading_deg < rmse_heading_deg


@pytest.mark.long
@pytest.mark.parametrize("noise", [robsim.UniformNoise(40), robsim.GaussianNoise(40)])
@pytest.mark.parametrize("camera", ASKED)
def test_the_robot_is_found_in_noise_of_40_percent(noise, camera):
    # Of 1000 frames, a share of 0.5 % is known to 0.2 %.
    check_the_default_measurement(noise, camera, steps=thorough(1000, 150), seed=11)


@pytest.mark.long
@pytest.mark.parametrize("name", ["robot2", "sheep"])
def test_other_robots_are_found_in_strong_noise(name):
    options = {"headings": None, "noise": robsim.GaussianNoise(30)}
    sim = robsim.Simulation(robot=name, measure=True, seed=5, **options)
    tracking = sim.run(20).tracking()
    assert (tracking.seen, tracking.false_poses) == (20, 0)


def options_of(sim):
    sim.step()
    return sim._core.minimum_area, sim._core.maximum_count, sim._core.smoothing


def test_what_is_looked_for_comes_from_the_robot():
    # Markers of 531 px of the area: 23 px wide, at 480 px 9.2; an eighth of their area.
    lab = robsim.load_robot("lab")
    assert options_of(robsim.Simulation(robot=lab, measure=True)) == (66, 64, 7)
    assert options_of(robsim.Simulation(robot=lab, measure=True, resolution=(480, 480))) == (
        11,
        64,
        3,
    )
    few = dataclasses.replace(lab, maximum_blobs=3)
    assert options_of(robsim.Simulation(robot=few, measure=True, smoothing=1)) == (66, 3, 1)
    bare = robsim.vision.MarkerLayout(43, 14)  # knows no areas
    assert options_of(robsim.Simulation(markers=bare, measure=True)) == (12, 64, 1)


def test_find_blobs_takes_them_from_markers_too():
    sim = robsim.Simulation(robot="lab", resolution=(480, 480), noise=robsim.GaussianNoise(40))
    markers = robsim.load_robot("lab").marker_layout()
    found = robsim.find_blobs(sim.frame, sim.colors, markers=markers)
    assert found == robsim.find_blobs(sim.frame, sim.colors, minimum_area=11, smoothing=3)
    assert found == sim.find_blobs(sim.frame)
    # of an array nobody knows the scale: a pixel counts as one of the area
    plain = robsim.find_blobs(sim.frame.image, sim.colors, markers=markers)
    assert all(blob.area >= 66 for blob in plain["red"])
