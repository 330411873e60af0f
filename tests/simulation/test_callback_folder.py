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
from robsim.simulation import _slots as table
from robsim.simulation._folders.callback_folder import CallbackFolder, new_folder

SLOTS = list(table.SLOTS)
ONCE, STEP = table.names(when=table.ONCE), table.names(when=table.STEP)
OPTIONAL = [name for name, slot in table.SLOTS.items() if slot.is_optional]
ARGUMENTS = {name: slot.argument for name, slot in table.SLOTS.items()}
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


def test_the_slots_are_those_of_the_simulation():
    assert sorted(SLOTS) == sorted((*ONCE, *STEP))


def test_a_new_folder_has_a_file_for_each_slot(tmp_path):
    files = new_folder(tmp_path / "course" / "mine")
    assert [file.name for file in files] == [f"{slot}.py" for slot in SLOTS]
    assert sorted(files) == sorted((tmp_path / "course" / "mine").iterdir())
    for file in files:
        assert os.access(file, os.W_OK)
        assert file.read_text().startswith('"""')


def test_the_optional_callbacks_are_off_at_first(mine):
    callbacks = CallbackFolder(mine).load()
    assert list(callbacks) == SLOTS
    assert {slot for slot in SLOTS if callbacks[slot] is False} == set(OPTIONAL)
    assert all(callable(callbacks[slot]) for slot in set(SLOTS) - set(OPTIONAL))


