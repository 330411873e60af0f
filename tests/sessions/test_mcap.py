"""Sessions for other programs, read by the libraries of MCAP and of ROS 2 messages."""

import io
import math
import time

import numpy as np
import pytest
from mcap import reader
from PIL import Image
from scipy.spatial.transform import Rotation

import robsim
import sessions
from robsim.trace import Session
from robsim.trace.sessions.writer import SessionWriter
from robsim.vision import Intrinsics, PlaneMap
from sessions import AREA, Row, numbered, record

cv2 = pytest.importorskip("cv2")
decoder = pytest.importorskip("mcap_ros2.decoder")

MM_PER_PX = 2.5
IMAGE, INFO = "/camera/image/compressed", "/camera/camera_info"


def messages_of(file):
    """Topic -> times of the log (ns) and decoded messages."""
    found = {}
    with file.open("rb") as stream:
        opened = reader.make_reader(
            stream, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()]
        )
        assert opened.get_header().profile == "ros2"
        for schema, channel, message, content in opened.iter_decoded_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            assert content.__class__.__name__ == schema.name.rsplit("/", 1)[1]
            found.setdefault(channel.topic, []).append((message.log_time, content))
        total = opened.get_summary().statistics.message_count
        assert total == sum(map(len, found.values()))
    return found


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def xyz(vector):
    return np.array([vector.x, vector.y, vector.z])


def turn_of(quaternion):
    return Rotation.from_quat([quaternion.x, quaternion.y, quaternion.z, quaternion.w])


class Filmed(list):
    """Frames of a camera whose px have a length."""

    mm_per_px = MM_PER_PX
    dt = 0.2


@pytest.fixture(scope="module")
def filmed(tmp_path_factory):
    """The true poses of a run, its trace, its messages."""
    simulation = robsim.Simulation(seed=5, area=AREA, control=robsim.DriveAround(), headings=None)
    frames = Filmed()
    for k in range(8):
        image = simulation.step().frame.image.copy()
        frames.append(robsim.Frame(image, t=7 + 0.2 * k, t_arrival=7.01 + 0.2 * k))
    file = tmp_path_factory.mktemp("filmed") / "run.mcap"
    filters = robsim.estimation.reference.ExtendedKalmanFilter()
    with robsim.Experiment(
        frames, area=AREA, record=file, control=robsim.Spin(), estimate_state=filters
    ) as experiment:
        trace = experiment.run()
    return simulation.trace.pose_true, trace, messages_of(file)


def test_poses_are_in_metres_where_the_robot_stands(filmed):
    truth, trace, messages = filmed
    poses = [message for _, message in messages["/pose_measured"]]
    assert {message.header.frame_id for message in poses} == {"area"}
    places = np.array([xyz(message.pose.pose.position) for message in poses])
    np.testing.assert_allclose(places[:, :2], truth[:, :2] * MM_PER_PX / 1000, atol=0.002)
    np.testing.assert_array_equal(places[:, :2], trace.pose_measured[:, :2] * (MM_PER_PX / 1000))
    assert (places[:, 2] == 0).all()
    turns = [turn_of(message.pose.pose.orientation).as_rotvec()[2] for message in poses]
    assert np.abs(robsim.wrap_angle(np.array(turns) - truth[:, 2])).max() < 0.03


def test_poses_have_their_covariance(filmed):
    _, trace, messages = filmed
    planar = np.ix_([0, 1, 5], [0, 1, 5])
    for topic in ("/pose_measured", "/pose_estimated"):
        for _, message in messages[topic]:
            spread = np.reshape(message.pose.covariance, (6, 6))
            assert 0 < math.sqrt(spread[0, 0]) < 1  # m
            assert np.count_nonzero(spread) == np.count_nonzero(spread[planar])
    scale = np.array([MM_PER_PX / 1000, MM_PER_PX / 1000, 1])
    got = [np.reshape(m.pose.covariance, (6, 6))[planar] for _, m in messages["/pose_estimated"]]
    expected = trace.covariance.reshape(-1, 3, 3) * np.outer(scale, scale)
    np.testing.assert_allclose(got, expected, rtol=1e-12)


