import importlib
import linecache
import os
import re
import sys
import threading
import traceback
import warnings

import numpy as np
import pytest

import robsim
from robsim.simulation.callback_folder import CallbackFolder, new_folder

SLOTS = list(robsim.Simulation.SLOTS)
OPTIONAL = ["estimate_parameters", "measure", "estimate_state"]
SMALL = {"area": (300, 300)}
GEOMETRY = "def gain():\n    return {}\n"


@pytest.fixture(autouse=True)
def traceless(tmp_path, monkeypatch):
    """Whatever a test does: nothing of a folder stays in the interpreter, nor anything in it."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    finders, path = list(sys.meta_path), list(sys.path)
    yield
    assert sys.meta_path == finders
    assert sys.path == path
    files = {name: getattr(module, "__file__", None) for name, module in sys.modules.items()}
    assert [name for name, file in files.items() if str(file).startswith(str(tmp_path))] == []
    assert [name for name in files if name.startswith("robsim_callbacks")] == []
    assert list(tmp_path.rglob("__pycache__")) == []


@pytest.fixture
def mine(tmp_path):
    new_folder(tmp_path / "mine")
    return tmp_path / "mine"


def edit(file, old, new):
    text = file.read_text()
    assert text.count(old) == 1
    file.write_text(text.replace(old, new))


def enable(file):
    edit(file, "\nENABLED = False", "\nENABLED = True")


def simulation(callbacks, **options):
    """A simulation with the callbacks of a folder; what is missing or off is as without it."""
    on = {slot: callback for slot, callback in callbacks.items() if callback is not False}
    sim = robsim.Simulation(**{"seed": 1} | options, **on)
    if "estimate_parameters" not in on:
        sim.estimate_parameters = None
    return sim


def assert_same_bytes(sim, other, *, steps=30):
    trace, expected = sim.run(steps), other.run(steps)
    assert trace.names == expected.names
    for name in expected.names:
        assert trace[name].tobytes() == expected[name].tobytes(), name
    assert trace.info == expected.info
    assert sim.frame.image.tobytes() == other.frame.image.tobytes()


def load_error(folder):
    with pytest.raises(Exception) as caught:  # noqa: PT011
        CallbackFolder(folder).load()
    return caught.value


def write(folder, name, text):
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.py").write_text(text)


def drives(folder, body, top=""):
    """Write a controller of these lines."""
    lines = "".join(f"    {line}\n" for line in body.split("; "))
    write(folder, "control", f"{top}\ndef control(step):\n{lines}")


def control_of(folder):
    return CallbackFolder(folder).load()["control"]


def use_helper(folder, *, gain=1):
    """Let control.py take its voltage from a helper."""
    drives(folder, "return geometry.gain(), 0", top="import geometry\n")
    write(folder, "geometry", GEOMETRY.format(gain))


def test_a_new_folder_has_a_file_for_each_slot(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").touch()
    files = new_folder(tmp_path / "mine")
    assert [file.name for file in files] == [f"{slot}.py" for slot in SLOTS]
    callbacks = CallbackFolder(tmp_path / "mine").load()
    assert {slot for slot in SLOTS if callbacks[slot] is False} == set(OPTIONAL)
    for file in files:
        assert os.access(file, os.W_OK)
        assert file.read_text().startswith('"""')
    assert len(new_folder(tmp_path / "course" / "other")) == len(SLOTS)