def test_a_new_folder_overwrites_nothing(tmp_path):
    (tmp_path / "measure.py").write_text("my work")
    with pytest.raises(FileExistsError, match=r"has measure\.py already: nothing was written"):
        new_folder(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["measure.py"]
    assert (tmp_path / "measure.py").read_text() == "my work"


def test_a_new_folder_beside_other_files(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert len(new_folder(tmp_path)) == len(SLOTS)


def test_a_new_folder_where_a_file_is(tmp_path):
    (tmp_path / "mine").touch()
    with pytest.raises(NotADirectoryError, match="mine is a file, not a folder"):
        new_folder(tmp_path / "mine")


@pytest.mark.parametrize("make", [new_folder, CallbackFolder])
def test_a_folder_must_be_a_path(make):
    with pytest.raises(TypeError, match="folder must be a path, got 3"):
        make(3)


@pytest.mark.long
@pytest.mark.parametrize(
    "options",
    [{}, {"boundary": "unlimited", "noise": robsim.GaussianNoise(5)},
     {"area": (700, 500), "resolution": (350, 250), "measure": True}],
)  # fmt: skip
def test_an_untouched_folder_gives_the_same_bytes_as_none(mine, options):
    callbacks = CallbackFolder(mine).load()
    plain = robsim.Simulation(seed=1, **options)
    assert_same_bytes(simulation(callbacks, **options), plain)


@pytest.mark.long
@pytest.mark.parametrize("slot", ["define_model", "evaluate_model", "adjust_background"])
def test_each_default_is_that_of_the_simulation_where_the_robot_drives(mine, slot):
    options = {"control": robsim.DriveAround(), "seed": 3}
    callback = CallbackFolder(mine).load()[slot]
    with_default = robsim.Simulation(**options, **{slot: callback})
    assert_same_bytes(with_default, robsim.Simulation(**options), steps=100)


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


def test_the_state_estimator_keeps_the_last_pose_and_doubts_it_more(mine):
    enable(mine / "estimate_state.py")
    (mine / "measure.py").write_text(
        "import robsim\n"
        "def measure(step):\n"
        "    return robsim.Measurement((step.k, 2, 0.5)) if step.k in (3, 4) else None\n"
    )
    sim = simulation(CallbackFolder(mine).load(), resolution=(120, 120))
    trace = sim.run(9)
    assert trace.pose_estimated[0].tolist() == [600, 600, 0]
    np.testing.assert_array_equal(trace.pose_estimated[4:], [[4, 2, 0.5]] * 5)
    variances = np.diagonal(trace.covariance, axis1=1, axis2=2)
    growth = np.diff(variances, axis=0)
    assert (growth[[0, 1, 4, 5, 6, 7]] > 0).all()
    assert (growth[2] < 0).all()
    sim.reset()
    again = sim.run(9)
    assert again.pose_estimated.tobytes() == trace.pose_estimated.tobytes()
    assert again.covariance.tobytes() == trace.covariance.tobytes()


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
    options = {"resolution": (600, 600), "start": (600, 600, 1.55)}
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


def test_the_measurement_by_hand_agrees_with_that_of_robsim(mine):
    enable(mine / "measure.py")
    (by_hand,) = suggestions((mine / "measure.py").read_text())
    (mine / "measure.py").write_text(by_hand)
    measure = CallbackFolder(mine).load()["measure"]
    options = {"control": robsim.DriveAround(), "resolution": (600, 600), "seed": 1}
    measured = robsim.Simulation(measure=measure, **options).run(60).pose_measured
    expected = robsim.Simulation(measure=True, **options).run(60).pose_measured
    assert np.isfinite(expected).all()
    np.testing.assert_allclose(measured[:, :2], expected[:, :2], atol=1)
    assert np.abs(robsim.wrap_angle(measured[:, 2] - expected[:, 2])).max() < 0.02


def test_a_slot_without_a_file_is_not_in_the_result(tmp_path):
    (tmp_path / "control.py").write_text("def control(step):\n    return 0.1, 0.2\n")
    callbacks = CallbackFolder(tmp_path).load()
    assert list(callbacks) == ["control"]
    assert simulation(callbacks, **SMALL).run(2).u.tolist() == [[0.1, 0.2]] * 2


def test_a_file_that_is_switched_off(mine):
    edit(mine / "control.py", "\nENABLED = True", "\nENABLED = False")
    assert CallbackFolder(mine).load()["control"] is False


@pytest.mark.parametrize("value", ["0", "None", "'no'"])
def test_a_switch_must_be_true_or_false(mine, value):
    edit(mine / "control.py", "\nENABLED = True", f"\nENABLED = {value}")
    with pytest.raises(TypeError, match=r"control\.py: ENABLED must be True or False, got "):
        CallbackFolder(mine).load()


@pytest.mark.long
@pytest.mark.parametrize(
    ("slot", "line"),
    [("control", "control = robsim.DriveAround()"),
     ("define_model", "define_model = robsim.RobotModel"),
     ("evaluate_model", "evaluate_model = robsim.Unicycle()"),
     ("measure", "measure = True"),
     ("estimate_parameters", "estimate_parameters = True"),
     ("estimate_parameters", "estimate_parameters = False"),
     ("control", "control = lambda *anything: (0.1, 0.1)"),
     ("control", "def control(step, gain=2): return 0.1 * gain, 0")],
)  # fmt: skip
def test_other_things_than_a_plain_function(mine, slot, line):
    (mine / f"{slot}.py").write_text(f"import robsim\n\n{line}\n")
    assert len(simulation(CallbackFolder(mine).load(), **SMALL).run(3)) == 3


BROKEN = {
    "SyntaxError": b"def here(:\n",
    "IndentationError": b"def here():\nreturn 1\n",
    "TabError": b"if True:\n\ta = 1\n        b = 2\n",
    "null bytes": b"a = 1\n\0\n",
    "UTF-16": "a = 1\nb = 2\n".encode("utf-16"),
    "Latin-1": "a = 1\nb = 'Füße'\n".encode("latin-1"),
    "a comment in Latin-1": "a = 1\nb = 2\n# Füße\n".encode("latin-1"),
    "an unknown encoding": b"# coding: klingon\n",
}


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("what", BROKEN)
def test_a_file_that_is_no_python_is_named_with_its_line(mine, slot, what):
    file = mine / f"{slot}.py"
    file.write_bytes(BROKEN[what])
    error = load_error(mine)
    assert isinstance(error, SyntaxError)
    assert error.filename == str(file)
    assert error.lineno in (1, 2, 3)
    assert f"while loading {file}" in error.__notes__
    assert f'File "{file}", line {error.lineno}' in "".join(traceback.format_exception_only(error))


def test_a_byte_order_mark_and_windows_line_ends_are_no_mistake(mine):
    text = (mine / "control.py").read_text()
    (mine / "control.py").write_bytes(text.replace("\n", "\r\n").encode("utf-8-sig"))
    assert CallbackFolder(mine).load()["control"](None) == (0.05, -0.05)


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
def test_a_file_that_fails_when_executed(mine, slot):
    file = mine / f"{slot}.py"
    file.write_text("numbers = [1, 2]\nnumbers[2]\n")
    error = load_error(mine)
    assert isinstance(error, IndexError)
    assert error.__notes__ == [f"while loading {file}"]
    text = "".join(traceback.format_exception(error))
    assert f'File "{file}", line 2, in <module>\n    numbers[2]\n' in text


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
def test_a_file_with_another_name_in_it(mine, slot):
    file = mine / f"{slot}.py"
    file.write_text(
        f"from math import sin\n\nclass Other:\n    pass\n\n\ndef {slot}l(step):\n    return 1\n"
    )
    wanted = f"{slot}({ARGUMENTS[slot]})"
    error = load_error(mine)
    assert isinstance(error, ValueError)
    assert str(error) == f"{file} must define {wanted}; it defines: {slot}l, Other"


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
def test_an_empty_file(mine, slot):
    (mine / f"{slot}.py").write_bytes(b"")
    assert str(load_error(mine)).endswith("; it defines: no function")


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("value", ["3", "None", "'text'"])
def test_a_name_that_is_no_function(mine, slot, value):
    file = mine / f"{slot}.py"
    file.write_text(f"{slot} = {value}\n")
    error = load_error(mine)
    assert isinstance(error, TypeError)
    assert str(error).startswith(f"{file}: {slot} must be a function {slot}(")
    assert str(error).endswith(f"got {value}")


def test_true_is_for_stages_of_robsim_only(mine):
    (mine / "control.py").write_text("control = True\n")
    with pytest.raises(TypeError, match=r"control must be a function control\(step\), got True"):
        CallbackFolder(mine).load()


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
def test_a_function_with_other_arguments(mine, slot):
    (mine / f"{slot}.py").write_text(f"def {slot}(a, b):\n    pass\n")
    count = "one argument" if ARGUMENTS[slot] else "no argument"
    with pytest.raises(
        TypeError, match=rf"{slot}\.py: {slot} must take {count}.*, got {slot}\(a, b\)"
    ):
        CallbackFolder(mine).load()


def test_a_controller_without_argument(mine):
    (mine / "control.py").write_text("def control():\n    return 0, 0\n")
    message = r"control\.py: control must take one argument, step, got control\(\)"
    with pytest.raises(TypeError, match=message):
        CallbackFolder(mine).load()


@pytest.mark.long
@pytest.mark.parametrize("slot", SLOTS)
def test_a_wrong_result_is_told_with_slot_and_file(mine, slot):
    file = mine / f"{slot}.py"
    file.write_text(f"\n\ndef {slot}({ARGUMENTS[slot]}):\n    return 'nonsense'\n")
    sim = simulation(CallbackFolder(mine).load(), **SMALL)
    if slot == "init_parameter_estimator":
        sim.estimate_parameters = True
    with pytest.raises((TypeError, ValueError)) as caught:
        sim.run(5)
    text = "".join(traceback.format_exception(caught.value))
    assert re.search({"init_parameter_estimator": "estimator.* must have"}.get(slot, slot), text)
    if slot in STEP:
        assert f'File "{file}", line 3, in {slot}' in text


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


def test_a_folder_that_is_not_there(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no folder .*nothing: robsim new .* creates it"):
        CallbackFolder(tmp_path / "nothing").load()


def test_a_file_instead_of_a_folder(mine):
    with pytest.raises(NotADirectoryError, match=r"control\.py is a file, not a folder of"):
        CallbackFolder(mine / "control.py").load()


def test_a_folder_without_callbacks(tmp_path):
    (tmp_path / "geometry.py").touch()
    (tmp_path / "mesure.py").touch()
    with pytest.raises(ValueError, match=r"has no callback files: robsim new .* writes them; "
                       r"is mesure\.py meant to be measure\.py\?"):  # fmt: skip
        CallbackFolder(tmp_path).load()


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "meant"),
    [("mesure", "measure"), ("controller", "control"), ("Control", "control"),
     ("defineModel", "define_model"), ("evaluate-model", "evaluate_model"),
     ("estimate_parameter", "estimate_parameters"), ("robotModelDef", "define_model"),
     ("myParameterEstimatorInit", "init_parameter_estimator"),
     ("adjustBackground", "adjust_background"), ("robotModelEval", "evaluate_model"),
     ("myParameterEstimator", "estimate_parameters"), ("measurePosNOrientation", "measure"),
     ("stateEstimator", "estimate_state"), ("robot_controller", "control")],
)  # fmt: skip
def test_a_misspelt_file_is_told(tmp_path, name, meant):
    other = "control" if meant == "measure" else "measure"
    (tmp_path / f"{other}.py").write_text(f"def {other}(step):\n    return None\n")
    (tmp_path / f"{name}.py").write_text("")
    message = rf"{name}\.py is no callback: did you mean {meant}\.py\?$"
    with pytest.warns(UserWarning, match=message) as caught:
        CallbackFolder(tmp_path).load()
    assert [warning.filename for warning in caught] == [str(tmp_path / f"{name}.py")]


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["control_old", "control2", "control (1)", "geometry", "plot", "test_control", "test"]
)
def test_copies_and_other_files_are_left_alone(mine, name):
    (mine / f"{name}.py").write_text("this is no Python")
    assert callable(CallbackFolder(mine).load()["control"])


