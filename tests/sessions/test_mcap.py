import io
import math
import sys

import numpy as np
import pytest
from PIL import Image

import robsim
import sessions
from robsim.trace import Session
from sessions import AREA, Row, numbered, record

pytest.importorskip("cv2")
reader = pytest.importorskip("mcap.reader")
decoder = pytest.importorskip("mcap_ros2.decoder")


def messages_of(file):
    """Topic -> times of the log (s) and decoded messages."""
    found = {}
    with file.open("rb") as stream:
        opened = reader.make_reader(stream, decoder_factories=[decoder.DecoderFactory()])
        assert opened.get_header().profile == "ros2"
        for schema, channel, message, content in opened.iter_decoded_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            assert content.__class__.__name__ == schema.name.rsplit("/", 1)[1]
            found.setdefault(channel.topic, []).append((message.log_time * 1e-9, content))
    return found


@pytest.fixture(scope="module", params=[False, True], ids=["default", "lossless"])
def exported(request, tmp_path_factory):
    """A session, and its messages."""
    folder = tmp_path_factory.mktemp("exported") / "run"
    writer = record(folder, 6, lossless=request.param)
    frame, _ = numbered(6)
    writer.add(Row(k=6, t=101.2, t_sent=101.25, u=(2, 3), reason="no red blob"), frame)
    writer.close()
    session = Session(folder)
    session.export_mcap(folder / "run.mcap")
    return session, messages_of(folder / "run.mcap")


@pytest.mark.long
def test_the_images_are_those_of_the_session(exported):
    session, messages = exported
    frames = []
    for (t, message), observation in zip(
        messages["/camera/image/compressed"], session, strict=True
    ):
        pixels = np.asarray(Image.open(io.BytesIO(message.data)))
        np.testing.assert_array_equal(pixels, observation.frame.image)
        assert message.format in ("jpeg", "png")
        assert message.header.stamp.sec + message.header.stamp.nanosec * 1e-9 == pytest.approx(t)
        frames.append(robsim.Frame(pixels))
    poses = robsim.Experiment(frames, area=AREA).run().pose_measured
    assert [sessions.number_of(frame) for frame in frames] == list(range(7))
    np.testing.assert_allclose(poses[:6], session.trace.pose_measured[:6], atol=0.3)


def test_the_poses_and_inputs_are_those_of_the_session(exported):
    session, messages = exported
    poses = [
        (p.position.x, p.position.y, 2 * math.atan2(p.orientation.z, p.orientation.w))
        for p in (message.pose for _, message in messages["/pose_measured"])
    ]
    expected = session.trace.pose_measured[:6]
    np.testing.assert_allclose(np.subtract(poses, expected)[:, :2], 0, atol=1e-12)
    np.testing.assert_allclose(robsim.wrap_angle(np.subtract(poses, expected)[:, 2]), 0, atol=1e-9)
    assert [list(message.data) for _, message in messages["/u"]] == session.trace.u.tolist()
    assert [message.data for _, message in messages["/missed"]] == ["no red blob"]


def test_the_times_are_those_of_the_frames_from_the_date_on(exported):
    session, messages = exported
    start = session.setup["started"].timestamp()
    times = [t for t, _ in messages["/camera/image/compressed"]]
    np.testing.assert_allclose(np.subtract(times, start), 0.2 * np.arange(7), atol=1e-5)
    assert messages["/u"][-1][0] - start == pytest.approx(1.25, abs=1e-5)


def test_a_session_without_frames_or_steps_is_exported(tmp_path):
    record(tmp_path, 0).close()
    Session(tmp_path).export_mcap(tmp_path / "a.mcap")
    assert messages_of(tmp_path / "a.mcap") == {}


def test_without_the_packages_it_says_what_to_install(tmp_path, monkeypatch):
    record(tmp_path, 1).close()
    monkeypatch.setitem(sys.modules, "mcap_ros2.writer", None)
    with pytest.raises(ImportError, match=r'pip install "robsim\[mcap\]"'):
        Session(tmp_path).export_mcap(tmp_path / "a.mcap")
    assert not (tmp_path / "a.mcap").exists()
