"""Share: a clip, and a file from which a run is run again, to the bit."""

import gc
import json

import numpy as np
import pytest

import robsim
from browsers import FakeBrowser
from commands import command
from robsim.gui.hosted import opened
from robsim.gui.panels.replay_file import ReplayFile
from waiting import wait_for

SMALL = {"area": (300, 300), "measure": True, "seed": 3}


def shared(panel):
    """Return the head, the clip and the file that a browser gets."""
    browser = FakeBrowser(panel._view)
    browser.say("share")
    head, (clip, file) = browser.take("shared")
    return head, clip, file


def steps(panel, count):
    for _ in range(count):
        panel.step()


def columns(panel):
    return panel._view.record.columns()


def check_equal(one, other):
    assert one.keys() == other.keys()
    for name in one:
        assert np.array_equal(one[name], other[name], equal_nan=True), name


@pytest.mark.slow
def test_a_run_with_changes_is_the_same_again(tmp_path):
    with robsim.panel(robsim.Simulation(**SMALL)) as panel:
        panel.message("set", name="noise", value="gaussian")
        steps(panel, 3)
        panel.reset()
        steps(panel, 4)
        panel.message("go_to", x=100, y=100)
        panel.step_stage()
        panel.step_stage()
        panel.message("set", name="state", value="default")
        steps(panel, 3)
        head, clip, file = shared(panel)
        (tmp_path / "run.replay").write_bytes(file)
        assert (head["name"], head["lacks"]) == ("run.replay", "")
        assert clip[:4] in (b"\x1aE\xdf\xa3", b"GIF8")
        with robsim.gui.replay(tmp_path / "run.replay") as again:
            check_equal(columns(panel), columns(again))
            assert shared(again)[2] == file


@pytest.mark.slow
def test_the_callbacks_of_a_folder_go_with_it_and_run_when_trusted(folder, tmp_path):
    control = "import helper\n\n\ndef control(step):\n    return {}, helper.U\n"
    (folder / "helper.py").write_text("U = 0.3\n")
    (folder / "control.py").write_text(control.format(0.1))
    with robsim.panel(robsim.Simulation.from_folder(folder, **SMALL)) as panel:
        steps(panel, 3)
        (folder / "control.py").write_text(control.format(0.25))
        wait_for(lambda: "control" in panel._view.runner._folder.changed)
        steps(panel, 3)
        file = tmp_path / "run.replay"
        head, _, content = shared(panel)
        assert head["lacks"] == ""
        file.write_bytes(content)
        with pytest.raises(PermissionError, match=r"helper\.py \(1 line"):
            robsim.gui.replay(file)
        with robsim.gui.replay(file, trust=True) as again:
            check_equal(columns(panel), columns(again))
            assert again.trace.u[:, 0].tolist() == [0.1] * 3 + [0.25] * 3
    refused = command("replay", str(file))  # no answer comes
    assert refused.exit_code == 1
    assert "helper.py, 1 lines" in refused.stdout


@pytest.mark.slow
def test_a_file_that_changes_as_fast_as_it_goes_changes_at_the_same_step(folder, tmp_path):
    control = "def control(step):\n    return {0}, {0}\n"
    (folder / "control.py").write_text(control.format(0.1))
    with robsim.panel(
        robsim.Simulation.from_folder(folder, area=(300, 300), seed=3), speed=float("inf")
    ) as panel:
        panel.start()
        wait_for(lambda: panel._view.driver._chunk > 9)
        (folder / "control.py").write_text(control.format(0.25))
        wait_for(lambda: len(panel.trace) and panel.trace.u[-1, 0] == 0.25)
        panel.pause()
        file = tmp_path / "run.replay"
        head, _, content = shared(panel)
        assert head["lacks"] == ""
        file.write_bytes(content)
        with robsim.gui.replay(file, trust=True) as again:
            check_equal(columns(panel), columns(again))


@pytest.mark.slow
def test_a_file_that_comes_during_the_run_goes_with_it(folder, tmp_path):
    (folder / "measure.py").unlink()
    with robsim.panel(robsim.Simulation.from_folder(folder, **SMALL)) as panel:
        steps(panel, 2)
        (folder / "measure.py").write_text("def measure(step):\n    return None\n")
        steps(panel, 2)
        file = tmp_path / "run.replay"
        head, _, content = shared(panel)
        assert head["lacks"] == ""
        file.write_bytes(content)
        with robsim.gui.replay(file, trust=True) as again:
            assert (
                again.trace.seen.tolist() == panel.trace.seen.tolist() == [True] * 2 + [False] * 2
            )


def test_callbacks_in_another_encoding_are_named_and_the_run_is_still_shared(folder):
    source = "# coding: latin-1\n# \u00e4\ndef control(step):\n    return 0.1, 0.2\n"
    (folder / "control.py").write_bytes(source.encode("latin-1"))
    with robsim.panel(robsim.Simulation.from_folder(folder, **SMALL)) as panel:
        steps(panel, 2)
        head, _, _ = shared(panel)
    assert (head["name"], head["lacks"]) == ("run.npz", "control.py is not in UTF-8")


