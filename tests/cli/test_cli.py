import json

import numpy as np
import pytest
from PIL import Image

import robsim
from commands import command

pytestmark = [pytest.mark.kernels, pytest.mark.long]

FILES = ["camera.jpg", "traces.png", "parameters.png", "batch.png", "trace.npz"]


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    run = command("demo", "--json", "--out", "made/here", "--seed", "3", cwd=folder)
    assert run.exit_code == 0, run.stderr
    return folder / "made/here", run


def test_the_demo_writes_its_figures_and_its_trace(demo):
    folder, _ = demo
    assert sorted(file.name for file in folder.iterdir()) == sorted(FILES)
    for name in FILES[:4]:
        with Image.open(folder / name) as picture:
            assert min(picture.size) > 500
    trace = robsim.Trace.load(folder / "trace.npz")
    assert len(trace) == 1000
    assert trace.info.identify_from == "measurement"
    assert np.ptp(trace.pose_true[:, :2], axis=0).max() > 300  # it drives
    assert trace.noise.any()


def test_the_numbers_of_the_demo_are_right_and_those_of_its_trace(demo):
    folder, run = demo
    numbers = json.loads(run.stdout)
    assert set(numbers) == {"batch_estimate", "tracking"}
    parameters = numbers["batch_estimate"]["parameters"]
    assert list(parameters) == list(robsim.trace.PARAMETER_NAMES)
    for name, values in parameters.items():
        assert set(values) == {"true", "batch", "standard_error", "online", "excited"}
        if name.startswith("d1"):
            continue
        batch, online = (abs(values[key] / values["true"] - 1) for key in ("batch", "online"))
        assert batch < 0.005  # without bias, though the poses are noisy
        assert batch < online < 0.5
        assert abs(values["batch"] - values["true"]) < 4 * values["standard_error"]
    trace = robsim.Trace.load(folder / "trace.npz")
    error = trace.error[trace.seen]
    tracking = numbers["tracking"]
    numbers = ("steps", "seen", "not_seen", "false_poses", "rmse_xy", "rmse_heading_deg")
    numbers += ("reported_xy", "reported_heading_deg", "remarks")
    numbers += ("median_xy", "median_heading_deg", "largest_xy", "largest_heading_deg")
    assert set(tracking) == {"title", "units", *numbers}
    assert tracking["units"]["rmse_xy"] == "px"
    assert (tracking["steps"], tracking["seen"], tracking["false_poses"]) == (
        1000,
        trace.seen.sum(),
        0,
    )
    assert tracking["seen"] > 990
    assert tracking["rmse_xy"] == pytest.approx(np.sqrt((error[:, :2] ** 2).sum(axis=1).mean()))
    assert tracking["rmse_xy"] < 0.6
    assert tracking["rmse_heading_deg"] < 0.6


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_the_demo_prints_the_table_and_keeps_progress_out_of_a_log(tmp_path):
    run = command("demo", "--out", str(tmp_path), "--steps", "120")
    assert run.exit_code == 0
    assert "120/120" not in run.stderr
    for word in ("true", "online", "batch", "off by", "std. error", "not biased"):
        assert word in run.stdout
    for name in robsim.trace.PARAMETER_NAMES:
        assert f" {name} " in run.stdout
    assert max(map(len, run.stdout.splitlines()[:-1])) <= 100
    assert "e+" not in run.stdout  # an error of 120 %, not of 1.2e+02 %
    assert f"written to {tmp_path}" in run.stdout


def test_an_out_folder_that_is_a_file(tmp_path):
    (tmp_path / "file").write_text("mine")
    run = command("demo", "--out", "file", cwd=tmp_path)
    assert run.exit_code == 2
    assert "error:" in run.stderr
    assert "Traceback" not in run.stderr
    assert (tmp_path / "file").read_text() == "mine"


def test_help_and_version():
    text = command("--help").stdout
    assert "demo" in text
    assert "--version" in text
    text = command("demo", "--help").stdout
    for option in ("--out", "--steps", "--seed", "--json"):
        assert option in text
    assert command("--version").stdout == f"robsim {robsim.__version__}\n"
