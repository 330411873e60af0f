"""The list of callbacks in a panel: whose they are, where they stand, their times and errors."""

import functools
import inspect
import json
import os
import subprocess
import sys
import textwrap
import threading
import time

import pytest

import robsim
from robsim.gui.panels import editor as lab
from robsim.gui.panels.code_colors import code_colors
from waiting import wait_for

pytestmark = pytest.mark.long

SIZE = (240, 240)


def small(**options):
    return robsim.Simulation(resolution=SIZE, seed=1, **options)


def slot(watcher, name):
    return next(one for one in watcher.newest("callbacks")["slots"] if one["slot"] == name)


def source(watcher, name):
    watcher.say("source", slot=name)
    watcher.settle()
    return watcher.newest("source")


def control(step):
    return 0.1, 0.2


class Measurer:
    """Measures."""

    def __call__(self, step):
        return None


def test_all_slots_in_the_order_of_their_calls(watch):
    watcher = watch(small(control=control, measure=Measurer(), estimate_parameters=True))
    slots = watcher.newest("callbacks")["slots"]
    assert [one["slot"] for one in slots] == list(robsim.Simulation.SLOTS)
    assert [one["when"] for one in slots] == ["once"] * 3 + ["step"] * 5
    owners = {one["slot"]: one["owner"] for one in slots}
    assert [name for name, owner in owners.items() if owner == "mine"] == ["measure", "control"]
    assert [name for name, owner in owners.items() if owner == "off"] == ["estimate_state"]
    names = {one["slot"]: one["name"] for one in slots}
    assert (names["control"], names["measure"]) == ("control", "Measurer")
    assert names["estimate_state"] is None
    assert names["estimate_parameters"] == "step.estimator.update"


def test_an_experiment_has_the_slots_of_its_robot(watch):
    watcher = watch(robsim.Experiment([None], control=control))
    names = [one["slot"] for one in watcher.newest("callbacks")["slots"]]
    assert names == [name for name in robsim.Simulation.SLOTS if name in robsim.Experiment.SLOTS]


def test_where_a_callback_stands(watch):
    watcher = watch(small(control=control, evaluate_model=functools.partial(move, 1)))
    found = slot(watcher, "control")
    assert (found["file"], found["line"]) == (__file__, control.__code__.co_firstlineno)
    assert found["can_edit"]
    assert found["link"] is None
    assert slot(watcher, "evaluate_model")["line"] == move.__code__.co_firstlineno
    assert (slot(watcher, "measure")["file"], slot(watcher, "measure")["can_edit"]) == (None, False)


def move(a, world):
    return world.pose_1


def test_calls_are_counted_and_timed_also_while_it_runs(watch, monkeypatch):
    monkeypatch.setattr("robsim.gui.panels.run.callbacks._GAP", 0.1)

    def slow(step):
        time.sleep(0.002)  # it takes at least that
        return 0.1, 0.2

    sim = small(control=slow, measure=True)
    watcher = watch(sim, speed=float("inf"))
    watcher.press("start")
    wait_for(lambda: slot(watcher, "control")["calls"] > 5)
    watcher.press("pause")
    found = slot(watcher, "control")
    assert found["calls"] == sim.n_steps
    assert found["ms"] >= 2.0
    assert (slot(watcher, "measure")["calls"], slot(watcher, "measure")["ms"]) == (0, None)


def test_the_update_of_a_users_estimator_is_timed_until_the_panel_is_closed(watch):
    class Estimator:
        def update(self, phi, y):
            return phi * 0.0

    sim = small(init_parameter_estimator=lambda model: Estimator())
    watcher = watch(sim)
    for _ in range(3):
        watcher.press("step")
    assert slot(watcher, "estimate_parameters")["calls"] == 3
    assert slot(watcher, "init_parameter_estimator")["calls"] == 1
    watcher.view.close()
    assert sim._call_times is None


def test_timing_changes_neither_notes_nor_place_of_an_error(watch):
    sims = [small(control=lambda step: step.estimate.pose) for _ in range(2)]
    watch(sims[0])
    errors = []
    for sim in sims:
        with pytest.raises(AttributeError) as caught:
            sim.step()
        errors.append(caught.value)
    timed, plain = errors
    assert timed.__notes__ == plain.__notes__
    assert timed.callback == plain.callback


def test_an_error_stands_at_its_slot_until_the_run_goes_on(watch):
    broken = [True]

    def fails(step):
        if step.k == 2 and broken:
            raise ValueError("no way")
        return 0.0, 0.0

    watcher = watch(small(control=fails))
    for _ in range(3):
        watcher.press("step")
    line = inspect.getsourcelines(fails)[1] + 2
    error = slot(watcher, "control")["error"]
    assert error == {"text": "ValueError: no way", "line": line, "k": 2}
    assert slot(watcher, "measure")["error"] is None
    broken.clear()
    watcher.press("step")
    assert slot(watcher, "control")["error"] is None