def test_stamps_are_those_of_exposure_by_the_clock(filmed):
    _, _, messages = filmed
    stamps = [stamp_of(message) for _, message in messages[IMAGE]]
    assert stamps == [t for t, _ in messages[IMAGE]]
    np.testing.assert_allclose(np.diff(stamps), 0.2e9, atol=1000)
    assert stamps == [stamp_of(message) for _, message in messages["/pose_measured"]]
    sent = [t for t, _ in messages["/u"]]
    assert sent == stamps  # without motors


def test_the_clock_is_that_of_the_day(tmp_path):
    before = time.time_ns()
    writer = record(tmp_path / "s", 0)
    writer.add(Row(k=0, t=5.0, t_sent=5.25, u=(1, 2)), None)
    writer.close()
    ((sent, _),) = messages_of(tmp_path / "s.mcap")["/u"]
    assert before <= sent <= time.time_ns()


def test_inputs_are_those_of_the_run(filmed):
    _, trace, messages = filmed
    assert [list(message.data) for _, message in messages["/u"]] == trace.u.tolist()
    (dimension,) = messages["/u"][0][1].layout.dim
    assert "V" in dimension.label


@pytest.mark.long
@pytest.mark.parametrize("lossless", [False, True])
def test_the_pictures_are_those_of_the_session(tmp_path, lossless):
    record(tmp_path / "s", 7, lossless=lossless).close()
    messages = messages_of(tmp_path / "s.mcap")
    frames = []
    for (_, message), seen in zip(messages[IMAGE], Session(tmp_path / "s"), strict=True):
        pixels = np.asarray(Image.open(io.BytesIO(message.data)))
        np.testing.assert_array_equal(pixels, seen.frame.image)
        assert message.format == ("png" if lossless else "jpeg")
        frames.append(robsim.Frame(pixels))
    assert [sessions.number_of(frame) for frame in frames] == list(range(7))


def test_without_a_known_length_the_names_say_px(tmp_path):
    record(tmp_path / "s", 2).close()
    messages = messages_of(tmp_path / "s.mcap")
    trace = Session(tmp_path / "s").trace
    for k, (_, message) in enumerate(messages["/pose_measured"]):
        assert message.header.frame_id == "area_px"
        np.testing.assert_array_equal(
            xyz(message.pose.pose.position)[:2], trace.pose_measured[k, :2]
        )
        assert not any(message.pose.covariance)  # not known
    for topic in ("/tf", "/tf_static"):
        for _, message in messages[topic]:
            for one in message.transforms:
                assert one.header.frame_id.endswith("_px")
                assert one.child_frame_id.endswith("_px")


LENS = Intrinsics([[820, 0, 330.5], [0, 815, 251], [0, 0, 1]], (-0.12, 0.02, 1e-3, -5e-4, 0.01))
TILT = Rotation.from_euler("xyz", (25, -14, 8), degrees=True)


def floor_of(unit):
    """The map of a tilted camera, 1.8 m from the area's middle, whose px have so many m."""
    middle = np.array([300, 240, 0]) * unit
    t = np.array([0, 0, 1.8]) - TILT.apply(middle)
    turned = TILT.as_matrix()
    columns = np.column_stack((turned[:, 0] * unit, turned[:, 1] * unit, t))
    return PlaneMap(np.linalg.inv(LENS.matrix @ columns), LENS)


