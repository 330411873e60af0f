"""Damaged files into every reader: what is in them, or a refusal in words; never a crash.

Each kind starts from whole files, written here, and from those in `corpus`, which once broke
something or are made to.
"""

import io
import json
import shutil
import sqlite3
import struct
import warnings
import zipfile
from contextlib import closing, suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import robsim
import worker_answers
from fuzzing import SEEDS, attempt, fuzzed, mutations, refused
from robsim.campaigns import campaign
from robsim.trace import Session
from robsim.trace.sessions._setup import setup_text
from robsim.trace.sessions.rows import KEYS
from robsim.vision import load_image, save_colors, save_video
from scenarios import FULL
from sessions import SETUP, record, write_file

pytestmark = pytest.mark.fuzz

CORPUS = Path(__file__).parent / "corpus"


def small_run():
    sim = robsim.Simulation(
        area=(120, 120),
        measure=True,
        estimate_parameters=True,
        control=robsim.DriveAround(),
        seed=1,
    )
    sim.run(12)
    return sim


def encoded(form, pixels, **options):
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, form, **options)
    return buffer.getvalue()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The contents of whole files, by kind."""
    folder = tmp_path_factory.mktemp("whole")
    sim = small_run()
    sim.trace.save(folder / "run.npz")
    FULL.save(folder / "full.toml")
    robsim.Scenario(seed=3, noise=robsim.GaussianNoise(5)).save(folder / "small.toml")
    save_colors(folder / "colors.toml", robsim.load_colors())
    pixels = np.random.default_rng(1).integers(0, 256, (24, 32, 3)).astype(np.uint8)
    forms = [("PNG", {}), ("JPEG", {}), ("BMP", {}), ("GIF", {}), ("TIFF", {}), ("WEBP", {})]
    alpha = np.dstack((pixels, pixels[..., :1]))
    robot = Path(robsim.__file__).parent / "assets/robots/lab/robot.toml"
    kinds = {
        "traces": [(folder / "run.npz").read_bytes()],
        "scenarios": [(folder / name).read_bytes() for name in ("full.toml", "small.toml")],
        "colors": [(folder / "colors.toml").read_bytes()],
        "robots": [robot.read_bytes()],
        "pictures": [encoded(*form[:1], pixels, **form[1]) for form in forms]
        + [encoded("PNG", alpha), encoded("PNG", pixels[..., 0])],
    }
    return {kind: whole + corpus(kind) for kind, whole in kinds.items()}


def corpus(kind):
    return [file.read_bytes() for file in sorted((CORPUS / kind).glob("*"))]


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("scratch")


@st.composite
def one_bit_changed(draw, content):
    """A file's content with one bit changed, which many readers take."""
    if not content:
        return content
    at = draw(st.integers(0, len(content) - 1))
    return content[:at] + bytes((content[at] ^ 1 << draw(st.integers(0, 7)),)) + content[at + 1 :]


def some(data, contents):
    """One of the whole files, or one that is damaged."""
    content = data.draw(st.sampled_from(contents))
    return data.draw(st.one_of(st.just(content), one_bit_changed(content), mutations(content)))


def check_trace(path):
    trace = attempt(robsim.Trace.load, path)
    if trace is not None:
        assert len(repr(trace)) < 10_000
        assert "<script" not in trace._repr_html_()
        attempt(trace.tracking)
        trace.save(path)
        assert robsim.Trace.load(path) == trace


@pytest.mark.long
@fuzzed
@given(st.data())
def test_traces(whole, scratch, data):
    path = scratch / "run.npz"
    path.write_bytes(some(data, whole["traces"]))
    check_trace(path)
    refused.clear()  # by their checksums nearly all; test_members_of_traces gets past these


ODD = st.sampled_from(
    [None, -1, 0, 1e300, "", "<script>alert(1)</script>", "\x1b]0;a\x07", [], {}, [[]], 2**70]
)


@fuzzed
@given(st.data())
def test_members_of_traces(whole, scratch, data):
    """The parts of an archive changed one by one, with checksums that are right again."""
    with zipfile.ZipFile(io.BytesIO(whole["traces"][0])) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    name = data.draw(st.sampled_from(sorted(members)))
    what = data.draw(st.sampled_from(("bytes", "shape", "info", "drop", "add", "nothing")))
    if what == "bytes":
        members[name] = data.draw(mutations(members[name]))
    elif what == "drop":
        del members[name]
    elif what == "add":
        members[data.draw(st.sampled_from(("x.npy", "../x.npy", "u.npy ", "blobs_<b>.npy")))] = b"0"
    elif what == "info":
        info = json.loads(str(np.load(io.BytesIO(members["info.npy"]))))
        info[data.draw(st.sampled_from((*sorted(info), "more")))] = data.draw(ODD)
        members["info.npy"] = npy(np.array(json.dumps(info)))
    elif what == "shape":
        rng = np.random.default_rng(data.draw(SEEDS))
        shape = rng.integers(0, 14, rng.integers(0, 4))
        kind = data.draw(st.sampled_from(("f8", "f4", "i8", "?", "c16", "U3")))
        members[name] = npy(rng.integers(0, 9, shape).astype(kind))
    path = scratch / "members.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    check_trace(path)


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def check_scenario(path):
    scenario = attempt(robsim.Scenario.load, path)
    if scenario is not None:
        scenario.save(path)
        assert robsim.Scenario.load(path) == scenario