@pytest.mark.parametrize("indent", ["", "    "])
def test_a_helper_may_have_a_name_like_that_of_a_slot(mine, indent):
    (mine / "controller.py").write_text("def follow(step):\n    return 0.3, 0.2\n")
    (mine / "control.py").write_text(
        "from controller import follow as control\n"
        if not indent
        else "def control(step):\n    from controller import follow\n    return follow(step)\n"
    )
    folder = CallbackFolder(mine)
    control = folder.load()["control"]
    with folder.importable():
        assert control(None) == (0.3, 0.2)


@pytest.mark.parametrize("name", ["random", "numpy", "robsim", "statistics"])
def test_a_helper_with_the_name_of_another_module(mine, name):
    (mine / f"{name}.py").write_text("")
    (mine / "control.py").write_text(f"import {name}\n\ndef control(step):\n    return 0, 0\n")
    with pytest.raises(ValueError, match=rf"{name}\.py has the name of a module .*: rename it"):
        CallbackFolder(mine).load()


def use_helper(folder, *, gain=1):
    """Let control.py take its voltage from a helper."""
    (folder / "geometry.py").write_text(GEOMETRY.format(gain))
    (folder / "control.py").write_text(
        "import geometry\n\ndef control(step):\n    return geometry.gain(), 0\n"
    )