@pytest.mark.slow
@pytest.mark.parametrize("how", ["cell", "option", "camera", "mine", "replaced", "long"])
def test_what_cannot_be_run_again_is_a_recording(how, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("robsim.gui.panels.run.callbacks.open_in_editor", lambda *_: None)
    simulation = robsim.Simulation(**SMALL)
    if how in ("cell", "replaced"):
        simulation.control = lambda step: (0.1, 0.2)
    what = simulation
    if how == "camera":
        what = robsim.Experiment((simulation.step().frame for _ in range(9)), area=(300, 300))
    with robsim.panel(what) as panel:
        steps(panel, 2)
        if how == "option":
            simulation.noise = robsim.GaussianNoise(5)
        if how == "long":
            monkeypatch.setattr("robsim.gui.panels.replay_file._MOST_STEPS", 2)
        if how == "mine":
            panel.message("make_mine", slot="estimate_state")
        if how == "replaced":
            panel.message("set", name="control", value="spin")
        steps(panel, 1)
        head, _, file = shared(panel)
        (tmp_path / "run.npz").write_bytes(file)
        assert head["name"] == "run.npz"
        assert head["lacks"]
        assert len(robsim.Trace.load(tmp_path / "run.npz")) == 3


def test_a_damaged_file_is_refused(tmp_path):
    good = ReplayFile("format = 1\n", ["control"], {"control": "1/0"}, [[2, "world", {}]], 3, "")
    told = json.loads(good.to_text())
    file = tmp_path / "run.replay"
    wrong = {
        "format": ["robsim replay 2", None],
        "files": [{"../x": ""}, {"a": 1}, []],
        "changes": [[[4, "world", {}]], [[1, 2]], [[0, "world", {"type": "press"}]], [3]],
        "slots": [["nothing"], [{}]],
        "steps": [-1, "3", 10**9],
    }
    texts = [json.dumps(told | {name: value}) for name in wrong for value in wrong[name]]
    for text in ["", "[]", "{", *texts]:
        file.write_text(text)
        with pytest.raises(ValueError, match=r"run\.replay"):
            ReplayFile.load(file)
    file.write_text(json.dumps(told | {"steps": 10**9}))
    with pytest.raises(ValueError, match="more than 1000000 steps"):
        ReplayFile.load(file)
    file.write_text(good.to_text())
    assert ReplayFile.load(file) == good


@pytest.mark.slow
def test_a_run_that_is_too_large_for_a_page_goes_to_the_folder_of_the_user(tmp_path, monkeypatch):
    monkeypatch.setenv("ROBSIM_DATA", str(tmp_path))
    monkeypatch.setattr("robsim.gui.panels.run.share._MOST_SENT", 100)
    with robsim.panel(robsim.Simulation(**SMALL)) as panel:
        steps(panel, 3)
        browser = FakeBrowser(panel._view)
        browser.say("share")
        head, _ = browser.take("note")
    (file,) = (tmp_path / "shared").iterdir()
    assert str(file) in head["text"]
    with robsim.gui.replay(file) as again:
        assert len(again.trace) == 3


@pytest.mark.slow
def test_the_clip_of_a_noisy_run_fits_or_is_left_out(monkeypatch):
    noisy = robsim.Simulation(area=(600, 600), noise=robsim.GaussianNoise(40), seed=1)
    with robsim.panel(noisy) as panel:
        steps(panel, 30)
        head, clip, _ = shared(panel)
        assert head["clip"] == "run.webm"
        assert 10_000 < len(clip) < 30 * 80_000
        monkeypatch.setattr("robsim.gui.panels.run.share._MOST_SENT", 10_000)
        head, clip, file = shared(panel)
        assert (head["name"], head["clip"], len(clip)) == ("run.replay", "", 0)
        assert file


def test_nothing_is_left_of_a_replay(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    good = "def control(step):\n    return 0.1, 0.2\n"
    bad = "def control(step):\n    return 1 / 0\n"
    path = tmp_path / "run.replay"
    panels = [*opened]
    for source in ("1 / 0", bad, good):
        path.write_text(
            ReplayFile("format = 1\n", ["control"], {"control": source}, [], 1, "").to_text()
        )
        if source != good:
            with pytest.raises(ZeroDivisionError):
                robsim.gui.replay(path, trust=True)
        else:
            with pytest.warns(UserWarning, match="differs"):
                again = robsim.gui.replay(path, trust=True)
            assert len([*tmp_path.glob("robsim-replay-*")]) == 1
            again.close()
            del again
            gc.collect()
        assert opened == panels
        assert [*tmp_path.glob("robsim-replay-*")] == []


def test_a_question_shows_the_longest_version_of_a_file(tmp_path):
    change = [2, "world", {"control": "1\n", "helper": "1\n2\n"}]
    file = ReplayFile("format = 1\n", ["control"], {"control": 500 * "1\n"}, [change], 3, "")
    (tmp_path / "run.replay").write_text(file.to_text())
    refused = command("replay", str(tmp_path / "run.replay"))
    assert "control.py, 500 lines" in refused.stdout
    assert "helper.py, 2 lines" in refused.stdout


def test_what_runs_is_what_was_asked_about(tmp_path, monkeypatch):
    files = [ReplayFile("format = 1\n", ["control"], {"control": c}, [], 1, "") for c in "12"]
    path = tmp_path / "run.replay"
    path.write_text(files[0].to_text())
    ran = []

    def confirmed(_):
        path.write_text(files[1].to_text())  # swapped
        return True

    def begun(file, *_):
        ran.append(file.files["control"])
        raise ValueError("enough")

    monkeypatch.setattr("typer.confirm", confirmed)
    monkeypatch.setattr("robsim.gui.replays._begun", begun)
    command("replay", str(path))
    assert ran == ["1"]
