import dataclasses
import inspect
import pickle

import numpy as np
import pytest
from hypothesis import given, settings

import robsim
from refusals import IMAGE
from robsim import Replay, Scenario, Simulation, Spin
from robsim.base.seeds import STREAMS, SeedRecord, stream, stream_number
from robsim.simulation.option import ROBOT, WORLD, Number
from robsim.simulation.options import OPTIONS
from scenarios import FULL, scenarios
from sizes import thorough

pytestmark = pytest.mark.filterwarnings("ignore:a noise of", "ignore:a heading noise of")


def child_seed():
    return np.random.SeedSequence(7).spawn(2)[1]


# --- a value


@pytest.mark.long
@settings(max_examples=thorough(100, 12))
@given(scenarios())
def test_scenarios_of_the_same_content_are_equal(scenario):
    again = Scenario(**{f.name: getattr(scenario, f.name) for f in dataclasses.fields(scenario)})
    for other in (again, scenario.replace(), pickle.loads(pickle.dumps(scenario))):
        assert other == scenario
        assert hash(other) == hash(scenario)
        assert repr(other) == repr(scenario)


def test_every_option_counts():
    plain = Scenario()
    for name in (field.name for field in dataclasses.fields(FULL)):
        changed = plain.replace(**{name: getattr(FULL, name)})
        assert changed != plain, name
        assert plain.replace(**{name: getattr(changed, name)}) == changed
    assert set(FULL.changes()) == {field.name for field in dataclasses.fields(FULL)}
    assert list(plain.changes()) == ["robot"]


def test_each_option_is_of_the_world_or_of_a_robot_and_a_simulation_takes_both():
    world = {name for name, option in OPTIONS.items() if option.of == WORLD}
    assert all(option.of == ROBOT for name, option in OPTIONS.items() if name not in world)
    assert set(OPTIONS) <= set(inspect.signature(Simulation).parameters)
    assert world >= {"area", "boundary", "noise", "camera_delay", "seed"}
    assert not world & {"robot", "start", "dropout", "process_noise", "motor_delay"}


# --- normal forms


def test_names_and_files_are_read_at_once(tmp_path):
    robsim.vision.save_image(tmp_path / "floor.png", IMAGE)
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
    (tmp_path / "floor.png").write_bytes(b"no picture")
    with pytest.raises(ValueError, match=r"floor\.png"):
        Scenario(background=tmp_path / "floor.png")
    for name in ("colors", "background"):
        with pytest.raises(FileNotFoundError, match="missing"):
            Scenario(**{name: tmp_path / "missing"})
    assert read.replace(seed=1).background == read.background


def test_a_file_that_has_changed_is_read_anew(tmp_path):
    path = tmp_path / "floor.png"
    robsim.vision.save_image(path, IMAGE)
    before = Scenario(background=path)
    robsim.vision.save_image(path, np.concatenate((IMAGE, IMAGE)))
    assert Scenario(background=path) != before


def test_the_background_is_its_own(tmp_path):
    image = IMAGE.copy()
    scenario = Scenario(background=image)
    image[:] = 0
    assert scenario == Scenario(background=IMAGE)
    assert not scenario.background.pixels.flags.writeable


def test_backgrounds_of_any_layout_are_taken():
    for background in (IMAGE[:, ::-1], np.asfortranarray(IMAGE), IMAGE[::2], IMAGE[..., ::-1]):
        sim = Simulation(background=background, area=(200, 200), start=(199, 199, 0), seed=1)
        assert sim.frame.image[20, 20].tolist() == [100, 100, 100]


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


@pytest.mark.parametrize("make", [int, lambda n: -n, np.random.SeedSequence, SeedRecord])
def test_a_seed_has_a_limit(make):
    for call in (Scenario, robsim.Simulation):
        with pytest.raises(ValueError, match=r"(seed|entropy) .*2\*\*4096"):
            call(seed=make(10**2000))
    with pytest.raises(ValueError, match="seed "):
        robsim.Simulation().reset(seed=10**2000)
    assert Scenario(seed=2**4096 - 1).seed == 2**4096 - 1


def test_the_streams_of_a_robot_do_not_depend_on_how_many_there_are():
    seed = child_seed()
    for i, name in enumerate(STREAMS):  # of the one robot, as ever
        key = (*seed.spawn_key, i)
        assert stream(seed, name).spawn_key == stream(seed, name, 0).spawn_key == key
    numbers = [stream_number(seed, name, robot) for robot in range(50) for name in STREAMS]
    assert len(set(numbers)) == len(numbers)
    assert numbers[: len(STREAMS)] == [stream_number(seed, name) for name in STREAMS]
    assert stream(seed, "start", 3).spawn_key == (*seed.spawn_key, 2**16, 3, STREAMS.index("start"))
    assert stream(seed, "start", 3).entropy == seed.entropy


