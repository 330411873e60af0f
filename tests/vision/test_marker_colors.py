"""A robot with a green and an orange marker: its colours have the names that its user gives."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

import robsim
from drawn_robots import box, painted
from python_cameras import PATIENT, SteppedCamera
from robsim import ColorClass
from robsim.gui import robot_panel
from robsim.live import check_camera
from robsim.plotting import plot_robot
from robsim.robots import RobotDefinition, check_colors, robot_from_image, save_robot
from robsim.vision import MarkerLayout, detect, save_colors, train_markers

GREEN, ORANGE = (30, 150, 60, 255), (245, 130, 20, 255)
COLORS = (
    ColorClass("green", u=(0, 116), v=(0, 104)),
    ColorClass("orange", u=(0, 92), v=(154, 255)),
)
NAMES = ("green", "orange")
BY_ROLE = {"right": "green", "left": "orange"}

RIGHT, LEFT = box(230, 220, 310, 320), box(80, 220, 160, 320)


def picture():
    return painted(RIGHT, LEFT, paints=(GREEN, ORANGE))


def robot():
    """Faces the top of its picture: the green marker is its right one, the orange one its left."""
    rim = 2 * np.pi * np.arange(40) / 40
    return RobotDefinition(
        name="fruit",
        image=picture(),
        size=120,
        alignment=90,
        outline=199.5 + 195 * np.column_stack((np.cos(rim), np.sin(rim))),
        markers={"right": RIGHT, "left": LEFT},
        marker_colors=BY_ROLE,
    )


MARKERS = robot().marker_layout()


@pytest.fixture
def color_file(tmp_path):
    save_colors(tmp_path / "colors.toml", COLORS)
    return tmp_path / "colors.toml"


def simulation(**options):
    options = {"colors": COLORS, "robot": robot(), "measure": True, "headings": None} | options
    return robsim.Simulation(**options, seed=4)


def test_it_is_tracked_by_a_file_of_these_colours(color_file):
    sim = simulation(colors=color_file, control=robsim.DriveAround(), noise=robsim.GaussianNoise(5))
    trace = sim.run(60)
    assert trace.seen.mean() > 0.95
    assert not trace.is_false.any()
    error = trace.error[trace.seen]
    assert np.sqrt(np.square(error[:, :2]).sum(axis=1).mean()) < 0.1
    assert np.degrees(np.abs(error[:, 2])).max() < 1
    assert set(trace.blobs) == set(NAMES)
    assert trace.info.marker_colors == NAMES


def test_it_is_found_step_by_step():
    frame = simulation(start=(300, 400, 0.7)).frame
    blobs = robsim.find_blobs(frame, COLORS, markers=MARKERS)
    assert set(blobs) == set(NAMES)
    measurement = robsim.locate(blobs, MARKERS, image=frame, colors=COLORS)
    np.testing.assert_allclose(measurement.pose, (300, 400, 0.7), atol=0.05)
    assert measurement.signal_to_noise > 4
    assert [blob.color for blob in measurement.pair.values()] == list(NAMES)
    found = detect(blobs, MARKERS, image=frame)
    assert "green and orange" in found.explanation


def test_it_gets_a_second_chance_in_dim_light():
    frame = simulation(start=(300, 400, 0.7), resolution=(600, 600)).frame
    dim = np.rint(frame.image * 0.2).astype(np.uint8)
    dim = robsim.Frame(dim, plane_map=frame.plane_map)
    blobs = robsim.find_blobs(dim, COLORS, markers=MARKERS)
    found = detect(blobs, MARKERS, image=dim, colors=COLORS)
    assert found.measurement is not None, found.explanation
    assert found.by_second_chance
    np.testing.assert_allclose(found.measurement.pose, (300, 400, 0.7), atol=0.1)


def test_what_is_missing_is_called_by_its_name():
    frame = simulation().frame
    blobs = robsim.find_blobs(frame, COLORS, markers=MARKERS)
    for left_out, reason in ((NAMES[:1], "no green blob"), (NAMES[1:], "no orange blob")):
        found = detect({name: [] if name in left_out else blobs[name] for name in NAMES}, MARKERS)
        assert found.reason == reason
        assert left_out[0] in found.explanation
        assert "blue" not in found.explanation
    assert detect({name: [] for name in NAMES}, MARKERS).reason == "no blobs"


def test_a_run_says_which_marker_was_not_seen(tmp_path):
    def cover(background):
        return np.full_like(background, 150)

    nothing_is_orange = (COLORS[0], ColorClass("orange", u=(0, 1), v=(254, 255)))
    sim = simulation(colors=nothing_is_orange, adjust_background=cover)
    trace = sim.run(3)
    assert (trace.missed_reasons == "no orange blob").all()
    assert [one.reason for one in sim.missed_detections] == ["no orange blob"]
    trace.save(tmp_path / "run.npz")
    assert (robsim.Trace.load(tmp_path / "run.npz").missed_reasons == "no orange blob").all()


def test_colours_of_another_robot_are_refused():
    with pytest.raises(ValueError, match="green and orange"):
        simulation(colors=robsim.load_colors()).run(1)


def test_the_names_are_kept_everywhere(tmp_path):
    again = pickle.loads(pickle.dumps(MARKERS))
    assert again == MARKERS
    assert again.colors == BY_ROLE
    save_robot(tmp_path / "fruit", robot())
    assert robsim.load_robot(tmp_path / "fruit").marker_colors == BY_ROLE
    positions = MarkerLayout.from_positions({"right": (0, 20), "left": (0, -20)}, colors=BY_ROLE)
    assert positions.colors == BY_ROLE
    assert eval(repr(positions), {"MarkerLayout": MarkerLayout}) == positions
    assert positions != MarkerLayout.from_positions({"right": (0, 20), "left": (0, -20)})
    scenario = robsim.Scenario(robot=robot(), colors=COLORS, markers=positions, measure=True)
    read = robsim.Scenario.from_toml(scenario.to_toml())
    assert read.robot.marker_colors == BY_ROLE
    assert read.markers == positions


def test_a_session_keeps_the_names(tmp_path):
    def frames():
        sim = simulation()
        for k in range(3):
            yield robsim.Frame(sim.frame.image, t=0.1 * k)
            sim.step()

    options = {"colors": COLORS, "robot": robot(), "measure": True}
    with robsim.Experiment(frames(), record=tmp_path / "session", **options) as experiment:
        experiment.run()
    session = robsim.sessions.Session(tmp_path / "session")
    assert session.markers.colors == BY_ROLE
    assert session.trace.seen.all()


def test_a_robot_of_these_colours_is_made_from_its_picture():
    made = robot_from_image(
        "fruit", picture(), alignment=90, colors=COLORS, marker_colors=list(NAMES)
    )
    assert made.marker_colors == BY_ROLE
    np.testing.assert_allclose(
        made.marker_layout().positions["right"], MARKERS.positions["right"], atol=0.5
    )
    assert check_colors(made, COLORS).ok
    (problem, *_) = check_colors(made).sentences
    assert "right marker (green)" in problem


def test_a_robot_that_is_drawn_by_hand_keeps_its_colours():
    tool = robot_panel(robot=robot(), colors=COLORS)
    assert tool.value.marker_colors == BY_ROLE
    tool.draw("orange", RIGHT)
    with pytest.raises(ValueError, match=r"\(green\) and .* \(orange\)"):
        _ = tool.value


def test_its_figure_names_them():
    texts = plot_robot(robot()).get_figure().findobj(Text)
    assert {"right marker (green)", "left marker (orange)"} <= {text.get_text() for text in texts}


@pytest.mark.long
def test_the_check_of_a_camera_names_them():
    image = simulation(start=(600, 600, 0.7)).frame.image
    nothing_is_orange = (COLORS[0], ColorClass("orange", u=(0, 1), v=(254, 255)))
    reports = []
    for colors in (COLORS, nothing_is_orange):
        source = SteppedCamera(3 * [image], permits=4)
        with robsim.Camera(source, area=(1200, 1200), **PATIENT) as camera:
            reports.append(check_camera(camera, robot=robot(), colors=colors, seconds=300))
    found, missed = reports
    assert found["robot detected"].verdict == "good"
    assert found["margin of orange"].value > 20
    assert "orange" in missed["robot detected"].remedy


def test_its_colours_are_trained_on_a_recording():
    frames = [simulation(start=(x, 400, 0.3)).frame for x in (200, 500, 900)]
    green, orange = train_markers(frames, MARKERS, colors=COLORS)
    assert (green.color.name, orange.color.name) == NAMES
    blobs = robsim.find_blobs(frames[0], (green.color, orange.color), markers=MARKERS)
    assert robsim.locate(blobs, MARKERS, image=frames[0]) is not None
    with pytest.raises(ValueError, match=r"colors.*green and orange"):
        train_markers(frames, MARKERS)
    with pytest.raises(ValueError, match=r"regions.*'green' and 'orange'"):
        train_markers(frames, MARKERS, regions={"red": (1, 1, 9, 9)})


def test_wrong_names():
    for names in (
        *({"right": "green", "left": other} for other in ("green", "", "a\nb", "x" * 41)),
        *({"right": "green"}, {"front": "green", "back": "orange"}, NAMES),
    ):
        with pytest.raises((TypeError, ValueError), match="colors"):
            MarkerLayout(40, 10, colors=names)
        with pytest.raises((TypeError, ValueError), match="colors"):
            replace(robot(), marker_colors=names)
