import itertools
import math
import os
import subprocess
import sys
import threading
import weakref

import numpy as np
import pytest

import robsim
import sessions
from commands import command
from robsim.trace import Session
from sessions import AREA, SETUP, Row, SessionWriter, check_agreement, numbered, record, row_time
from threads import in_fork

pytest.importorskip("cv2")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A complete session of 25 steps."""
    file = tmp_path_factory.mktemp("recorded") / "Fahrt über den Hof.mcap"
    record(file, 25).close()
    return file


def rows_of(trace):
    """The steps of a run, as it would record them."""
    for k in range(len(trace)):
        yield Row(
            k=k,
            t=trace.t[k].item(),
            u=tuple(trace.u[k].tolist()),
            pose_measured=tuple(trace.pose_measured[k].tolist()),
        )


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A simulated run, its trace, and the lossless session of its frames."""
    model = robsim.RobotModel(robsim.RobotParameters(dt=0.1))
    simulation = robsim.Simulation(
        seed=3,
        area=AREA,
        control=robsim.FollowPath([(100, 100), (200, 120), (180, 200)]),
        measure=True,
        dropout=robsim.Dropout(0.2, 3),
        estimate_parameters=True,
        identify_from="measurement",
        define_model=lambda: model,
    )
    frames = [simulation.step().frame for _ in range(30)]
    path = tmp_path_factory.mktemp("replay") / "run"
    setup = SETUP | {"dt": 0.1}
    writer = SessionWriter(path, setup=setup, lossless=True, waits=True)
    for row, frame in zip(rows_of(simulation.trace), frames, strict=True):
        writer.add(row, frame)
    writer.close(simulation.trace)
    return simulation.trace, frames, Session(path)


class TestReplay:
    def test_gives_the_bytes_of_the_run(self, run):
        trace, _, session = run
        again = robsim.Experiment(
            session,
            control=robsim.FollowPath([(100, 100), (200, 120), (180, 200)]),
            estimate_parameters=True,
        ).run()
        assert np.isnan(trace.pose_measured).any()
        for name in ("t", "pose_measured", "pose_held", "u", "parameters"):
            np.testing.assert_array_equal(getattr(again, name), getattr(trace, name), name)

    def test_another_controller_does_not_change_what_the_robot_got(self, run):
        trace, _, session = run
        seen = []
        again = robsim.Experiment(
            session,
            control=lambda step: (seen.append(step.last_u), (9.0, 9.0))[1],
            estimate_parameters=True,
        ).run()
        np.testing.assert_array_equal(seen[1:], trace.u[:-1])
        np.testing.assert_array_equal(again.parameters, trace.parameters)

    def test_keeps_the_trace_of_the_run(self, run):
        trace, _, session = run
        np.testing.assert_array_equal(session.trace.u, trace.u)
        np.testing.assert_array_equal(session.trace.pose_measured, trace.pose_measured)
        assert session.full_trace() == trace


def test_a_session_agrees_with_itself(recorded):
    session = Session(recorded)
    assert session.is_complete
    assert session.problems == ()
    assert check_agreement(session) == session.count == len(session) == 25
    assert (session.area, session.dt, session.size) == (AREA, 0.2, AREA)
    assert check_agreement(session) == 25  # again


def test_players_show_a_video_of_it(recorded, tmp_path):
    command("sessions", "video", str(recorded), "--to", "run.mkv", cwd=tmp_path)
    with pytest.raises(ValueError, match="Session"):
        robsim.Recording(recorded)
    recording = robsim.Recording(tmp_path / "run.mkv")
    assert recording.dt == pytest.approx(0.2)
    assert [sessions.number_of(frame) for frame in recording] == list(range(25))


def test_the_default_video_shifts_poses_by_less_than_a_tenth_of_a_pixel(recorded):
    session = Session(recorded)
    error = robsim.Experiment(session).run().pose_measured - session.trace.pose_measured
    # The drawn number is not near the robot; the markers have 21 px.
    assert np.sqrt(np.mean(error[:, :2] ** 2)) < 0.05
    assert np.abs(error[:, :2]).max() < 0.25
    assert np.abs(error).max() > 0  # it is not lossless


LENS = robsim.vision.Intrinsics(
    [[1 / 3e-3, 0, 159.5], [0, 333.3, 119.5], [0, 0, 1]], (-0.1, 0.01, 1e-3, -2 / 3e3, 0.1 + 0.2)
)
THROUGH_LENS = robsim.vision.PlaneMap([[2, 0.1, 1 / 3], [0, 2.2, 7], [1e-4, 2e-5, 1]], LENS)


def test_the_setup_comes_back(tmp_path):
    robot = robsim.vision.load_robot("lab")
    setup = {
        "area": (640, 480),
        "dt": 1 / 30,
        "plane_map": THROUGH_LENS,
        "colors": list(robsim.load_colors()),
        "markers": robot.marker_layout(),
        "model": robsim.RobotModel(),
        "robot": "lab",
        "seed": 2**100,
        "sources": {
            "control.py": "def control(step):\n    return '''\\n''', 'ä'\n",
            "b.py": "\n\nx",
        },
        "nothing": None,
    }
    SessionWriter(tmp_path / "s", setup=setup).close()
    session = Session(tmp_path / "s")
    for name in ("area", "dt", "plane_map", "colors", "markers", "model"):
        assert getattr(session, name) == setup[name], name
    assert session.setup["sources"] == setup["sources"]
    assert session.setup["seed"] == str(2**100)
    assert session.setup["started"].utcoffset().total_seconds() == 0
    assert list(session) == []
    assert session.size is None