def test_sources(watch):
    watcher = watch(small(control=control, measure=Measurer()))
    assert source(watcher, "control")["text"] == inspect.getsource(control)
    assert source(watcher, "control")["first"] == control.__code__.co_firstlineno
    assert source(watcher, "measure")["text"].startswith("class Measurer:\n")
    example = source(watcher, "estimate_state")
    assert example["file"] is None
    compile(example["text"], "example", "exec")
    watcher.say("source", slot="../control")
    watcher.settle()
    assert "../control" in watcher.notes()[0]
    made = {}
    exec("def control(step):\n    return 0, 0\n", made)
    assert "not known" in source(watch(small(control=made["control"])), "control")["text"]


@pytest.mark.slow
def test_the_source_of_a_cell():
    pytest.importorskip("ipykernel")
    code = """
        from IPython.core.interactiveshell import InteractiveShell
        from ipykernel.compiler import XCachingCompiler
        import robsim
        shell = InteractiveShell(compiler_class=XCachingCompiler)
        shell.run_cell("class C:\\n  def __call__(self, step): return None\\nm = C()")
        shell.run_cell("#\\ndef control(step):\\n    return 0, 0")
        m, control = shell.user_ns["m"], shell.user_ns["control"]
        with robsim.panel(robsim.Simulation(measure=m, control=control)) as panel:
            (told,) = panel.message("source", slot="control")
            assert told["text"] == "def control(step):\\n    return 0, 0\\n"
            assert (told["file"], told["first"]) == (None, 2)
            (told,) = panel.message("source", slot="measure")
            assert "def __call__(self, step): return None" in told["text"]
    """
    subprocess.run([sys.executable, "-c", textwrap.dedent(code)], check=True, timeout=300)


def test_a_file_of_a_folder_also_while_it_is_off(watch, folder):
    watcher = watch(robsim.Simulation.from_folder(folder, resolution=SIZE, seed=1))
    assert slot(watcher, "measure")["owner"] == "off"
    assert slot(watcher, "measure")["file"] == str(folder / "measure.py")
    assert slot(watcher, "control")["owner"] == "mine"
    told = source(watcher, "measure")
    assert (told["text"], told["first"]) == ((folder / "measure.py").read_text(), 1)


def edited(folder, u1):
    (folder / "control.py").write_text(f"def control(step):\n    return {u1}, 0.5\n")


def test_an_edited_file_is_used_while_it_runs(watch, folder):
    sim = robsim.Simulation.from_folder(folder, resolution=SIZE, seed=1)
    watcher = watch(sim, speed=100)
    watcher.press("start")
    wait_for(lambda: sim.n_steps > 3)
    edited(folder, 0.25)
    wait_for(lambda: sim.trace.u[-1, 0] == 0.25)
    edited(folder, "0.25 +")
    wait_for(lambda: watcher.view.driver.state == "failed")
    watcher.settle()
    error = slot(watcher, "control")["error"]
    assert (error["line"], error["k"]) == (2, None)
    assert error["text"].startswith("SyntaxError")
    watcher.press("start")  # still the same
    wait_for(lambda: watcher.view.driver.state == "failed")
    edited(folder, 0.75)
    watcher.press("start")
    wait_for(lambda: sim.trace.u[-1, 0] == 0.75)
    watcher.settle()
    assert slot(watcher, "control")["error"] is None


@pytest.mark.parametrize(
    ("name", "is_told"),
    [("control", True), ("estimate_parameters", True), ("measure", False)],  # which was off before
)
def test_a_file_that_is_gone_is_told_once(watch, folder, name, is_told):
    updates = folder / "estimate_parameters.py"
    updates.write_text("def estimate_parameters(step):\n    return None\n")
    options = {"resolution": SIZE, "seed": 1, "identify_from": "truth", "control": None}
    watcher = watch(robsim.Simulation.from_folder(folder, **options))
    watcher.press("step")
    assert watcher.notes() == []
    (folder / f"{name}.py").unlink()
    watcher.press("step")
    watcher.press("step")
    assert [f"{name}.py" in note for note in watcher.notes()] == [True] * is_told


def test_a_file_that_cannot_be_loaded(watch, folder):
    watcher = watch(robsim.Simulation.from_folder(folder, resolution=SIZE, seed=1))
    (folder / "helper.py").write_text("1 / 0\n")
    texts = {"x = 1\nx.y\n": 2, "import helper\n": 1, "def contrl(step):\n    return 0, 0\n": 1}
    for text, line in texts.items():
        (folder / "control.py").write_text(text)
        watcher.press("step")
        assert slot(watcher, "control")["error"]["line"] == line


