import dataclasses
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings

import robsim
from refusals import IMAGE, IN_WORDS, NAN, options, refusals
from robsim import Replay, Scenario, Simulation, Spin
from scenarios import FULL, scenarios

COLORS = robsim.load_colors()


def child_seed():
    return np.random.SeedSequence(7).spawn(2)[1]


# --- a value


def check_equality(scenario):
    again = Scenario(**{f.name: getattr(scenario, f.name) for f in dataclasses.fields(scenario)})
    for other in (again, scenario.replace(), pickle.loads(pickle.dumps(scenario))):
        assert other == scenario
        assert hash(other) == hash(scenario)
        assert repr(other) == repr(scenario)


@pytest.mark.long
@settings(max_examples=25)
@given(scenarios())
def test_scenarios_of_the_same_content_are_equal(scenario):
    check_equality(scenario)


@pytest.mark.slow
@pytest.mark.sanitized
@given(scenarios())
def test_many_scenarios_of_the_same_content_are_equal(scenario):
    check_equality(scenario)


def test_every_option_counts():
    plain = Scenario()
    for name in (field.name for field in dataclasses.fields(FULL)):
        changed = plain.replace(**{name: getattr(FULL, name)})
        assert changed != plain, name
        assert plain.replace(**{name: getattr(changed, name)}) == changed
    assert set(FULL.changes()) == {field.name for field in dataclasses.fields(FULL)}
    assert list(plain.changes()) == ["robot"]


def test_it_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Scenario().seed = 1


@pytest.mark.long
def test_another_process_has_the_same(tmp_path):
    code = (
        "import pickle, sys; from robsim import Scenario\n"
        "one = pickle.load(sys.stdin.buffer)\n"
        "print(one == Scenario.load(sys.argv[1]), len({one, Scenario.load(sys.argv[1])}))\n"
        "sys.stdout.flush(); sys.stdout.buffer.write(pickle.dumps(one))"
    )
    FULL.save(tmp_path / "full.toml")
    run = subprocess.run(
        [sys.executable, "-c", code, tmp_path / "full.toml"],
        input=pickle.dumps(FULL),
        capture_output=True,
        check=True,
    )
    told, _, pickled = run.stdout.partition(b"\n")
    assert told.strip() == b"True 1"
    assert pickle.loads(pickled) == FULL


def test_the_repr_says_what_is_not_the_default():
    scenario = Scenario(robot="sheep", area=(300, 200), seed=child_seed(), background=IMAGE)
    assert repr(scenario) == (
        "Scenario(robot='sheep', area=(300, 200), background=<array of shape (8, 10, 3)>, "
        "seed=SeedSequence(entropy=7, spawn_key=(1,)))"
    )


# --- normal forms


def test_names_and_files_are_read_at_once(tmp_path):
    robsim.imaging.save_image(tmp_path / "floor.png", IMAGE)
    (tmp_path / "colors.toml").write_text("[red]\nu = [1, 2]\n")
    read = Scenario(
        robot="lab",
        background=tmp_path / "floor.png",
        colors=tmp_path / "colors.toml",
        markers="sheep",
    )
    lab, sheep = robsim.load_robot("lab"), robsim.load_robot("sheep")
    red = robsim.ColorClass("red", u=(1, 2))
    assert read == Scenario(robot=lab, background=IMAGE, colors=[red], markers=sheep)
    assert read.markers == sheep.marker_layout()
    (tmp_path / "floor.png").unlink()
    assert read.replace(seed=1).background == read.background


def test_a_file_that_has_changed_is_read_anew(tmp_path):
    path = tmp_path / "floor.png"
    robsim.imaging.save_image(path, IMAGE)
    before = Scenario(background=path)
    robsim.imaging.save_image(path, np.concatenate((IMAGE, IMAGE)))
    assert Scenario(background=path) != before


def test_the_background_is_its_own(tmp_path):
    image = IMAGE.copy()
    scenario = Scenario(background=image)
    image[:] = 0
    assert scenario == Scenario(background=IMAGE)
    assert not scenario.background.pixels.flags.writeable


def test_sizes_and_poses_are_tuples_of_plain_numbers():
    scenario = Scenario(
        area=np.array((100, 90)),
        resolution=[np.int16(50), 45],
        start=np.array((1, 2, 6), np.float32),
        headings=np.uint8(4),
        camera_delay=np.int64(1),
        measure=np.True_,
    )
    assert repr(scenario.area) == "(100, 90)"
    assert repr(scenario.resolution) == "(50, 45)"
    assert scenario.start == (1.0, 2.0, 6 - 2 * np.pi)
    assert type(scenario.headings) is type(scenario.camera_delay) is int
    assert scenario.measure is True


@pytest.mark.parametrize("heading", [90, -180.0, 6.3])
def test_a_start_in_degrees_is_told(heading):
    with pytest.raises(ValueError, match=rf"got {heading:g}: if that is in degrees, it is .* rad"):
        Scenario(start=(300, 300, heading))
    with pytest.raises(ValueError, match="in degrees"):
        Scenario.from_toml(f"start = [300, 300, {heading}]")