def test_a_new_folder_overwrites_nothing(tmp_path):
    (tmp_path / "measure.py").write_text("my work")
    with pytest.raises(FileExistsError, match=r"measure\.py"):
        new_folder(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["measure.py"]
    assert (tmp_path / "measure.py").read_text() == "my work"
    with pytest.raises(NotADirectoryError):
        new_folder(tmp_path / "measure.py")


def test_the_optional_callbacks_enabled_do_what_true_does(mine):
    (mine / "control.py").write_text("import robsim\n\ncontrol = robsim.DriveAround()\n")
    enable(mine / "estimate_parameters.py")
    enable(mine / "measure.py")
    callbacks = CallbackFolder(mine).load()
    assert callable(callbacks["measure"])
    expected = robsim.Simulation(
        control=robsim.DriveAround(), measure=True, estimate_parameters=True, seed=1
    )
    assert_same_bytes(simulation(callbacks), expected, steps=60)
    assert np.isfinite(expected.trace.parameters[-1]).all()
    assert np.isfinite(expected.trace.pose_measured).all()


def suggestions(text):
    """The text with each suggestion of its comments put to work, one at a time."""
    for block in re.finditer(r"^ +# To try: .*\n((?: +# (?!To try).*\n)+)", text, re.MULTILINE):
        code = re.sub(r"^( +)# ", r"\1", block[1], flags=re.MULTILINE)
        yield text[: block.start(1)] + code + text[block.end(1) :]


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
def test_what_a_file_suggests_to_try_works_and_changes_something(mine, slot):
    for optional in OPTIONAL:
        enable(mine / f"{optional}.py")
    options = {"resolution": (300, 300), "start": (600, 600, 1.55)}
    plain = simulation(CallbackFolder(mine).load(), **options)
    before = plain.run(30)
    text = (mine / f"{slot}.py").read_text()
    tried = list(suggestions(text))
    assert len(tried) == text.count("# To try:") >= 1
    for changed in tried:
        (mine / f"{slot}.py").write_text(changed)
        sim = simulation(CallbackFolder(mine).load(), **options)
        trace = sim.run(30)
        same = all(trace[name].tobytes() == before[name].tobytes() for name in before.names)
        same_picture = sim.frame.image.tobytes() == plain.frame.image.tobytes()
        assert slot == "measure" or not (same and same_picture), changed


def test_a_switch_is_true_or_false(mine):
    edit(mine / "control.py", "\nENABLED = True", "\nENABLED = False")
    assert control_of(mine) is False
    edit(mine / "control.py", "\nENABLED = False", "\nENABLED = 0")
    with pytest.raises(TypeError, match=r"control\.py: ENABLED"):
        CallbackFolder(mine).load()


def test_other_things_than_a_plain_function(mine):
    for slot, line in (
        ("control", "control = robsim.DriveAround()"),
        ("define_model", "define_model = robsim.RobotModel"),
        ("measure", "measure = True"),
        ("estimate_parameters", "estimate_parameters = False"),
        ("control", "def control(step: 1 + 1, gain=2): return 0.1 * gain, 0"),
    ):
        (mine / f"{slot}.py").write_text(f"import robsim\n\n{line}\n")
        assert len(simulation(CallbackFolder(mine).load(), **SMALL).run(3)) == 3
    write(
        mine,
        "control",
        "from __future__ import annotations\nimport dataclasses, typing\n\n"
        "@dataclasses.dataclass\nclass Follow:\n    gain: typing.ClassVar[float] = 0.5\n\n"
        "    def __call__(self, step):\n        return self.gain, 0\n\ncontrol = Follow()\n",
    )
    assert control_of(mine)(None) == (0.5, 0)
    (mine / "control.py").write_bytes("def control(s):\r\n    return 1, 2".encode("utf-8-sig"))
    assert control_of(mine)(None) == (1, 2)


@pytest.mark.parametrize(
    "content", [b"def here(:\n", b"a = 1\n\0\n", "b = 'F\xfc\xdfe'\n".encode("latin-1")]
)
def test_a_file_that_is_no_python_is_named_with_its_line(mine, content):
    file = mine / "measure.py"
    file.write_bytes(content)
    error = load_error(mine)
    assert isinstance(error, SyntaxError)
    assert error.filename == str(file)
    assert f"while loading {file}" in error.__notes__
    assert f'File "{file}", line {error.lineno}' in "".join(traceback.format_exception_only(error))


def test_a_file_that_fails_when_executed(mine):
    file = mine / "evaluate_model.py"
    file.write_text("numbers = [1, 2]\nnumbers[2]\n")
    error = load_error(mine)
    assert isinstance(error, IndexError)
    assert error.__notes__ == [f"while loading {file}"]
    failed = error.callback
    assert (failed.slot, failed.k, failed.source.number) == ("evaluate_model", None, 2)
    assert failed.source.file == str(file)
    text = "".join(traceback.format_exception(error))
    assert f'File "{file}", line 2, in <module>\n    numbers[2]\n' in text
    file.write_text("raise SystemExit\n")
    with pytest.raises(SystemExit) as caught:
        CallbackFolder(mine).load()
    assert caught.value.__notes__ == [f"while loading {file}"]


@pytest.mark.parametrize(
    ("text", "kind", "told"),
    [
        ("class Other: pass\ndef controls(step): return 1\n", ValueError, "controls, Other"),
        ("control = 3", TypeError, "got 3"),
        ("def control(a, b): pass", TypeError, "control(a, b)"),
        ("def control(): pass", TypeError, "one argument"),
    ],
)
def test_a_file_without_the_function(mine, text, kind, told):
    (mine / "control.py").write_text(text)
    error = load_error(mine)
    assert isinstance(error, kind)
    for words in ("control.py", told):
        assert words in str(error)


def test_an_error_in_a_run_shows_the_line_that_ran_even_after_another_edit(mine):
    file = mine / "control.py"
    for number in (1, 2, 3):
        file.write_text(f"def control(step):\n    return {number} / 0\n")
        callbacks = CallbackFolder(mine).load()
        file.write_text("def control(step):\n    return 0, 0\n")
        with pytest.raises(ZeroDivisionError) as caught:
            simulation(callbacks, **SMALL).run(1)
        text = "".join(traceback.format_exception(caught.value))
        assert f'File "{file}", line 2, in control\n    return {number} / 0\n' in text
        assert linecache.getline(str(file), 2) == f"    return {number} / 0\n"


def test_a_folder_without_callbacks(tmp_path, mine):
    with pytest.raises(FileNotFoundError, match="robsim new"):
        CallbackFolder(tmp_path / "nothing").load()
    with pytest.raises(NotADirectoryError):
        CallbackFolder(mine / "control.py").load()
    (tmp_path / "geometry.py").touch()
    (tmp_path / "mesure.py").touch()
    with pytest.raises(ValueError, match=r"robsim new .*mesure\.py .*measure\.py"):
        CallbackFolder(tmp_path).load()


def test_a_misspelt_file_is_told(tmp_path):
    (tmp_path / "measure.py").write_text("def measure(step):\n    return None\n")
    for name in ("Control", "controller", "robot_controller"):
        file = tmp_path / f"{name}.py"
        file.write_text("")
        with pytest.warns(UserWarning, match=r"\bcontrol\.py") as caught:
            CallbackFolder(tmp_path).load()
        assert [warning.filename for warning in caught] == [str(file)]
        file.unlink()


def test_copies_and_other_files_are_left_alone(mine):
    for name in ("control_old", "control2", "control (1)", "geometry", "test_control", "test"):
        (mine / f"{name}.py").write_text("this is no Python")
    assert callable(control_of(mine))


@pytest.mark.parametrize("name", ["random", "numpy", "robsim"])
def test_a_helper_with_the_name_of_another_module(mine, name):
    write(mine, name, "")
    drives(mine, "return 0, 0", top=f"import {name}\n")
    with pytest.raises(ValueError, match=rf"{name}\.py"):
        CallbackFolder(mine).load()


def test_other_modules_of_the_same_name_come_back(mine, monkeypatch):
    use_helper(mine)
    other = type(sys)("geometry")
    monkeypatch.setitem(sys.modules, "geometry", other)
    folder = CallbackFolder(mine)
    assert folder.load()["control"](None) == (1, 0)
    assert sys.modules["geometry"] is other
    with folder.importable():
        assert importlib.import_module("geometry").gain() == 1
    assert sys.modules["geometry"] is other


def test_a_helper_imported_by_a_callback_as_it_runs(mine):
    write(mine, "geometry", GEOMETRY.format(3))
    drives(mine, "import geometry; return geometry.gain(), 0")
    folder = CallbackFolder(mine)
    control = folder.load()["control"]
    with pytest.raises(ModuleNotFoundError):
        control(None)
    with folder.importable():
        assert control(None) == (3, 0)
        write(mine, "geometry", GEOMETRY.format(4))
        assert control(None) == (3, 0)
    assert folder.changed == {"geometry"}
    # A load that fails leaves what was loaded.
    write(mine, "measure", "def measure(:\n")
    for _ in range(2):
        with pytest.raises(SyntaxError):
            folder.load()
        assert folder.changed == {"geometry", "measure"}
    with folder.importable():
        assert control(None) == (3, 0)


def test_a_helper_that_imports_a_helper_and_fails(mine):
    write(mine, "geometry", "import lines\n")
    write(mine, "lines", "1 / 0\n")
    write(mine, "control", "import geometry\n")
    error = load_error(mine)
    assert isinstance(error, ZeroDivisionError)
    assert error.__notes__ == [
        f"while loading {mine / name}.py" for name in ("lines", "geometry", "control")
    ]


def test_a_callback_cannot_be_imported(mine, monkeypatch):
    write(mine, "estimate_state", "")
    write(mine, "measure", "from estimate_state import estimate_state\n")
    for path in (sys.path, [str(mine), *sys.path]):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "path", path)
            with pytest.raises(ModuleNotFoundError, match=r"estimate_state\.py"):
                CallbackFolder(mine).load()