def test_the_seed_gives_the_run_that_the_given_one_gave():
    direct = Simulation(control=robsim.DriveAround(), seed=child_seed()).run(30)
    seed = Scenario(seed=child_seed()).seed
    assert np.array_equal(Simulation(control=robsim.DriveAround(), seed=seed).run(30).u, direct.u)


def test_none_is_off():
    assert Scenario(measure=None, estimate_parameters=None) == Scenario()


# --- what it refuses

UNLIMITED = {"boundary": "unlimited"}
RED = robsim.ColorClass("red")
#: What each option just takes, and what it just refuses.
LIMITS = [
    ("area", ((16, 16), (16384, 4096), (8192, 8192)), ((15, 16), (16, 15), (16385, 16))),
    ("area", (), ((8192, 8193), (100.0, 100), (1, 2, 3))),
    ("resolution", ((16, 16), (8192, 8192)), ((15, 16), (8192, 8193), (100,), 0)),
    ("headings", (1, 360, None), (0, 361, 1.5)),
    ("camera_delay", (0, 1000), (-1, 1001, 1.5)),
    ("motor_delay", (0, 1000, 999.5), (-1, -1e-9, 1000.5)),
    ("smoothing", (1, 15), (0, 2, 16, 17)),
    ("seed", (0, 2**200), (-1, np.int64(-1))),
    ("start", ((0, 0, 0), (1199, 1199, 6.28)), ((-0.5, 0, 0), (0, 1199.5, 0), (1, 1, 6.3))),
    ("colors", ([RED],), ([], [RED, RED])),
    ("background", (IMAGE,), (IMAGE[..., 0], IMAGE[:0], IMAGE.astype(float))),
    ("boundary", ("bounce", "unlimited"), ("Bounce", "wall")),
    ("identify_from", ("truth", "measurement", "estimate"), ("Truth", "camera")),
    ("model", (robsim.RobotParameters(linear_friction=1e-3),), ()),
]


@pytest.mark.parametrize(("name", "taken", "refused"), LIMITS)
def test_limits(name, taken, refused):
    for value in taken:
        Scenario(**{name: value})
    for value in refused:
        for make in (Scenario, Simulation, Scenario().replace):
            with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
                make(**{name: value})


def test_numbers_beyond_the_limits_of_their_rows_are_refused():
    for name, row in OPTIONS.items():
        for value in (row.minimum - 1, row.maximum + 1) if isinstance(row, Number) else ():
            with pytest.raises(ValueError, match=rf"\b{name}\b.*{row.limits}"):
                Scenario(**{name: value})


def test_a_start_without_walls_may_lie_anywhere_within_a_million_px():
    assert Scenario(start=(-5, 2000, 0), **UNLIMITED).start == (-5, 2000, 0)
    Scenario(start=(-1e6, 1e6, 0), **UNLIMITED)
    with pytest.raises(ValueError, match="start"):
        Scenario(start=(0, -1.1e6, 0), **UNLIMITED)
    with pytest.raises(ValueError, match="start"):
        Scenario(start=(1000, 1000, 0)).replace(area=(300, 300))


class OwnSpin(Spin):
    pass


class OwnNoise(robsim.GaussianNoise):
    pass


def test_code_is_no_data():
    for name, code in (
        ("control", OwnSpin()),
        ("control", lambda step: (0, 0)),
        ("noise", OwnNoise(3)),
        ("evaluate_model", lambda world: (0, 0, 0)),
        ("measure", lambda step: None),
    ):
        with pytest.raises(TypeError, match=rf"\b{name}\b"):
            Scenario(**{name: code})


def test_recorded_inputs_are_compared_by_content():
    u = np.ones((3, 2))
    assert Scenario(control=Replay(u)) == Scenario(control=Replay(u.tolist()))


def test_other_options():
    with pytest.raises(TypeError, match=r"'areas'.*'area'"):
        Scenario().replace(areas=(300, 300))
    with pytest.raises(TypeError, match="define_model"):
        Scenario(define_model=None)
    with pytest.raises(ValueError, match="linear_friction"):
        Scenario(model=robsim.RobotParameters(linear_friction=0))
    with pytest.raises(TypeError, match="noise"):
        Simulation(noise=40)