def check_colors(path):
    colors = attempt(robsim.load_colors, path)
    if colors is not None:
        save_colors(path, colors)
        assert robsim.load_colors(path) == colors


def check_robot(path):
    """A robot whose file this is, with the picture of one that ships."""
    folder = path.parent / "robot"
    if not folder.exists():
        shutil.copytree(Path(robsim.__file__).parent / "assets/robots/lab", folder)
    (folder / "robot.toml").write_bytes(path.read_bytes())
    robot = attempt(robsim.load_robot, folder)
    if robot is not None:
        assert len(repr(robot)) < 1000


@pytest.mark.parametrize(
    ("kind", "check"),
    [
        pytest.param("scenarios", check_scenario, marks=pytest.mark.long),
        ("colors", check_colors),
        ("robots", check_robot),
    ],
)
@fuzzed
@given(data=st.data())
def test_files_of_text(kind, check, whole, scratch, data):
    path = scratch / "file.toml"
    # Hypothesis tries no input twice: with a comment each, whole files stay a third of all.
    comment = data.draw(st.text(st.characters(codec="ascii", exclude_categories=["Cc"])))
    path.write_bytes(some(data, whole[kind]) + f"\n# {comment}\n".encode())
    check(path)


def check_picture(path, mode="RGB"):
    pixels = attempt(load_image, path, mode=mode)
    if pixels is not None:
        assert pixels.dtype == np.uint8


@fuzzed
@given(st.data(), st.sampled_from(("RGB", "RGBA", "L")))
def test_pictures(whole, scratch, data, mode):
    path = scratch / "picture.png"
    path.write_bytes(some(data, whole["pictures"]))
    check_picture(path, mode)


def check_video(path):
    attempt(frames_of, path)


def frames_of(path):
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*(truncated or damaged|are left out)")
        for k, frame in enumerate(robsim.Recording(path, dt=0.1)):
            assert frame.image.dtype == np.uint8
            assert k < 1000


@pytest.fixture(scope="module", params=(".avi", ".mp4", ".mkv"))
def video(request, tmp_path_factory):
    pytest.importorskip("av")
    path = tmp_path_factory.mktemp("video") / f"whole{request.param}"
    save_video(path, small_run_frames(), fps=10)
    return path


def small_run_frames():
    sim = small_run()
    return [sim.render_step(k) for k in range(6)]


@pytest.mark.long
@fuzzed
@given(st.data())
def test_videos(video, data):
    path = video.with_stem("damaged")
    path.write_bytes(some(data, [video.read_bytes(), *corpus("videos")]))
    check_video(path)


def check_session(path):
    session = attempt(Session, path)
    if session is not None:
        assert len(repr(session)) < 10_000
        attempt(list, session)
        attempt(session.full_trace)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    pytest.importorskip("cv2")
    file = tmp_path_factory.mktemp("recorded") / "run.mcap"
    record(file, 5).close(small_run().trace)
    return [file.read_bytes(), *corpus("sessions")]


@pytest.mark.long
@fuzzed
@given(st.data())
def test_sessions(recorded, scratch, data):
    path = scratch / "damaged.mcap"
    path.write_bytes(some(data, recorded))
    check_session(path)


@pytest.mark.long
@fuzzed
@given(st.data())
def test_steps_of_sessions(scratch, data):
    odd = st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), st.text(max_size=9))
    odd |= st.lists(odd, max_size=18)
    steps = [{"k": k, "t": float(k), "u": [1.0, 2.0], "reason": ""} for k in range(3)]
    names = st.sampled_from(KEYS)
    steps[1] |= data.draw(st.dictionaries(names, odd, max_size=3))
    lines = [(json.dumps(step).encode(), None) for step in steps]
    path = scratch / "odd.mcap"
    write_file(path, setup_text(SETUP, kind="PNG"), lines)
    check_session(path)


@pytest.mark.long
@fuzzed
@given(st.data())
def test_folders_of_sessions(scratch, data):
    """A folder of an earlier robsim with damage in a file, or with one of another kind for it."""
    folder = scratch / "session"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(CORPUS.parents[1] / "data/0.1.0/session", folder)
    files = sorted(folder.iterdir())
    file = data.draw(st.sampled_from(files))
    file.write_bytes(
        some(data, [file.read_bytes(), data.draw(st.sampled_from(files)).read_bytes()])
    )
    check_session(folder)