def test_a_package_with_the_name_of_a_slot_is_found(mine, tmp_path, monkeypatch):
    write(tmp_path / "packages", "control", "tf = 'transfer function'\n")
    drives(mine, "return package.tf", top="import control as package\n")
    with monkeypatch.context() as patch:
        patch.delitem(sys.modules, "control", raising=False)  # python-control
        patch.setattr(sys, "dont_write_bytecode", True)  # of the package
        patch.setattr(sys, "path", [str(mine), str(tmp_path / "packages"), *sys.path])
        assert control_of(mine)(None) == "transfer function"
        assert sys.modules.pop("control").tf == "transfer function"


def test_new_and_deleted_files_are_changes_and_touched_ones_are_none(mine):
    folder = CallbackFolder(mine)
    folder.load()
    os.utime(mine / "control.py", (1_000_000_000, 1_000_000_000))
    (mine / ".#control.py").symlink_to("nowhere")
    assert not folder.changed
    (mine / "geometry.py").touch()
    assert folder.changed == {"geometry"}
    folder.load()
    (mine / "control.py").unlink()
    assert folder.changed == {"control"}
    assert "control" not in folder.load()


def test_a_folder_is_the_same_from_another_working_folder(mine, tmp_path, monkeypatch):
    use_helper(mine)
    monkeypatch.chdir(tmp_path)
    folder = CallbackFolder("mine")
    control = folder.load()["control"]
    assert control.__code__.co_filename == str(mine / "control.py")
    monkeypatch.chdir("/")
    assert not folder.changed
    write(mine, "measure", "")
    with pytest.raises(ValueError, match=r"mine/measure\.py"):
        folder.load()