def test_helpers_of_the_same_name_in_two_folders(tmp_path):
    folders = [tmp_path / "anna", tmp_path / "ben"]
    for gain, folder in enumerate(folders):
        folder.mkdir()
        use_helper(folder, gain=gain)
    controls = [CallbackFolder(folder).load()["control"] for folder in folders]
    assert [control(None) for control in controls] == [(0, 0), (1, 0)]


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
    (mine / "geometry.py").write_text(GEOMETRY.format(3))
    (mine / "control.py").write_text(
        "def control(step):\n    import geometry\n\n    return geometry.gain(), 0\n"
    )
    folder = CallbackFolder(mine)
    control = folder.load()["control"]
    with pytest.raises(ModuleNotFoundError):
        control(None)
    with folder.importable():
        assert control(None) == (3, 0)
        (mine / "geometry.py").write_text(GEOMETRY.format(4))
        assert control(None) == (3, 0)
    assert folder.changed


def test_a_helper_is_one_module_for_all_files_and_all_runs(mine):
    (mine / "memory.py").write_text("seen = []\n")
    for slot in ("control", "measure"):
        (mine / f"{slot}.py").write_text(
            f"def {slot}(step):\n    import memory\n\n    memory.seen.append('{slot}')\n"
            "    return memory.seen\n"
        )
    folder = CallbackFolder(mine)
    callbacks = folder.load()
    with folder.importable():
        callbacks["measure"](None)
    with folder.importable():
        assert callbacks["control"](None) == ["measure", "control"]
        with folder.importable():
            assert len(callbacks["control"](None)) == 3
        assert len(callbacks["control"](None)) == 4