def check_store(path):
    """Go on with a campaign, and read it."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".* was created with ")  # other versions
        attempt(campaign_in, path, also=(OSError,))


def campaign_in(path):
    return campaign(
        robsim.Scenario(area=(120, 120)), metrics="pose_errors", runs=2, steps=3, store=path, seed=1
    )


SQL = st.sampled_from(
    (
        "UPDATE campaign SET value = {odd}",
        "UPDATE cases SET case_id = case_id + 1",
        "UPDATE runs SET run = {odd}, error = {odd}",
        "INSERT INTO runs (case_id, run) VALUES ({odd}, {odd})",
        "UPDATE columns SET sql_name = {odd}",
        "INSERT INTO columns VALUES (99, {odd}, {odd})",
        "DELETE FROM campaign",
        "DROP VIEW results",
        "CREATE VIEW more AS SELECT {odd} FROM runs",
        "CREATE TRIGGER more AFTER INSERT ON runs BEGIN DELETE FROM runs; END",
        "PRAGMA user_version = 9",
    )
)
SQL_VALUES = st.sampled_from(("NULL", "-1", "1e400", "9223372036854775807", "'x'", "'[]'", "'{}'"))


@pytest.mark.long
@fuzzed
@given(st.data())
def test_stores(scratch, data):
    path = scratch / "store.sqlite"
    whole = scratch / "whole.sqlite"
    if not whole.exists():
        campaign_in(whole)
    shutil.copy(whole, path)
    if data.draw(st.booleans()):
        path.write_bytes(some(data, [whole.read_bytes()]))
    else:
        with closing(sqlite3.connect(path)) as database, suppress(sqlite3.Error):
            database.execute(data.draw(SQL).format(odd=data.draw(SQL_VALUES)))
            database.commit()
    check_store(path)


def check_messages(path):
    """Run with a worker that gives the answers in the file."""
    hear(path.read_bytes())


def hear(content, steps=6):
    refusal = (worker_answers.Refused,)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an answer may be implausible
        trace = attempt(worker_answers.run, worker_answers.replies(content), steps, also=refusal)
    if trace is not None:
        assert np.abs(trace.u).max() <= 12
        assert np.isfinite(trace.pose_estimated).all()


WILD = st.sampled_from((0.0, 1.0, -1.0, 1e-300, 1e9, -1e9, 1e12))
PARTS = sorted(worker_answers.HAS.keys() - {"frame"})


@st.composite
def answers(draw):
    """An answer that may be right alone, or nearly: its parts, counts and numbers change."""
    states, blobs = draw(st.sampled_from([0, 0, 1, 2, 1024])), draw(st.sampled_from([0, 0, 1, 4]))
    first = worker_answers.PARAMETERS
    places = st.integers(0, 57).map(lambda i: first + 8 * i)
    numbers = draw(st.lists(st.tuples(places, WILD), max_size=3))
    words = [(worker_answers.N_STATES, states), (worker_answers.N_BLOBS, blobs)]
    if draw(st.integers(0, 9)) == 0:
        words.append((worker_answers.DONE, draw(st.integers(0, 15))))
    end = struct.pack(f"<{2 * blobs + states}d", *[draw(WILD)] * (2 * blobs + states))
    parts = draw(st.sets(st.sampled_from(PARTS)))
    nothing = bytes(worker_answers.SIZE)
    return worker_answers.answer(
        nothing, "u", "estimate", *parts, numbers=numbers, words=words, end=end
    )


@pytest.mark.long
@fuzzed
@given(st.data())
def test_messages(data):
    """Sequences of answers of a worker, damaged or not: the robot half of a graded run."""
    good = worker_answers.good(bytes(worker_answers.SIZE))
    said = st.lists(st.one_of(st.just(good), answers()), min_size=1, max_size=6)
    hear(some(data, [worker_answers.stored(data.draw(said)), *corpus("messages")]))


READERS = {
    "messages": check_messages,
    "traces": check_trace,
    "scenarios": check_scenario,
    "colors": check_colors,
    "robots": check_robot,
    "pictures": check_picture,
    "videos": check_video,
    "sessions": check_session,
}


def test_the_corpus_is_there():
    assert {file.parent.name for file in CORPUS.glob("*/*")} == set(READERS)


@pytest.mark.parametrize("kind", READERS)
def test_corpus(kind, tmp_path):
    for file in (CORPUS / kind).glob("*"):
        try:
            READERS[kind](Path(shutil.copy(file, tmp_path)))
        except BaseException as error:
            error.add_note(f"with {file.name}")
            raise