@pytest.mark.long
def test_another_thread_waits_for_its_turn(tmp_path):
    for gain, name in enumerate(("anna", "ben")):
        use_helper(tmp_path / name, gain=gain)
    loaded, begins = [], threading.Event()

    def load_ben():
        begins.set()
        loaded.append(control_of(tmp_path / "ben")(None))

    anna = CallbackFolder(tmp_path / "anna")
    anna.load()
    thread = threading.Thread(target=load_ben)
    with anna.importable():
        thread.start()
        assert begins.wait(300)
        for _ in range(10_000):
            assert importlib.import_module("geometry").gain() == 0
        assert loaded == []
    thread.join(300)
    assert loaded == [(1, 0)]


def test_a_warning_of_the_compiler_is_given_once(mine):
    drives(mine, "return step is 1, 0")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        CallbackFolder(mine).load()
    (warning,) = caught
    assert warning.category is SyntaxWarning
    assert (warning.filename, warning.lineno) == (str(mine / "control.py"), 3)


def rest(folder):
    """Let the files be so old that a change of them has another time."""
    for file in folder.glob("*.py"):
        os.utime(file, (1e9, 1e9))


def test_files_that_rest_are_not_read_again(mine, monkeypatch):
    rest(mine)
    folder = CallbackFolder(mine)
    folder.load()
    assert folder.changed == set()
    with monkeypatch.context() as unreadable:
        unreadable.setattr(type(mine), "read_bytes", None)
        assert folder.changed == set()
    edit(mine / "control.py", "0.05, -0.05", "0.06, -0.06")  # of the same length
    assert folder.changed == {"control"}
    rest(mine)
    assert folder.changed == {"control"}
    folder.load()
    assert folder.changed == set()


def test_two_changes_at_the_same_time_are_noticed(mine):
    use_helper(mine, gain=1)
    folder = CallbackFolder(mine)
    assert folder.load()["control"](None) == (1, 0)
    times = os.stat(mine / "geometry.py")
    for gain in (2, 3):
        write(mine, "geometry", GEOMETRY.format(gain))
        os.utime(mine / "geometry.py", ns=(times.st_atime_ns, times.st_mtime_ns))
        assert folder.changed == {"geometry"}
        assert folder.load()["control"](None) == (gain, 0)
        assert not folder.changed


def test_a_file_that_is_being_saved_is_waited_for(mine, monkeypatch):
    whole = (mine / "control.py").read_text()
    (mine / "control.py").write_text("")
    waits = []

    def wait(seconds):
        waits.append(seconds)
        (mine / "control.py").write_text(whole if len(waits) == 2 else whole[:200])

    monkeypatch.setattr("time.sleep", wait)
    assert CallbackFolder(mine).load_saved()["control"](None) == (0.05, -0.05)
    (mine / "control.py").write_text("x y")
    monkeypatch.setattr("time.sleep", lambda seconds: None)
    with pytest.raises(SyntaxError):
        CallbackFolder(mine).load_saved()