def test_seeds_are_data():
    assert Scenario(seed=np.random.SeedSequence(5)).seed == 5
    assert Scenario(seed=np.int64(5)) == Scenario(seed=5)
    assert Scenario().seed is None
    assert Scenario(seed=child_seed()) == Scenario(seed=child_seed())
    assert Scenario(seed=child_seed()) != Scenario(seed=7)
    assert Scenario(seed=np.random.SeedSequence([1, 2])).seed.entropy == (1, 2)
    one, other = (Scenario(seed=np.random.default_rng(3)) for _ in "12")
    assert one == other
    assert type(one.seed) is int


def test_the_seed_gives_the_run_that_the_given_one_gave():
    direct = Simulation(control=robsim.DriveAround(), seed=child_seed()).run(30)
    seed = Scenario(seed=child_seed()).seed
    assert np.array_equal(Simulation(control=robsim.DriveAround(), seed=seed).run(30).u, direct.u)


def test_none_is_off():
    assert Scenario(measure=None, estimate_parameters=None) == Scenario()


# --- what it refuses

WRONG_OPTIONS = {
    "robot": (5, "no such robot", b"lab", ["lab"]),
    "area": (None, 5, "80x80", (100,), (1, 2, 3), (15, 16), (16385, 16), (100.0, 100), (True, 100)),
    "resolution": (0, (), "ab", (15, 16), (NAN, 100), (2**40, 100)),
    "boundary identify_from": ("wall", "Bounce", "Truth", None, 5, ["bounce"]),
    "headings": ("36", 1.5, NAN, True, 0, -1, 361, 2**70),
    "seed": (-1, 1.5, NAN, "1", True, [1], (1, 2), np.int64(-1), np.random.PCG64(1), object()),
    "colors": (5, COLORS[0], [1], [None], ["red"], b"red", {"red": 1}, [COLORS[0]] * 2, []),
    "markers": ("no such robot", 5, (43, 14), True),
}
NO_BACKGROUNDS = (5, IMAGE.tolist(), b"x", IMAGE.astype(float), IMAGE[..., 0], IMAGE[:0])
NO_BOOL = (1, 0, "yes", lambda step: None)
NO_DELAY = (-1, 1001, "1", None, True, NAN, 1j)


class Lazy(Spin):
    pass


class OwnNoise(robsim.GaussianNoise):
    pass


@pytest.mark.long
@refusals(
    options(Scenario, WRONG_OPTIONS, says=IN_WORDS),
    options(Scenario, {"background": NO_BACKGROUNDS}),
    options(Scenario, {"noise": ("gaussian", 40, True, robsim.GaussianNoise, OwnNoise(3))}),
    options(Scenario, {"dropout": (0.2, True, robsim.Dropout)}),
    options(Scenario, {"process_noise": (1, np.eye(3), robsim.GaussianNoise(1), robsim.PoseNoise)}),
    options(Scenario, {"mismatch": (0.1, True, robsim.ParameterMismatch)}),
    options(Scenario, {"camera_delay motor_delay": NO_DELAY, "camera_delay": (1.5, 1.0)}),
    options(Scenario, {"smoothing": (0, 2, 17, 1.5, True, "3")}),
    options(Scenario, {"model": (1, robsim.RobotModel().theta, robsim.RobotModel, "lab")}),
    options(Scenario, {"evaluate_model": (True, 1, robsim.Unicycle, lambda world: (0, 0, 0))}),
    options(Scenario, {"control": (1, "spin", Spin, Lazy(), lambda step: (0, 0))}),
    options(Scenario, {"measure estimate_parameters": NO_BOOL}),
    options(Scenario, {"start": ((1200, 5, 0), "x", (1, 2), [(1, 2), 3], NAN, (1j, 0, 0))}),
    options(Scenario, {"area_ frames time_limit define_model": (None,)}, raises=TypeError),
    options(Scenario().replace, WRONG_OPTIONS, says=IN_WORDS),
)
def test_wrong_options(refusal):
    refusal()


def test_code_is_no_data():
    with pytest.raises(TypeError, match=r"control must be .* code is no data, give it to Simul"):
        Scenario(control=lambda step: (0, 0))


def test_a_model_that_is_unstable():
    with pytest.raises(ValueError, match="linear_friction"):
        Scenario(model=robsim.RobotParameters(linear_friction=0))


def test_replace_knows_what_was_meant():
    with pytest.raises(TypeError, match="no option 'areas': did you mean 'area'"):
        Scenario().replace(areas=(300, 300))
    with pytest.raises(TypeError, match="no option 'xyz': there are robot, area"):
        Scenario().replace(xyz=1)
    with pytest.raises(ValueError, match="start must lie within"):
        Scenario(start=(1000, 1000, 0)).replace(area=(300, 300))


def test_the_pose_beyond_an_area_without_walls():
    assert Scenario(start=(-5, 2000, 0), boundary="unlimited").start == (-5, 2000, 0)


def test_recorded_inputs_are_compared_by_content():
    u = np.ones((3, 2))
    assert Scenario(control=Replay(u)) == Scenario(control=Replay(u.tolist()))