@pytest.mark.parametrize("in_setup", [True, False])
@pytest.mark.parametrize("mm_per_px", [MM_PER_PX, None])
def test_the_camera_stands_where_its_pictures_say(tmp_path, mm_per_px, in_setup):
    unit = MM_PER_PX / 1000 if mm_per_px else 1
    floor = floor_of(MM_PER_PX / 1000)
    setup = {
        "plane_map": floor if in_setup else None,
        "mm_per_px": mm_per_px,
        "area": (600, 480),
        "dt": 0.2,
    }
    writer = SessionWriter(tmp_path / "s", setup=setup, waits=True)
    image = np.zeros((500, 660, 3), np.uint8)
    pose = (400.0, 130.0, 0.7)
    writer.add(Row(k=0, t=1.0, pose_measured=pose), robsim.Frame(image, t=1.0, plane_map=floor))
    writer.close()
    messages = messages_of(tmp_path / "s.mcap")
    end = "" if mm_per_px else "_px"
    tree = {
        one.child_frame_id.removesuffix("_px"): (one.header.frame_id, one.transform)
        for topic in ("/tf_static", "/tf")
        for _, message in messages[topic]
        for one in message.transforms
    }
    assert {child: parent for child, (parent, _) in tree.items()} == {
        **{"area": f"map{end}", "camera": f"area{end}", "robot": f"area{end}"},
        "base_link": f"robot{end}",
    }

    def to_parent(name, points):
        move = tree[name][1]
        return turn_of(move.rotation).apply(points) + xyz(move.translation)

    ((_, info),) = messages[INFO]
    assert (info.width, info.height, info.header.frame_id) == (660, 500, f"camera{end}")
    camera = tree["camera"][1]
    into = turn_of(camera.rotation).inv()
    on_floor = np.array([[100, 80], [500, 400], [300, 240], pose[:2]])
    points = np.column_stack((on_floor * unit, np.zeros(4)))
    # The robot's own origin, by the chain.
    points[3] = to_parent("robot", np.zeros(3))
    seen = into.apply(points - xyz(camera.translation))
    k, d = np.reshape(info.k, (3, 3)), np.array(info.d)
    pixels = cv2.projectPoints(seen, np.zeros(3), np.zeros(3), k, d)[0][:, 0]
    np.testing.assert_allclose(pixels, floor.to_pixel(on_floor), atol=1e-6)
    if mm_per_px:
        assert np.linalg.norm(xyz(camera.translation) - points[2]) == pytest.approx(1.8)
    # In the frame map, the camera is above the floor, and the robot's own z points up.
    above = to_parent("area", np.array([xyz(camera.translation)]))[0]
    assert above[2] > 0
    foot, head = (
        to_parent("area", to_parent("robot", p)) for p in np.array([[0, 0, 0], [0, 0, -1]])
    )
    np.testing.assert_allclose(to_parent("base_link", [0, 0, 1]), [0, 0, -1], atol=1e-15)
    assert head[2] > foot[2]


def test_the_camera_stands_on_the_floor_below_the_markers(tmp_path):
    calibration = robsim.vision.Calibration(
        size=(660, 500),
        intrinsics=LENS,
        floor=PlaneMap(floor_of(MM_PER_PX / 1000).matrix),
        area=(600, 480),
        mm_per_px=MM_PER_PX,
        marker_height=80,
    )
    above = calibration.plane_map
    image = np.zeros((500, 660, 3), np.uint8)
    frames = Filmed([robsim.Frame(image, t=0.2 * k, plane_map=above) for k in range(2)])
    frames.calibration = calibration
    with robsim.Experiment(frames, area=(600, 480), record=tmp_path / "s") as experiment:
        experiment.run()
    messages = messages_of(tmp_path / "s.mcap")
    ((_, static),) = messages["/tf_static"]
    (camera,) = (one for one in static.transforms if one.child_frame_id == "camera")
    middle = np.array([300, 240, 0]) * MM_PER_PX / 1000
    away = xyz(camera.transform.translation) - middle
    np.testing.assert_allclose(away, TILT.inv().apply([0, 0, -1.8]), atol=1e-9)
    assert len(messages[INFO]) == 2


def test_faults_are_told(tmp_path):
    writer = record(tmp_path / "s", 1)
    frame, _ = numbered(1)
    writer.add(Row(k=1, t=101.2, reason="no red blob", interrupted=True), frame)
    writer.add(Row(k=2, t=101.4), robsim.Frame(np.zeros((20, 30, 3), np.uint8)))
    with pytest.warns(UserWarning, match="1 of 3 frames"):
        writer.close()
    first, second = (m for _, m in messages_of(tmp_path / "s.mcap")["/diagnostics"])
    assert first.status[0].message == "no red blob"
    assert len(first.status) == 2
    assert "size" in second.status[0].message


def test_a_session_without_frames_or_steps_is_read(tmp_path):
    record(tmp_path / "a", 0).close()
    assert messages_of(tmp_path / "a.mcap") == {}
    assert Session(tmp_path / "a").is_complete