def test_a_frame_keeps_its_own_numbers(tmp_path):
    scaled = robsim.vision.PlaneMap.scaled((300, 300), (600, 600))
    writer = SessionWriter(tmp_path / "s", setup={"plane_map": scaled}, lossless=True, waits=True)
    image = numbered(3)[0].image
    maps = [scaled, robsim.vision.PlaneMap(), THROUGH_LENS]
    for k, plane_map in enumerate(maps):
        frame = robsim.Frame(image, t=k, t_arrival=k + 0.04, index=7 * k, plane_map=plane_map)
        writer.add(Row(k=5 + k, t=k, t_arrival=k + 0.04, t_sent=k + 0.06), frame)
    writer.add(Row(k=8, t=3.0, reason='=no "blue", no red'), None)
    writer.close()
    session = Session(tmp_path / "s")
    *seen, last = [observation.frame for observation in session]
    assert last is None
    assert [frame.plane_map for frame in seen] == maps
    assert [frame.index for frame in seen] == [0, 7, 14]
    assert [frame.t_arrival for frame in seen] == [0.04, 1.04, 2.04]
    assert session.trace.k.tolist() == [5, 6, 7, 8]
    np.testing.assert_array_equal(session.trace.t_sent, [0.06, 1.06, 2.06, math.nan])
    assert session._rows[-1].reason == '=no "blue", no red'


EXTREMES = [0.0, -0.0, 1e-320, -1e308, math.inf, -math.inf, math.nan, 1 / 3, np.float64(0.1)]


def test_whatever_a_step_has_can_be_read_again(tmp_path, rng):
    writer = SessionWriter(tmp_path / "s", setup={}, waits=True)
    rows = []
    for k in range(200):
        pick = [EXTREMES[i] for i in rng.choice(len(EXTREMES), 7)]
        odd = str(rng.choice(["\n", '"', ",", "\ud800"]))
        text = "".join(map(chr, rng.integers(1, 0x2FFF, 5))) + odd
        row = Row(
            k=np.int64(k),
            t=[1e15, -1e15, np.float64(k)][k % 3],
            t_arrival=EXTREMES[k % 3],
            u=np.array(pick[:2]),
            last_u=pick[2:4],
            pose_measured=pick[4:7],
            interrupted=np.bool_(k % 2),
            reason=text,
        )
        rows.append(row)
        index = int(rng.choice([0, 2**32, 2**63 - 1]))
        frame = robsim.Frame(np.zeros((16, 16, 3), np.uint8), index=index)
        writer.add(row, frame)
    writer.close()
    session = Session(tmp_path / "s")
    list(session)
    for row, read in zip(rows, session._rows, strict=True):
        for name in ("t", "u", "last_u", "pose_measured", "interrupted"):
            value = np.asarray(getattr(row, name), dtype=float)
            value = np.where(np.isfinite(value), value, np.nan)
            np.testing.assert_array_equal(np.asarray(getattr(read, name), dtype=float), value)


def test_after_a_stop_the_robot_got_the_stop_input(tmp_path):
    writer = SessionWriter(tmp_path / "s", setup={"stop_input": (0.5, 0.25)})
    for k in range(3):
        writer.add(Row(k=k, t=k, u=(1, 2), interrupted=k == 1), None)
    writer.add(Row(k=3, t=3, last_u=(8, 9)), None)
    writer.close()
    session = Session(tmp_path / "s")
    assert session.trace.interrupted.tolist() == [False, True, False, False]
    got = [o.last_u if o.last_u is None else o.last_u.tolist() for o in session]
    assert got == [None, [0.5, 0.25], [1, 2], [8, 9]]


def test_a_session_is_not_overwritten(recorded):
    before = recorded.read_bytes()
    for name in (recorded, recorded.with_suffix("")):
        with pytest.raises(FileExistsError):
            record(name, 2)
    assert recorded.read_bytes() == before
    assert [*recorded.parent.iterdir()] == [recorded]