posix = pytest.mark.skipif(os.name == "nt", reason="starts a script")


def editor(tmp_path, name, text):
    """Write a program that stands for an editor."""
    program = tmp_path / name
    program.write_text(f"#!{sys.executable}\n{text}")
    program.chmod(0o755)
    return program


@pytest.fixture
def bare(monkeypatch):
    """A Linux without a screen, and without an editor that is chosen."""
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("EDITOR", "VISUAL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


@posix
@pytest.mark.parametrize(
    ("command", "wanted"),
    [
        ("code --wait", "--wait|--goto|{file}:{line}"),
        ("myedit --wait", "--wait|{file}"),  # nobody knows how it is told a line
        ("emacs", "+{line}|{file}"),
    ],
)
def test_edit_opens_the_file_in_any_editor_on_the_path(
    watch, tmp_path, monkeypatch, command, wanted
):
    told = tmp_path / "told"
    text = f"import sys; open({str(told)!r}, 'w').write('|'.join(sys.argv[1:]))"
    editor(tmp_path, command.split()[0], text)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("VISUAL", command)
    watcher = watch(small(control=control))
    watcher.say("edit", slot="control")
    wait_for(lambda: told.is_file() and told.read_text())
    line = control.__code__.co_firstlineno
    assert told.read_text() == wanted.format(file=__file__, line=line)
    assert watcher.notes() == []


@posix
def test_an_editor_in_a_terminal_or_none_is_not_started(bare, watch, tmp_path, monkeypatch):
    for name in ("nano", "emacs", "emacsclient"):
        editor(tmp_path, name, "")
    (tmp_path / "editor").symlink_to(tmp_path / "nano")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(subprocess, "Popen", None)
    monkeypatch.setattr("robsim.gui.panels.run.callbacks._GAP", 0.0)
    watcher = watch(small(control=control))
    for command in ("nano", "emacs -nw", "emacsclient -t", "editor", "missing", "'unclosed", ""):
        monkeypatch.setenv("VISUAL", command)
        watcher.say("edit", slot="control")
        watcher.settle()
        assert "VISUAL" in watcher.notes()[-1]
    watcher.say("edit", slot="measure")
    watcher.settle()
    assert len(watcher.notes()) == 8
    assert watcher.notes()[-1].startswith("measure ")


@posix
def test_a_key_that_is_held_opens_one_editor(watch, monkeypatch):
    started = []
    opened = "robsim.gui.panels.run.callbacks.open_in_editor"
    monkeypatch.setattr(opened, lambda *place: started.append(place))
    monkeypatch.setattr("robsim.gui.panels.run.callbacks._GAP", 1000.0)
    watcher = watch(small(control=control))
    for _ in range(100):
        watcher.say("edit", slot="control")
    watcher.settle()
    assert len(started) == 1


@posix
def test_an_editor_that_fails_is_told(watch, tmp_path, monkeypatch):
    monkeypatch.setenv("VISUAL", str(editor(tmp_path, "gedit", "raise SystemExit(4)")))
    monkeypatch.setattr("robsim.gui.panels.run.callbacks._GAP", 0.05)
    watcher = watch(small(control=control))
    watcher.say("edit", slot="control")
    wait_for(lambda: watcher.notes())
    assert "VISUAL" in watcher.notes()[0]


def test_a_link_for_the_lab_alone(watch, tmp_path, folder, monkeypatch):
    runtime = tmp_path / "runtime"
    runtime.mkdir()
    (runtime / "jpserver-4711.json").write_text(
        json.dumps({"root_dir": str(tmp_path), "base_url": "/user/me/"})
    )
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(runtime))
    monkeypatch.setenv("JPY_PARENT_PID", "4711")
    pytest.importorskip("jupyter_core")
    lab._server.cache_clear()
    try:
        watcher = watch(robsim.Simulation.from_folder(folder, resolution=SIZE, seed=1))
        assert slot(watcher, "control")["link"] is None  # on a page
        watcher.is_in_notebook = True
        watcher.say("hello", width=100)
        watcher.settle()
        assert slot(watcher, "control")["link"] == "/user/me/lab/tree/mine/control.py"
        assert lab.lab_link(tmp_path.parent / "other.py") is None
    finally:
        lab._server.cache_clear()


@pytest.mark.filterwarnings("ignore:step 0. control gave")
def test_an_implausible_result_is_noted_once_per_run(watch):
    watcher = watch(small(control=lambda step: (1e6, 0)))

    def noted():
        watcher.settle()
        return [note["text"] for note in watcher.of("note") if note["level"] == "warning"]

    for runs in (1, 2):
        for _ in range(2):
            watcher.say("press", button="step")
        assert len(noted()) == runs
        assert "1000000" in noted()[-1]
        watcher.say("press", button="reset")


