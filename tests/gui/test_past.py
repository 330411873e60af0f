"""Past steps: their frames, why no robot was found in them; and the size of pictures."""

import io
import itertools
import threading

import numpy as np
import pytest
from PIL import Image

import robsim
import sessions
from browsers import panel_of, settled
from robsim.gui.panels.analysis.past import KeptPictures
from robsim.gui.panels.run.camera import particles_of


@pytest.fixture(scope="module")
def noisy():
    """A run in which the robot is hidden in some steps."""
    simulation = robsim.Simulation(measure=True, dropout=robsim.Dropout(0.5), smoothing=7, seed=3)
    simulation.run(20)
    return simulation


def pixels_of(picture):
    return np.asarray(Image.open(io.BytesIO(picture)))


def is_alike(picture, frame):
    """Whether a JPEG shows a frame of 1200 px at 300."""
    shown = pixels_of(picture).astype(float)
    wanted = np.asarray(Image.fromarray(frame.image).reduce(4), float)
    return shown.shape == wanted.shape and np.abs(shown - wanted).mean() < 4


def test_a_past_step_is_drawn_again_with_its_overlays(noisy):
    k = int(np.flatnonzero(noisy.trace.seen)[2])
    with panel_of(noisy) as (_, browser):
        browser.take("frame", k=19, past=False)
        browser.say("look", k=k)
        head, (picture,) = browser.take("frame", past=True)
    assert head["k"] == k
    assert head["measured"] == noisy.trace.pose_measured[k].tolist()
    assert head["truth"] == noisy.trace.pose_true[k].tolist()
    assert {box[0] for box in head["boxes"]} == {"red", "blue"}
    assert head["missed"] is None
    assert is_alike(picture, noisy.render_step(k))


def test_a_glass_gets_pixels_with_their_classes_of_the_frame_that_is_shown(noisy):
    k = int(np.flatnonzero(noisy.trace.seen)[2])
    with panel_of(noisy) as (_, browser):
        browser.take("frame", k=19, past=False)
        for step, said in ((19, None), (k, k)):
            browser.say("look", k=said)
            browser.take("frame", k=step)
            frame = noisy.render_step(step)
            blobs = noisy.find_blobs(frame)
            at = blobs["blue"][0].centroid if blobs["blue"] else (600, 600)
            browser.say("magnify", at=[*at], half=20, glass=0)
            head, (pixels, classes) = browser.take("detail")
            left, top, width, height = head["box"]
            part = np.s_[top : top + height, left : left + width]
            assert np.frombuffer(pixels, np.uint8).tolist() == frame.image[part].ravel().tolist()
            masks = robsim.vision.classify(frame, noisy.colors, smoothing=7)
            numbers = np.frombuffer(classes, np.uint8).reshape(height, width)
            inside = np.s_[5:-5, 5:-5]  # the edge of the part has fewer neighbours
            for number, color in enumerate(noisy.colors, start=1):
                mask = masks[color.name][part]
                assert np.array_equal(numbers[inside] == number, mask[inside])
            assert numbers.any() == bool(blobs["blue"])


def test_a_robot_that_was_not_seen_is_told_from_a_measure_that_fails(noisy):
    simulation = robsim.Simulation(measure=lambda step: None, seed=1)
    simulation.run(2)
    missed = int(np.flatnonzero(~noisy.trace.seen)[-1])
    for shown, k, said in ((noisy, missed, "hidden by dropout"), (simulation, 0, "your measure")):
        with panel_of(shown) as (_, browser):
            browser.say("look", k=k)
            head, _ = browser.take("frame", past=True)
            assert head["measured"] is None
            assert said in head["missed"]


def test_a_measure_that_finds_nothing_is_told_while_the_run_goes_on():
    with panel_of(robsim.Simulation(measure=lambda step: None, seed=1)) as (_, browser):
        browser.press("step")
        browser.take("frame", missed="your measure found no robot", past=False)


@pytest.mark.long
def test_who_looks_back_gets_rows_but_no_newest_frame_until_he_returns(noisy):
    simulation = robsim.Simulation(measure=True, seed=1)
    simulation.run(5)
    with panel_of(simulation) as (_, browser):
        browser.say("columns", names=["u"])
        browser.take_rows()
        browser.say("look", k=2)
        browser.take("frame", k=2, past=True)
        browser.say("press", button="step")
        head, _ = browser.take_rows()
        assert [entry["first"] for entry in head["rows"]] == [5]
        browser.say("look", k=None)
        head, _ = browser.take("frame")
        assert (head["k"], head["past"]) == (5, False)


def test_of_many_looks_the_last_one_is_answered(noisy):
    with panel_of(noisy) as (view, browser):
        browser.take("frame")
        inside, may_go_on = threading.Event(), threading.Event()
        view.driver.call(lambda: (inside.set(), may_go_on.wait(300)))
        assert inside.wait(300)
        for k in range(15):
            browser.say("look", k=k)
        settled(view)
        may_go_on.set()
        browser.take("frame", k=14, past=True)
        view.driver.call(lambda: None).result(300)
        settled(view)
        assert browser.sent <= 4
        assert browser.all_of("frame") == []


def test_a_step_that_there_is_not_has_a_reason(noisy):
    with panel_of(noisy) as (_, browser):
        browser.say("look", k=99)
        head, _ = browser.take("past")
    assert head["k"] == 99
    assert "19" in head["reason"]  # the last one