def test_what_cannot_be_recorded_is_told_at_once(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    with pytest.raises(NotADirectoryError):
        record(tmp_path / "file" / "s", 0)
    if os.name == "posix" and os.getuid():
        tmp_path.chmod(0o500)
        for name in ("session", "folder/session"):
            with pytest.raises(PermissionError):
                record(tmp_path / name, 0)
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(ImportError, match="pip install"):
        record(tmp_path / "session", 0)
    assert not (tmp_path / "session.mcap").exists()


def test_a_video_of_a_session_with_and_without_frames(tmp_path):
    writer = record(tmp_path / "s", 2)
    writer.add(Row(k=2, t=row_time(2)), None)
    writer.close()
    assert command("sessions", "video", "s", cwd=tmp_path).exit_code == 0
    assert len(list(robsim.Recording(tmp_path / "s.mp4"))) == 3  # the last one again
    SessionWriter(tmp_path / "none", setup=SETUP).close()
    assert command("sessions", "video", "none", cwd=tmp_path).exit_code != 0


class TestSlowWriter:
    def test_leaves_out_frames_and_no_rows(self, tmp_path, monkeypatch):
        writer = record(tmp_path / "s", 1)
        writer.flush()
        writer._waits = False
        encode, may_go_on = writer._file.encode, threading.Event()

        def slow(frame):
            may_go_on.wait()
            return encode(frame)

        monkeypatch.setattr(writer._file, "encode", slow)
        for k in range(1, 60):
            sessions.add(writer, k)  # it does not wait
        may_go_on.set()
        with pytest.warns(UserWarning, match="of 60 frames"):
            writer.close()
        session = Session(tmp_path / "s")
        assert session.count == writer.counts.steps == 60
        pictures = check_agreement(session)
        assert 1 < pictures <= 20
        assert (writer.counts.frames, writer.counts.frames_left_out) == (pictures, 60 - pictures)
        assert session.problems[0].startswith(f"{60 - pictures} frames")
        assert len(session.problems) == 1

    def test_leaves_out_a_frame_of_another_size(self, tmp_path):
        writer = record(tmp_path / "s", 1)
        writer.add(Row(k=1, t=101.0), robsim.Frame(np.zeros((20, 30, 3), np.uint8)))
        with pytest.warns(UserWarning, match="1 of 2 frames"):
            writer.close()
        assert [o.frame is None for o in Session(tmp_path / "s")] == [False, True]


def test_a_session_can_be_read_while_it_is_written(tmp_path):
    writer = record(tmp_path / "s", 0)
    for k in itertools.count():
        sessions.add(writer, k)
        session = Session(tmp_path / "s")
        assert check_agreement(session) == session.count <= k + 1
        assert "still continues" in session.problems[0]
        if k == 8:
            break
    writer.flush()
    assert Session(tmp_path / "s").count == 9
    writer.close()
    assert Session(tmp_path / "s").is_complete


def test_a_writer_that_is_forgotten_finishes_its_session(tmp_path):
    threads = threading.active_count()
    writer = record(tmp_path / "s", 3)
    gone = weakref.ref(writer)
    del writer
    assert gone() is None
    assert Session(tmp_path / "s").is_complete
    assert threading.active_count() == threads


@pytest.mark.long
def test_the_end_of_the_program_finishes_a_session(tmp_path):
    program = f"import sessions; kept = sessions.record({str(tmp_path / 's')!r}, 4)"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-W", "error", "-c", program], env=environment, check=True)
    assert Session(tmp_path / "s").is_complete
    assert check_agreement(Session(tmp_path / "s")) == 4


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_process_writes_nothing(tmp_path):
    writer = record(tmp_path / "s", 2)

    def write():
        sessions.add(writer, 2)
        writer.flush()
        writer.close()

    in_fork(write)
    sessions.add(writer, 2)
    writer.close()
    assert check_agreement(Session(tmp_path / "s")) == 3


def test_a_full_disk_is_told_at_once_and_loses_no_row(tmp_path, monkeypatch):
    resource = pytest.importorskip("resource")
    monkeypatch.setattr("robsim.trace.sessions.writer._AFTER_ERROR", 0.0)
    writer = record(tmp_path / "s", 10)
    writer.flush()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    full = (tmp_path / "s.mcap").stat().st_size + 2000
    resource.setrlimit(resource.RLIMIT_FSIZE, (full, limits[1]))
    try:
        sessions.add(writer, 10)
        writer.flush()
        with pytest.warns(UserWarning, match=r"s\.mcap cannot be written"):
            sessions.add(writer, 11)
        for k in range(12, 20):
            sessions.add(writer, k)  # told once
        writer.flush()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert isinstance(writer.error, OSError)
    for k in range(20, 30):
        sessions.add(writer, k)
    with pytest.warns(UserWarning, match="10 of 30 frames"):
        writer.close()
    session = Session(tmp_path / "s")
    assert session.count == 30
    assert check_agreement(session) == 20
    assert not session.is_complete
    assert row_time(29) == session.trace.t[-1]


def test_a_disk_that_takes_its_time_to_sync_does_not_hold_up_the_rows(tmp_path, monkeypatch):
    monkeypatch.setattr("robsim.trace.sessions.writer._BETWEEN_SYNCS", 0.01)
    syncing, may_go_on = threading.Event(), threading.Event()

    def slow(file):
        syncing.set()
        may_go_on.wait()

    monkeypatch.setattr("robsim.trace.sessions.writer._AppendedFile.sync", slow)
    writer = record(tmp_path / "s", 2)
    assert syncing.wait(300)
    for k in range(2, 9):
        sessions.add(writer, k)
    writer.flush()
    assert check_agreement(Session(tmp_path / "s")) == 9
    may_go_on.set()
    writer.close()
    assert Session(tmp_path / "s").is_complete