def test_a_default_becomes_a_file_of_the_users_that_drives(watch, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("robsim.gui.panels.run.callbacks.open_in_editor", lambda *_: None)
    sim = small()
    watcher = watch(sim)
    assert slot(watcher, "control")["can_make"]
    watcher.say("make_mine", slot="control")
    watcher.settle()
    file = tmp_path / "mine" / "control.py"
    told = watcher.newest("source")
    assert (told["file"], told["text"]) == (str(file), file.read_text())
    assert slot(watcher, "control")["owner"] == "mine"
    assert not slot(watcher, "control")["can_make"]
    watcher.press("step")
    watcher.say("make_mine", slot="measure")
    watcher.settle()
    assert slot(watcher, "measure")["owner"] == "mine"  # whose template is switched off
    watcher.say("make_mine", slot="define_model")  # which has been called
    watcher.settle()
    assert slot(watcher, "define_model")["owner"] == "default"
    watcher.press("reset")
    watcher.press("step")
    assert slot(watcher, "define_model")["owner"] == "mine"


def test_parts_of_code_have_their_kinds():
    lines = code_colors('def f(x):\n    """One\n    two."""\n    return 1 + len(x)  # "no"\n')
    assert (4, 5, "name") in lines[0]
    assert lines[1][0][::2] == (4, "string")
    assert lines[2][0] == (0, 11, "string")
    assert [kind for *_, kind in lines[3]] == ["keyword", "number", "builtin", "comment"]
    assert code_colors("x = '\n1")[0] == []  # while it is written


def test_the_last_lines_that_callbacks_print_are_told(watch, capsys):
    def chatty(step):
        for i in range(300):
            print(step.k, i)
        print("no end", end="")
        return 0.0, 0.0

    watcher = watch(small(control=chatty))
    watcher.press("step")
    wait_for(lambda: watcher.newest("printed")["lines"])
    lines = watcher.newest("printed")["lines"]
    assert (len(lines), lines[-1]) == (100, ["control", "0 299"])
    assert "0 299\nno end" in capsys.readouterr().out
    watcher.press("reset")
    wait_for(lambda: not watcher.newest("printed")["lines"])


def test_a_file_that_does_not_load_leaves_the_callback(watch, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "control.py").write_text("ENABLED = False\nassert not ENABLED\n")
    runner = robsim.Simulation.from_folder(
        tmp_path, slots="control", resolution=SIZE, control=control
    )
    watcher = watch(runner)
    watcher.say("make_mine", slot="control")
    watcher.settle()
    watcher.settle()
    assert [note["level"] for note in watcher.of("note")] == ["error"]
    assert runner._given["control"] is control


def test_a_program_without_a_terminal_may_print(watch, monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    watcher = watch(small(control=lambda step: print("hi") or (0, 0)))
    watcher.press("step")
    wait_for(lambda: watcher.view.runner.n_steps or watcher.view.driver.error)
    assert watcher.view.driver.error is None


def test_the_terminal_is_given_back_though_a_callback_does_not_end(watch):
    there, may_end = threading.Event(), threading.Event()

    def waits(step):
        there.set()
        may_end.wait(300)
        return 0.0, 0.0

    before = sys.stdout
    watcher = watch(small(control=waits))
    watcher.say("press", button="step")
    assert there.wait(300)
    assert sys.stdout is not before
    assert not watcher.view.close(0.1)
    assert sys.stdout is before
    may_end.set()


@pytest.mark.slow
def test_the_doctor_names_the_line(watch, tmp_path):
    (tmp_path / "control.py").write_text(
        "def control(step):\n    print('hi')\n    return step.measurement.pose[:2]\n"
    )
    watcher = watch(robsim.Simulation.from_folder(tmp_path, resolution=SIZE))
    watcher.say("check", slot="control")
    wait_for(lambda: watcher.of("remarks"))
    remarks = watcher.newest("remarks")
    assert remarks["slot"] == "control"
    assert 3 in [number for number, _ in remarks["lines"]]


@pytest.mark.slow
def test_the_doctor_says_that_a_callback_passes(watch, tmp_path):
    (tmp_path / "measure.py").write_text(
        "import robsim\n\n\n"
        "def measure(step):\n"
        "    return robsim.locate(\n"
        "        step.blobs, step.markers, image=step.frame, colors=step.colors\n"
        "    )\n"
    )
    watcher = watch(robsim.Simulation.from_folder(tmp_path, resolution=SIZE))
    watcher.say("check", slot="measure")
    wait_for(lambda: watcher.of("remarks"))
    assert watcher.newest("remarks")["said"] == ["passed all checks"]