def test_a_helper_that_imports_a_helper_and_fails(mine):
    (mine / "geometry.py").write_text("import lines\n")
    (mine / "lines.py").write_text("1 / 0\n")
    (mine / "control.py").write_text("import geometry\n")
    error = load_error(mine)
    assert isinstance(error, ZeroDivisionError)
    assert error.__notes__ == [
        f"while loading {mine / name}.py" for name in ("lines", "geometry", "control")
    ]


def test_a_callback_cannot_be_imported(mine, monkeypatch):
    (mine / "measure.py").write_text("from control import control\n")
    for path in (sys.path, [str(mine), *sys.path]):
        with monkeypatch.context() as patch:
            patch.setattr(sys, "path", path)
            message = r"control\.py is a callback, which other files cannot import"
            with pytest.raises(ModuleNotFoundError, match=message):
                CallbackFolder(mine).load()


@pytest.mark.parametrize("also_here", [False, True])
def test_a_package_with_the_name_of_a_slot_is_found(mine, tmp_path, monkeypatch, also_here):
    (tmp_path / "packages").mkdir()
    (tmp_path / "packages" / "control.py").write_text("tf = 'transfer function'\n")
    (mine / "control.py").write_text(
        "import control as package\n\ndef control(step):\n    return package.tf\n"
    )
    places = [str(tmp_path / "packages"), *sys.path]
    with monkeypatch.context() as patch:
        patch.setattr(sys, "dont_write_bytecode", True)  # of the package
        patch.setattr(sys, "path", [str(mine), *places] if also_here else places)
        assert CallbackFolder(mine).load()["control"](None) == "transfer function"
        assert sys.modules.pop("control").tf == "transfer function"


def test_a_dataclass_in_a_callback_file(mine):
    (mine / "control.py").write_text(
        "from __future__ import annotations\n"
        "import dataclasses\n"
        "import typing\n\n"
        "@dataclasses.dataclass\n"
        "class Follow:\n"
        "    gain: typing.ClassVar[float] = 0.5\n\n"
        "    def __call__(self, step):\n"
        "        return self.gain, 0\n\n"
        "control = Follow()\n"
    )
    assert CallbackFolder(mine).load()["control"](None) == (0.5, 0)


def test_annotations_of_a_file_are_its_own_affair(mine):
    (mine / "control.py").write_text("def control(step: 1 + 1):\n    return 0, 0\n")
    assert CallbackFolder(mine).load()["control"].__annotations__ == {"step": 2}


def test_an_edit_is_seen_within_the_second_and_at_the_same_length(mine):
    use_helper(mine, gain=1)
    folder = CallbackFolder(mine)
    assert folder.changed
    for gain in (1, 2, 3):
        (mine / "geometry.py").write_text(GEOMETRY.format(gain))
        os.utime(mine / "geometry.py", (1_000_000_000, 1_000_000_000))
        assert "geometry" in folder.changed
        assert folder.load()["control"](None) == (gain, 0)
        assert not folder.changed


def test_new_and_deleted_files_are_changes_and_touched_ones_are_none(mine):
    folder = CallbackFolder(mine)
    folder.load()
    os.utime(mine / "control.py", (1_000_000_000, 1_000_000_000))
    (mine / "notes.txt").touch()
    (mine / ".#control.py").symlink_to("nowhere")
    assert not folder.changed
    (mine / "geometry.py").touch()
    assert folder.changed == {"geometry"}
    folder.load()
    assert not folder.changed
    (mine / "control.py").unlink()
    assert folder.changed == {"control"}
    assert "control" not in folder.load()