@pytest.mark.long
def test_frames_of_a_list_are_read_again(noisy):
    frames = [noisy.render_step(k) for k in range(6)]
    experiment = robsim.Experiment(frames)
    experiment.run()
    with panel_of(experiment) as (view, browser):
        browser.take("frame", k=5, past=False)
        browser.say("look", k=1)
        _, (picture,) = browser.take("frame", k=1, past=True)
        assert len(view.past._kept) == 0  # they are in the list
    assert is_alike(picture, frames[1])


def test_of_frames_that_come_once_the_pictures_shown_are_kept(noisy):
    experiment = robsim.Experiment(noisy.render_step(k) for k in range(6))
    with panel_of(experiment) as (_, browser):
        for k in range(3):
            browser.say("press", button="step")
            shown, (picture,) = browser.take("frame", k=k)
        browser.say("look", k=2)
        head, (again,) = browser.take("frame", past=True)
        assert again == picture
        when = {"n": 0, "sent": 0}
        assert {**head, **when} == {**shown, "past": True, **when}
        assert len(browser.all_of("past")) == 0
    experiment.run(2)
    with panel_of(experiment) as (_, browser):
        browser.say("look", k=3)  # nobody has seen it
        head, (picture,) = browser.take("frame", past=True)
        assert picture == b""
        assert head["held"] == experiment.trace.pose_held[3].tolist()
        assert head["size"] == [1200, 1200]
        head, _ = browser.take("past")
        assert "only once" in head["reason"]


@pytest.mark.long
def test_frames_of_a_session_that_is_recorded_are_read_from_it(noisy, tmp_path):
    pytest.importorskip("cv2")
    frames = (noisy.render_step(k) for k in range(4))
    with robsim.Experiment(frames, record=tmp_path / "session") as experiment:
        experiment.run(4)
        with panel_of(experiment) as (_, browser):
            browser.say("look", k=2)
            _, (picture,) = browser.take("frame", k=2, past=True)
    assert is_alike(picture, noisy.render_step(2))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:.*cannot be written", "ignore:.*the first error was")
def test_a_session_that_cannot_be_written_is_noted(noisy, tmp_path, monkeypatch):
    pytest.importorskip("cv2")
    frames = (noisy.render_step(k % 20) for k in itertools.count())
    with robsim.Experiment(frames, record=tmp_path / "session") as experiment:
        experiment.run(1)
        sessions.fill_disk(monkeypatch)
        with panel_of(experiment) as (_, browser):
            browser.press("start")
            assert "No space" in browser.take("note", level="warning")[0]["text"]


def test_kept_pictures_need_no_more_than_their_room():
    kept = KeptPictures(100)
    for k in range(8):
        kept.add({"k": k}, b"x" * 30)
        kept.add({"k": k}, b"y" * 30)
    assert [k for k in range(8) if kept.get(k)] == [5, 6, 7]
    assert kept.get(7) == ({"k": 7}, b"y" * 30)


def test_a_robot_that_is_not_looked_for_has_no_last_seen_pose():
    with panel_of(robsim.Simulation(area=(300, 300), measure=True, seed=1)) as (_, browser):
        browser.press("step")
        browser.take("state", steps=1)
        browser.say("set", name="tracking", value="off")
        browser.press("step")
        assert browser.take("frame", k=1)[0]["held"] is None


def size_of_next(browser):
    head, (picture,) = browser.take("frame")
    return head["size"], Image.open(io.BytesIO(picture)).size


@pytest.mark.long
def test_a_paused_picture_comes_again_in_the_new_size():
    with panel_of(robsim.Simulation(seed=1), width=600) as (_, browser):
        assert size_of_next(browser)[1] == (600, 600)
        browser.say("size", width=1200)
        assert size_of_next(browser)[1] == (1200, 1200)


def test_a_picture_is_reduced_by_a_whole_factor_and_its_message_has_the_cameras_size():
    frames = [robsim.Frame(np.zeros((1003, 1201, 3), np.uint8))]
    with panel_of(robsim.Experiment(frames, area=(1201, 1003), measure=False)) as (_, browser):
        browser.press("step")
        # not less than 300, which the browser asks for
        assert size_of_next(browser) == ([1201, 1003], (1201 // 4, 1003 // 4))


def test_particles_are_shown_by_their_weights():
    simulation = robsim.Simulation(seed=1, measure=True, area=(300, 300))
    simulation.estimate_state = robsim.estimation.reference.ParticleFilter(simulation.model)
    with panel_of(simulation) as (_, browser):
        browser.press("step")
        head, _ = browser.take("frame", k=0)
        while not head["particles"]:  # of step 0 before it is done
            head, _ = browser.take("frame", k=0)
        spread = np.std(head["particles"], axis=0)
        assert np.abs(np.mean(head["particles"], axis=0) - head["estimate"]["pose"][:2]).max() < 2
        assert (spread < 20).all()


@pytest.mark.parametrize("particles", [np.empty((0, 3)), np.full((4, 2), "left"), None])
def test_what_an_estimator_calls_particles_may_be_anything(particles):
    class Odd:
        @property
        def particles(self):
            return {}["later"] if particles is None else particles

    assert particles_of(Odd()) is None