def test_a_failing_load_leaves_what_was_loaded(mine):
    use_helper(mine, gain=1)
    (mine / "control.py").write_text(
        "def control(step):\n    import geometry\n\n    return geometry.gain(), 0\n"
    )
    folder = CallbackFolder(mine)
    control = folder.load()["control"]
    (mine / "geometry.py").write_text(GEOMETRY.format(2))
    (mine / "measure.py").write_text("def measure(:\n")
    for _ in range(2):
        with pytest.raises(SyntaxError):
            folder.load()
        assert folder.changed
    with folder.importable():
        assert control(None) == (1, 0)


def test_every_load_begins_anew(mine):
    (mine / "control.py").write_text(
        "calls = []\n\ndef control(step):\n    calls.append(1)\n    return len(calls), 0\n"
    )
    folder = CallbackFolder(mine)
    first, second = folder.load()["control"], folder.load()["control"]
    assert [first(None), first(None), second(None)] == [(1, 0), (2, 0), (1, 0)]


def test_a_folder_is_the_same_from_another_working_folder(mine, tmp_path, monkeypatch):
    use_helper(mine)
    monkeypatch.chdir(tmp_path)
    folder = CallbackFolder("mine")
    control = folder.load()["control"]
    assert control.__code__.co_filename == str(mine / "control.py")
    monkeypatch.chdir("/")
    assert not folder.changed
    (mine / "measure.py").write_text("")
    with pytest.raises(ValueError, match=r"mine/measure\.py must define"):
        folder.load()


@pytest.mark.long
def test_another_thread_waits_for_its_turn(tmp_path):
    for gain, name in enumerate(("anna", "ben")):
        (tmp_path / name).mkdir()
        use_helper(tmp_path / name, gain=gain)
    loaded = []

    def load_ben():
        loaded.append(CallbackFolder(tmp_path / "ben").load()["control"](None))

    anna = CallbackFolder(tmp_path / "anna")
    anna.load()
    with anna.importable():
        thread = threading.Thread(target=load_ben)
        thread.start()
        thread.join(0.2)
        assert importlib.import_module("geometry").gain() == 0
        assert loaded == []
    thread.join(10)
    assert loaded == [(1, 0)]


def test_a_warning_of_the_compiler_is_given_once(mine):
    (mine / "control.py").write_text("def control(step):\n    return step is 1, 0\n")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        CallbackFolder(mine).load()
    (warning,) = caught
    assert warning.category is SyntaxWarning
    assert (warning.filename, warning.lineno) == (str(mine / "control.py"), 2)


def test_a_file_that_ends_the_program_says_where(mine):
    (mine / "control.py").write_text("raise SystemExit\n")
    with pytest.raises(SystemExit) as caught:
        CallbackFolder(mine).load()
    assert caught.value.__notes__ == [f"while loading {mine / 'control.py'}"]


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
    folder = CallbackFolder(mine)
    folder.load()
    assert folder.changed == set()
    times = os.stat(mine / "control.py")
    edit(mine / "control.py", "0.05, -0.05", "0.06, -0.06")
    os.utime(mine / "control.py", ns=(times.st_atime_ns, times.st_mtime_ns))
    assert folder.changed == {"control"}


@pytest.mark.parametrize(
    ("text", "line"), [("x = 1\nx y\n", 2), ("x = 1\nx.y\n", 2), ("ENABLED = 3\n", 1)]
)
def test_an_error_of_a_file_has_its_slot_and_line(mine, text, line):
    (mine / "control.py").write_text(text)
    with pytest.raises(Exception) as caught:  # noqa: PT011
        CallbackFolder(mine).load()
    failed = caught.value.callback
    assert (failed.slot, failed.k, failed.source.number) == ("control", None, line)
    assert failed.source.file == str(mine / "control.py")


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
